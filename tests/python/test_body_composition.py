"""Mass properties of parts against closed forms, trimesh, and random points; and joining them."""

import numpy as np
import pytest
import trimesh
from ifa.bodies.composition import (
    box,
    circle,
    join,
    lathe,
    plate,
    skin,
    solid,
    tube,
    wire,
)

DENSITY = 900.0


def same(part, mass, centre, inertia, rel=1e-12):
    size = np.sqrt(np.trace(inertia) / mass)  # about that of the part
    assert part.mass_kg == pytest.approx(mass, rel=rel)
    assert np.allclose(part.centre_m, centre, rtol=0, atol=rel * size)
    assert np.allclose(part.inertia_kg_m2, inertia, rtol=0, atol=rel * np.max(np.abs(inertia)))


def same_part(a, b, rel=1e-12):
    same(a, b.mass_kg, b.centre_m, b.inertia_kg_m2, rel)


def of_points(points, mass):
    """Centre and inertia of equal masses at points."""
    centre = points.mean(axis=0)
    spread = (points - centre).T @ (points - centre) * (mass / len(points))
    return centre, np.trace(spread) * np.eye(3) - spread


def test_two_half_boxes_are_the_whole():
    whole = box((0.3, 0.2, 0.1), (1.0, -2.0, 0.5), DENSITY)
    halves = [box((0.15, 0.2, 0.1), (x, -2.0, 0.5), DENSITY) for x in (0.925, 1.075)]
    # the parallel-axis theorem cancels 2 m against 0.1 m: some 1e-15 (2 / 0.1)^2
    same_part(join(halves), whole)
    same_part(join([whole]), whole)
    sides = [join(halves[:1]), join(halves[1:])]
    same_part(join(sides), join(halves))


def test_box_and_tube_have_their_closed_forms():
    part = box((0.1, 0.2, 0.3), (0, 0, 0), DENSITY)
    m = DENSITY * 0.006
    same(part, m, (0, 0, 0), m / 12 * np.diag([0.13, 0.10, 0.05]))
    outer, inner, length = 0.02, 0.015, 0.1
    pipe = tube((0, 0, 0.05), (0, 0, 0.05 + length), outer, DENSITY, inner_m=inner)
    m = DENSITY * np.pi * (outer**2 - inner**2) * length
    along = m * (outer**2 + inner**2) / 2
    across = m * (3 * (outer**2 + inner**2) + length**2) / 12
    same(pipe, m, (0, 0, 0.1), np.diag([across, across, along]))


def test_a_tube_in_any_direction_is_one_that_was_turned():
    upright = tube((0, 0, 0), (0, 0, 0.1), 0.01, DENSITY)
    turned = upright.moved((0, 0, 0), axis=1, turn_rad=0.6).moved((0.1, 0, 0), turn_rad=0.4)
    way = 0.1 * np.array([np.sin(0.6) * np.cos(0.4), np.sin(0.6) * np.sin(0.4), np.cos(0.6)])
    same_part(turned, tube((0.1, 0, 0), way + np.array([0.1, 0, 0]), 0.01, DENSITY))


def test_lathe_has_the_closed_forms_of_cone_and_sphere():
    r, h, thickness = 0.04, 0.09, 1e-3
    slant = np.hypot(r, h)
    m = np.pi * r * slant * thickness * DENSITY
    # a cone's shell from its apex: centre at 2/3, m r^2 / 2 about the axis, and across it, at the
    # apex, m (r^2 / 4 + h^2 / 2)
    across = m * (r**2 / 4 + h**2 / 2) - m * (2 * h / 3) ** 2
    cone = lathe([(0, 0), (r, h)], thickness, DENSITY)
    same(cone, m, (0, 0, 2 * h / 3), np.diag([across, across, m * r**2 / 2]))
    angle = np.linspace(0, np.pi, 201)
    sphere = lathe(np.column_stack([r * np.sin(angle), -r * np.cos(angle)]), thickness, DENSITY)
    m = 4 * np.pi * r**2 * thickness * DENSITY
    # 200 chords: (pi / 200)^2 / 12 = 2e-5 short in length, and twice that and more in the moments
    same(sphere, m, (0, 0, 0), 2 / 3 * m * r**2 * np.eye(3), rel=2e-4)


