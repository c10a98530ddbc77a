"""Coarser hulls and other rounding radii of a body."""

from __future__ import annotations

from itertools import combinations

import ifa
import numpy as np
import pytest

MATERIAL = ("restitution", "friction", "rolling_friction_m", "spin_friction_m")


def gap(points, kept):
    """How far a point is from the nearest one kept, at most."""
    return np.linalg.norm(points[:, None] - kept[None], axis=2).min(axis=1).max()


def volume(body):
    return ifa._core.rounded_hull_mass_properties(
        body.vertices_m, body.radius_m, 1.0, body.rings_m
    )[0]


@pytest.mark.parametrize("name", ["eraser", "coin", "coffee_cup"])
def test_a_coarser_hull_keeps_all_but_vertices(name):
    body = ifa.bodies.get(name)
    for points in (4, 7, 20):
        coarse = body.with_hull_detail(points)
        assert len(coarse.vertices_m) <= points and not len(coarse.rings_m)
        outline = {tuple(point) for point in body.outline_m.tolist()}
        assert {tuple(point) for point in coarse.vertices_m.tolist()} <= outline
        for field in ("name", "radius_m", "mass_kg", *MATERIAL):
            assert getattr(coarse, field) == getattr(body, field)
        np.testing.assert_array_equal(coarse.inertia_kg_m2, body.inertia_kg_m2)


def test_all_vertices_are_the_body_itself():
    body = ifa.bodies.get("eraser")
    count = len(body.vertices_m)
    assert body.with_hull_detail(count) is body
    assert body.with_hull_detail(10 * count) is body
    coin = ifa.bodies.get("coin")  # no number of corners is a circle
    assert coin.with_hull_detail(10_000) is not coin


def test_no_choice_leaves_half_as_large_a_gap():
    """Against every choice of as many points, of a handful of random ones."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        points = rng.normal(size=(9, 3))
        body = ifa.Body.from_vertices(points, mass_kg=1.0, inertia_kg_m2=1.0)
        points = body.vertices_m
        for count in range(4, len(points)):
            kept = body.with_hull_detail(count).vertices_m
            best = min(
                gap(points, points[list(rows)]) for rows in combinations(range(len(points)), count)
            )
            assert gap(points, kept) <= 2.0 * best + 1e-12  # roundings of distances of about 1


@pytest.mark.parametrize("own_m", [0.0, 0.002, 0.004])
@pytest.mark.parametrize("radius_m", [0.0, 0.001, 0.005])
def test_a_box_is_rounded_within_its_faces(own_m, radius_m):
    """Its size stays; its volume is Steiner's for the box within, grown by the radius."""
    size_m = np.array([0.02, 0.03, 0.05])
    body = ifa.Body.box(size_m, mass_kg=0.1, radius_m=own_m, restitution=0.3)
    other = body.with_rounding(radius_m)
    reach_m = other.vertices_m.max(axis=0) - other.vertices_m.min(axis=0) + 2.0 * radius_m
    np.testing.assert_allclose(reach_m, size_m, rtol=1e-12)
    a, b, c = size_m - 2.0 * radius_m
    steiner = (
        a * b * c + 2.0 * (a * b + b * c + c * a) * radius_m
        + np.pi * (a + b + c) * radius_m**2 + 4.0 / 3.0 * np.pi * radius_m**3
    )  # fmt: skip
    assert volume(other) == pytest.approx(steiner, rel=1e-9)
    assert len(other.vertices_m) == 8
    assert (other.mass_kg, other.restitution) == (body.mass_kg, body.restitution)
    np.testing.assert_array_equal(other.inertia_kg_m2, body.inertia_kg_m2)


def test_faces_of_any_hull_stay():
    """Every face of a random hull is a supporting plane of the other one too."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        points = rng.normal(size=(12, 3))
        body = ifa.Body.from_vertices(points, mass_kg=1.0)
        a, b, c = (body.vertices_m[body.triangles[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        distances = (normals * a).sum(axis=1)
        radius_m = 0.3 * distances.min()
        other = body.with_rounding(radius_m)
        reach = (other.vertices_m @ normals.T).max(axis=0) + radius_m
        assert (reach <= distances + 1e-12).all()  # roundings of distances of about 1
        # A small face may be lost between its neighbours as they move in; most are not.
        assert np.isclose(reach, distances, rtol=1e-9).mean() > 0.5


def test_a_cylinder_keeps_its_size():
    coin = ifa.bodies.get("coin")
    radius_m = 0.5 * coin.radius_m
    other = coin.with_rounding(radius_m)
    for k in range(len(coin.rings_m)):
        ring, new = coin.rings_m[k], other.rings_m[k]
        assert new[6] + radius_m == pytest.approx(ring[6] + coin.radius_m, rel=1e-12)
        height = abs(ring[:3] @ ring[3:6]) + coin.radius_m
        assert abs(new[:3] @ new[3:6]) + radius_m == pytest.approx(height, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "radius_m", "words"),
    [
        ("ball", 0.001, "hull without volume"),
        ("d6", 1.0, "radius_m: must be less than"),
        ("d6", -0.001, "radius_m: must be finite and 0 or more"),
        ("d6", float("nan"), "radius_m: must be finite and 0 or more"),
        ("coin", 0.1, "leaves nothing"),
    ],
)
def test_radii_that_leave_no_body(name, radius_m, words):
    with pytest.raises(ifa.IfaValueError, match=words):
        ifa.bodies.get(name).with_rounding(radius_m)


def test_points_that_make_no_body():
    with pytest.raises(ifa.IfaValueError, match="points: must be a whole number from 1"):
        ifa.bodies.get("d6").with_hull_detail(0)
    sharp = ifa.Body.box([0.01, 0.02, 0.03], mass_kg=0.1)
    with pytest.raises(ifa.IfaValueError):
        sharp.with_hull_detail(2)
