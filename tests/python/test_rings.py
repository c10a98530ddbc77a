"""Circular edges of bodies: shape, mass properties, files, drawing, simulation."""

import pickle

import ifa
import numpy as np
import pytest

RIM_M, HALF_M, ROUNDING_M = 12.675e-3, 0.9e-3, 0.2e-3


def two_rings(half=HALF_M, rim=RIM_M, axis=(0.0, 0.0, 1.0)):
    unit = np.array(axis) / np.linalg.norm(axis)
    return [[*(z * unit), *axis, rim] for z in (half, -half)]


def rounded_cylinder(rim, half, rounding):
    """Volume, moment about the axis and across it at density 1, from slices across the axis.

    The end caps by Gauss-Legendre over the angle of their arc: exact to rounding with 40 points.
    """
    x, weight = np.polynomial.legendre.leggauss(40)
    angle = 0.25 * np.pi * (x + 1.0)
    z = np.concatenate([0.5 * half * (x + 1.0), half + rounding * np.sin(angle)])
    dz = np.concatenate([0.5 * half * weight, rounding * np.cos(angle) * 0.25 * np.pi * weight])
    r = np.concatenate([np.full(40, rim + rounding), rim + rounding * np.cos(angle)])
    volume = 2.0 * np.sum(np.pi * r**2 * dz)
    along = 2.0 * np.sum(0.5 * np.pi * r**4 * dz)
    across = 2.0 * np.sum((0.25 * np.pi * r**4 + np.pi * r**2 * z**2) * dz)
    return volume, along, across


@pytest.mark.parametrize("rounding", [0.0, 0.2e-3, 3e-3])
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 3.0, 4.0)])
def test_mass_properties_are_those_of_the_solid_of_revolution(rounding, axis):
    body = ifa.Body.from_vertices([], rounding, two_rings(axis=axis), mass_kg=0.01)
    volume, along, across = rounded_cylinder(RIM_M, HALF_M, rounding)
    n = np.array(axis) / np.linalg.norm(axis)
    expected = 0.01 / volume * (across * np.eye(3) + (along - across) * np.outer(n, n))
    # what two polygons leave of the circle: (2 pi / 512)^4 / 100
    assert np.allclose(body.inertia_kg_m2, expected, rtol=0, atol=1e-9 * expected.max())
    assert np.allclose(body.centre_of_mass_m, 0.0, atol=1e-15)


def test_cone_has_its_closed_form():
    # a ring and an apex: centre of mass at a quarter of the height, moments 3/10 m r^2 about the
    # axis and 3/80 m (4 r^2 + h^2) across it
    r, h, m = 0.02, 0.05, 0.1
    cone = ifa.Body.from_vertices([[0.0, 0.0, h]], 0.0, [[0, 0, 0, 0, 0, 1, r]], mass_kg=m)
    across = 3.0 / 80.0 * m * (4.0 * r**2 + h**2)
    expected = np.diag([across, across, 0.3 * m * r**2])
    assert np.allclose(cone.centre_of_mass_m, (0.0, 0.0, h / 4.0), rtol=0, atol=1e-9 * h)
    assert np.allclose(cone.inertia_kg_m2, expected, rtol=0, atol=1e-9 * across)
    assert len(cone.vertices_m) == 1


def test_vertices_within_the_rings_are_dropped():
    angle = np.arange(7)[:, None]
    rim = RIM_M * np.hstack([np.cos(angle), np.sin(angle), 0.0 * angle])
    rim[:, 2] = HALF_M
    inside = [[0.0, 0.0, 0.0], [0.5 * RIM_M, 0.0, HALF_M], *rim]
    outside = [0.0, 0.0, 2.0 * HALF_M]
    body = ifa.Body.from_vertices(
        [*inside, outside], 0.0, two_rings(), mass_kg=0.01, inertia_kg_m2=1e-6
    )
    assert body.vertices_m.tolist() == [outside]