def crooked_sections():
    """A bent, twisted and tapering bar of six corners."""
    sections = []
    for s in np.linspace(0, 1, 5):
        ring = circle(0.03 * (1 - 0.4 * s), 0.0, 6).copy()
        ring[:, 0] *= 1.5
        turn = 0.5 * s
        ring = ring @ [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
        sections.append(ring + np.array([0.02 * s**2, 0.01, 0.1 * s]))
    return sections


@pytest.mark.parametrize("backwards", [False, True])
def test_solids_have_the_mass_that_trimesh_finds(backwards):
    sections = crooked_sections()
    part = solid(sections[::-1] if backwards else sections, DENSITY)
    mesh = trimesh.Trimesh(part.points_m, part.triangles)
    assert mesh.is_watertight
    assert mesh.volume > 0.0
    mesh.density = DENSITY
    same(part, mesh.mass, mesh.center_mass, mesh.moment_inertia, rel=1e-9)


def test_a_closed_solid_is_a_ring():
    # a square section turned about z: Pappus' volume; 48 corners, so that the area is that of a
    # polygon: sin(2 pi / 48) / (2 pi / 48) of the circle's
    corners = [(0.04, -0.005), (0.05, -0.005), (0.05, 0.005), (0.04, 0.005)]
    lines = np.stack([circle(r, z, 48) for r, z in corners], axis=1)
    ring = solid(list(lines), DENSITY, closed=True)
    share = np.sin(2 * np.pi / 48) / (2 * np.pi / 48)
    m = DENSITY * 2 * np.pi * 0.045 * 0.01**2 * share
    assert ring.mass_kg == pytest.approx(m, rel=1e-12)
    assert np.allclose(ring.centre_m, 0, atol=1e-15)
    pipe = tube((0, 0, -0.005), (0, 0, 0.005), 0.05, DENSITY, inner_m=0.04)
    # (2 pi / 48)^2 / 6 of the area, and twice that of the moments
    same_part(ring, pipe, rel=1e-2)


def test_plates_are_boxes_where_they_are_straight():
    left, right = [(0, 0.02), (0.1, 0.02), (0.3, 0.02)], [(0, -0.01), (0.2, -0.01), (0.3, -0.01)]
    same_part(
        plate(left, right, 0.0, 0.004, DENSITY),
        box((0.3, 0.03, 0.004), (0.15, 0.005, 0.002), DENSITY),
    )


def test_skin_is_the_limit_of_a_thin_box():
    sheet = skin(
        [[(0, 0, 0), (0, 0.2, 0)], [(0.1, 0, 0), (0.1, 0.2, 0)]], 1e-9, DENSITY, around=False
    )
    same_part(sheet, box((0.1, 0.2, 1e-9), (0.05, 0.1, 0), DENSITY), rel=1e-9)


def test_skin_has_the_mass_of_points_strewn_over_it():
    sections = crooked_sections()
    part = skin(sections, 1e-3, DENSITY)
    mesh = trimesh.Trimesh(part.points_m, part.triangles, process=False)
    assert part.mass_kg == pytest.approx(DENSITY * 1e-3 * mesh.area, rel=1e-12)
    corners = part.points_m[part.triangles]
    rng = np.random.default_rng(0)
    n = 400_000
    which = rng.choice(len(corners), n, p=mesh.area_faces / mesh.area)
    a, b = rng.random((2, n, 1))
    a, b = np.where(a + b > 1, 1 - a, a), np.where(a + b > 1, 1 - b, b)
    u, v, w = np.moveaxis(corners[which], 1, 0)
    points = u + a * (v - u) + b * (w - u)
    # 1 / sqrt(n) = 1.6e-3, and three times that
    same(part, part.mass_kg, *of_points(points, part.mass_kg), rel=5e-3)


def test_wire_is_a_line_of_mass():
    radius, m_per_m = 1e-6, DENSITY * np.pi * 1e-12
    bent = wire([(0, 0, 0), (0.3, 0, 0), (0.3, 0.4, 0)], radius, DENSITY)
    # two thin rods: L^3 / 12 each about its middle
    middles, lengths = np.array([(0.15, 0, 0), (0.3, 0.2, 0)]), np.array([0.3, 0.4])
    centre = lengths @ middles / 0.7
    about_z = sum(
        m_per_m * (length**3 / 12 + length * np.sum((p - centre) ** 2))
        for length, p in zip(lengths, middles, strict=True)
    )
    assert bent.mass_kg == pytest.approx(0.7 * m_per_m, rel=1e-12)
    assert np.allclose(bent.centre_m, centre, atol=1e-15)
    assert bent.inertia_kg_m2[2, 2] == pytest.approx(about_z, rel=1e-9)  # (1e-6 / 0.3)^2
    hoop = wire(circle(0.1, 0.0, 400), radius, DENSITY, closed=True)
    # m r^2, but for chords: (pi / 400)^2 = 6e-5
    assert hoop.inertia_kg_m2[2, 2] == pytest.approx(hoop.mass_kg * 0.01, rel=1e-4)
    assert hoop.mass_kg == pytest.approx(m_per_m * 0.2 * np.pi, rel=1e-4)


def test_the_whole_is_as_random_points_in_a_brick_say():
    """The library's brick, from points in its solid: walls, top, studs and tube."""
    import ifa

    body = ifa.bodies.get("lego_2x2")
    rng = np.random.default_rng(1)
    x, y, z = (rng.uniform(low, high, 3_000_000) for low, high in ((-8, 8), (-8, 8), (0, 11.3)))
    outside = np.maximum(np.abs(x), np.abs(y)) > 7.9
    wall = (np.maximum(np.abs(x), np.abs(y)) > 6.4) | (z > 8.6)
    r = np.hypot(x, y)
    pipe = (r < 3.255) & (r > 2.4)
    stud = np.hypot(np.abs(x) - 4, np.abs(y) - 4) < 2.4
    inside = np.where(z > 9.6, stud, ~outside & (wall | pipe))
    points = 1e-3 * np.column_stack([x, y, z])[inside]
    share = inside.mean()
    mass = 1040.0 * share * 16e-3 * 16e-3 * 11.3e-3
    centre, inertia = of_points(points, mass)
    # 1.2 million points within: 1e-3, and three times that
    assert body.mass_kg == pytest.approx(mass, rel=3e-3)
    assert np.allclose(body.centre_of_mass_m, centre, atol=3e-3 * 8e-3)
    assert np.allclose(body.inertia_kg_m2, inertia, rtol=0, atol=3e-3 * inertia.max())
