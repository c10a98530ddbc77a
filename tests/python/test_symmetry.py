"""Symmetry groups of the library's bodies, and what they say of motions."""

import math

import ifa
import numpy as np
import pytest

GROUPS = {
    "d4": ("Td", 24), "d6": ("Oh", 48), "d8": ("Oh", 48), "d10": ("D5d", 20), "d12": ("Ih", 120),
    "d20": ("Ih", 120), "ball": ("Kh", math.inf), "coin": ("Dinfh", math.inf),
    "eraser": ("D2h", 8), "card": ("D2h", 8),
}  # fmt: skip


def test_groups_of_the_library():
    for name in GROUPS:
        symmetry = ifa.bodies.get(name).symmetry
        assert (symmetry.name, symmetry.order) == GROUPS[name], name


@pytest.mark.parametrize("name", ["d4", "d10", "d20", "card"])
def test_elements_carry_vertices_and_inertia_onto_themselves(name):
    # turned, so that principal axes are not the body's
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    body = ifa.bodies.get(name)
    inertia = turn @ body.inertia_kg_m2 @ turn.T
    body = body.replace(vertices_m=body.vertices_m @ turn.T, inertia_kg_m2=inertia)
    elements = body.symmetry.elements
    assert elements.shape == (GROUPS[name][1], 3, 3)
    size = np.linalg.norm(body.vertices_m, axis=1).max()
    for g in elements:
        images = body.vertices_m @ g.T
        apart = np.linalg.norm(images[:, None] - body.vertices_m[None], axis=2).min(axis=1)
        assert apart.max() < 1e-12 * size  # rounding
        assert np.abs(g @ inertia @ g.T - inertia).max() < 1e-12 * inertia.max()


def test_axis_and_what_is_left_of_a_coin():
    symmetry = ifa.bodies.get("coin").symmetry
    assert np.allclose(np.abs(symmetry.axis), [0.0, 0.0, 1.0], atol=1e-15)  # rounding
    assert symmetry.elements.shape == (4, 3, 3)
    assert np.array_equal(symmetry.elements[0], np.eye(3))
    assert np.linalg.det(symmetry.elements) == pytest.approx([1, 1, -1, -1], abs=1e-14)
    assert ifa.bodies.get("ball").symmetry.axis is None
    assert ifa.bodies.get("d6").symmetry.axis is None


def test_elements_cannot_be_written():
    with pytest.raises(ValueError):
        ifa.bodies.get("d6").symmetry.elements[0, 0, 0] = 2.0