@pytest.mark.parametrize(
    ("rings", "message"),
    [
        ([[0, 0, 0, 0, 0, 1, 1], [0, 0, 0, 0, 0, 0, 1]], "row 1: its axis must not be zero"),
        ([[0, 0, 0, 0, 0, 1, 0]], "row 0: its radius must be above 0"),
        ([[0, np.inf, 0, 0, 0, 1, 1]], "row 0 has a number that is not finite"),
        ([[0, 0, 0, 0, 0, 1, 1]] * 9, "there are 9 circular edges, at most 8 are possible"),
    ],
)
def test_rings_that_cannot_be_are_refused(rings, message):
    for inertia in (None, 1.0):
        with pytest.raises(ifa.IfaValueError, match=f"^rings_m: {message}"):
            ifa.Body.from_vertices([], 0.1, rings, mass_kg=1.0, inertia_kg_m2=inertia)


def test_round_trips(tmp_path):
    body = ifa.Body.from_vertices(
        [[0.0, 0.0, 0.01]], 1e-4, [[0.001, 0.0, 0.0, 0.0, 0.0, 2.0, 0.02]], mass_kg=0.01
    )
    assert np.array_equal(body.rings_m[:, 3:], [[0.0, 0.0, 1.0, 0.02]])
    assert np.allclose(body.rings_m[:, :3] + body.centre_of_mass_m, [[0.001, 0.0, 0.0]], atol=1e-17)
    body.write(tmp_path / "b.json")
    for again in (
        ifa.Body.read(tmp_path / "b.json"),
        pickle.loads(pickle.dumps(body)),
        body.replace(),
    ):
        assert again.to_dict() == body.to_dict()
    assert "1 vertices, 1 rings" in repr(body)
    wider = body.replace(rings_m=[[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.03]])
    assert wider.rings_m[0, 6] == 0.03
    with pytest.raises(ifa.IfaValueError, match="vertices_m"):
        body.replace(vertices_m=[], rings_m=None)


def test_a_disc_without_rounding_needs_an_inertia():
    disc = [[0, 0, 0, 0, 0, 1, 0.02]]
    with pytest.raises(ifa.IfaValueError, match="rings_m: their hull has no volume"):
        ifa.Body.from_vertices([], 0.0, disc, mass_kg=0.01)
    body = ifa.Body.from_vertices([], 0.0, disc, mass_kg=0.01, inertia_kg_m2=[1e-6, 1e-6, 2e-6])
    run = ifa.simulate(body, ifa.State((0, 0, 0.1), (0.9, 0.3, 0.1, 0.0)))
    assert run.status == "rest"
    assert run.states.position_m[-1, 2] == pytest.approx(0.0, abs=1e-9)  # flat on the ground


def test_outline_and_triangles_are_for_drawing():
    coin = ifa.bodies.get("coin")
    assert coin.outline_m.shape == (144, 3)
    assert np.allclose(np.hypot(*coin.outline_m[:, :2].T), RIM_M, rtol=1e-14)
    a, b, c = (coin.outline_m[coin.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    polygon = 36.0 * RIM_M**2 * np.sin(2.0 * np.pi / 72)  # area of 72 corners
    assert volume == pytest.approx(2.0 * HALF_M * polygon, rel=1e-12)


@pytest.mark.parametrize("engine", ["event", "ode"])
def test_a_thrown_coin_comes_to_rest_on_a_face(engine):
    coin = ifa.bodies.get("coin")
    state = ifa.State((0, 0, 0.05), (0.98, 0.15, 0.1, 0.0), (0.1, 0, 0), (1.0, 2.0, 3.0))
    run = ifa.simulate(coin, state, engine=engine, until_s=60.0)
    assert run.status == "rest"
    # half its thickness; ODE's contacts are soft: 1e-3 of the size
    tolerance = 1e-9 if engine == "event" else 2e-5
    assert run.states.position_m[-1, 2] == pytest.approx(1.1e-3, abs=tolerance)


def test_a_coin_below_the_ground_is_refused():
    coin = ifa.bodies.get("coin")
    upright = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
    ifa.simulate(coin, ifa.State((0, 0, 12.875e-3), upright), until_s=0.01)
    with pytest.raises(ifa.IfaValueError, match="position_m: the body begins"):
        ifa.simulate(coin, ifa.State((0, 0, 12.8e-3), upright))


def test_every_sampled_coin_comes_to_rest():
    coin = ifa.bodies.get("coin")
    batch = ifa.simulate_batch(coin, ifa.sample_states(coin, 200, seed=5), until_s=60.0)
    # the fastest rolls away at 1.3 m/s and loses 0.025 m/s each second
    assert (np.asarray(batch.status) == 0).all()
