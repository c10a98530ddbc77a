"""The library of bodies: the paper's rows, real sizes, shapes that hold their parts, rest."""

import re
from pathlib import Path

import ifa
import numpy as np
import pytest
from ifa.bodies.composition import directions

ROOT = Path(__file__).resolve().parents[2]
COMPOSED = [name for name in ifa.bodies.names() if ifa.bodies.parts(name)]


def test_the_rows_are_those_of_table_1():
    rows = ifa.bodies.TABLE_1
    assert len(rows) == len(set(rows)) == 31
    assert len({name for name, _ in rows}) == 27
    for name, surface in rows:
        assert ifa.bodies.get(name, surface=surface).name == name
    surfaces = [surface for _, surface in rows]
    # counted in the paper
    assert [surfaces.count(s) for s in ("desk", "wood", "carpet")] == [22, 5, 4]
    described = {row["name"]: row for row in ifa.bodies.describe()}
    assert [row["paper_name"] for row in described.values()].count(None) == 2
    assert described["ball"]["paper_name"] is described["coin"]["paper_name"] is None
    assert described["card"]["paper_name"] == "CreditCard"
    assert described["dustpan"]["paper_surfaces"] == ["wood", "carpet"]
    in_order = [described[name]["paper_name"] for name, _ in rows]
    assert in_order[:3] == ["AdjustableWrench", "BeerCanCrushed", "Bolt"]
    assert in_order[-3:] == ["TapeDispenser", "TapeDispenser", "Wrench"]


def test_sampling_is_the_papers():
    how = {name: ifa.bodies.sampling(name) for name in ifa.bodies.names()}
    wide = {name for name in how if how[name].cone_rad == pytest.approx(np.radians(80))}
    slow = {name for name in how if how[name].merge_gap_s == 0.030}
    assert wide == {"nut", "bolt"}
    assert slow == {"beer_can", "garlic", "nut"}
    for name in how:
        assert name in wide or how[name].cone_rad == pytest.approx(np.radians(30))
        assert name in slow or how[name].merge_gap_s == 0.010


@pytest.mark.parametrize("ask", [ifa.bodies.get, ifa.bodies.parts, ifa.bodies.sampling])
@pytest.mark.parametrize("name", ["d7", "", None, 6, ["d6"]])
def test_unknown_names_are_refused_and_the_known_ones_listed(ask, name):
    with pytest.raises(ifa.IfaValueError, match=r"body: no .* it has d4, .*wrench"):
        ask(name)


# What they weigh and measure in a shop or on a scale: (least, most) mass in g, longest side in mm.
REAL = {
    "adjustable_wrench": ((200, 350), 200), "beer_can": ((12, 16), 71), "bolt": ((17, 22), 45.3),
    "carton": ((15, 25), 168), "coat_hanger": ((30, 60), 410), "coffee_cup": ((250, 400), 115),
    "dustpan": ((100, 250), 335), "fruit_basket": ((250, 600), 260), "garlic": ((30, 60), 60),
    "keyboard": ((450, 900), 440), "lego_2x2": ((1.1, 1.4), 15.8), "lego_2x4": ((2.1, 2.5), 31.8),
    "metal_cup": ((70, 150), 101), "nut": ((4.5, 6), 15), "paper_ball": ((4.9, 5.1), 54),
    "plastic_container": ((25, 60), 174), "plastic_spoon": ((2, 5), 165),
    "tape_dispenser": ((30, 70), 100), "wrench": ((60, 100), 172),
}  # fmt: skip


@pytest.mark.parametrize("name", COMPOSED)
def test_sizes_and_masses_are_those_of_the_real_things(name):
    body = ifa.bodies.get(name)
    (least, most), longest_mm = REAL[name]
    assert least < 1e3 * body.mass_kg < most
    outer_mm = 1e3 * (np.ptp(body.outline_m, axis=0) + 2.0 * body.radius_m)
    # of catalogues, which round to 1 %; things of one maker differ by more from those of another
    assert outer_mm.max() == pytest.approx(longest_mm, rel=0.015)
    sizes = [row["size"] for row in ifa.bodies.describe() if row["name"] == name]
    exact = re.match(r"([\d.]+) x ([\d.]+) x ([\d.]+) mm", sizes[0])
    if exact:
        said = sorted(float(x) for x in exact.groups())
        assert np.allclose(np.sort(outer_mm), said, rtol=0, atol=0.8)  # said in round numbers


@pytest.mark.parametrize("name", COMPOSED)
def test_the_hull_is_that_of_the_parts(name):
    """How far body and parts reach in 800 directions."""
    body = ifa.bodies.get(name)
    points = np.concatenate([part.points_m for part in ifa.bodies.parts(name)])
    way = directions(800)
    hull = (way @ body.outline_m.T).max(axis=1) + body.radius_m
    real = (way @ (points - body.centre_of_mass_m).T).max(axis=1)
    # What few corners cut off rounded shapes: at most 3.5 % of the size. What the hull adds: half
    # the thickness of sheets, whose parts are drawn without it, and between the rows of keys.
    size = np.ptp(points, axis=0).max()
    assert (hull - real).min() > -0.035 * size
    assert (hull - real).max() < 3e-3


@pytest.mark.parametrize("name", ifa.bodies.names())
def test_mass_properties_are_possible(name):
    body = ifa.bodies.get(name)
    moments = np.linalg.eigvalsh(body.inertia_kg_m2)
    # the sum of two moments exceeds the third by twice the mass's spread along its axis: 0 for a
    # flat thing, to rounding
    assert moments[0] > 0.0
    assert moments[0] + moments[1] > moments[2] * (1.0 - 1e-12)
    # the centre of mass, the origin, lies within the hull: every direction reaches beyond it
    reach = (directions(800) @ body.outline_m.T).max(axis=1) + body.radius_m
    assert reach.min() > 0.0
    # no mass lies farther out than the farthest point
    farthest = np.linalg.norm(body.outline_m, axis=1).max() + body.radius_m
    assert 0.5 * moments.sum() < body.mass_kg * farthest**2
    assert len(body.vertices_m) <= 60  # each costs time in every simulation
    assert len(body.rings_m) <= 8


# Mirror planes, by the axes normal to them; and the least number of equal turns about z.
SYMMETRY = {
    "bolt": ("xy", 6), "carton": ("xy", 2), "coat_hanger": ("y", 1), "coffee_cup": ("y", 1),
    "dustpan": ("y", 1), "fruit_basket": ("xy", 14), "garlic": ("y", 9), "lego_2x2": ("xy", 4),
    "lego_2x4": ("xy", 2), "metal_cup": ("xy", 4), "nut": ("xyz", 6),
    "plastic_container": ("xy", 2), "plastic_spoon": ("y", 1), "wrench": ("z", 1),
    "adjustable_wrench": ("z", 1),
}  # fmt: skip


@pytest.mark.parametrize("name", SYMMETRY)
def test_mass_is_as_symmetric_as_the_thing(name):
    body = ifa.bodies.get(name)
    planes, turns = SYMMETRY[name]
    inertia = body.inertia_kg_m2
    reach = np.abs(body.outline_m).max()
    # sums over thousands of triangles: 1e-10 of the largest
    for axis in ("xyz".index(plane) for plane in planes):
        mirror = np.eye(3)
        mirror[axis, axis] = -1.0
        assert np.allclose(mirror @ inertia @ mirror, inertia, rtol=0, atol=1e-10 * inertia.max())
        assert abs(body.centre_of_mass_m[axis]) < 1e-10 * reach
        mirrored = body.outline_m @ mirror
        gaps = np.linalg.norm(mirrored[:, None] - body.outline_m[None], axis=2).min(axis=1)
        assert gaps.max() < 1e-9 * reach
    if turns > 2:
        assert inertia[0, 0] == pytest.approx(inertia[1, 1], rel=1e-10)
        assert np.hypot(*body.centre_of_mass_m[:2]) < 1e-10 * reach


def test_hollow_things_turn_harder_than_solid_ones_of_their_hull():
    for name in ("metal_cup", "coat_hanger", "fruit_basket", "plastic_container", "nut"):
        body = ifa.bodies.get(name)
        solid = ifa.Body.from_vertices(
            body.vertices_m, body.radius_m, body.rings_m, mass_kg=body.mass_kg
        )
        assert np.trace(body.inertia_kg_m2) > 1.1 * np.trace(solid.inertia_kg_m2), name


@pytest.mark.parametrize("name", ifa.bodies.names())
def test_every_throw_comes_to_rest_on_every_surface(name):
    cone_rad = ifa.bodies.sampling(name).cone_rad
    for surface in ifa.bodies.surfaces():
        body = ifa.bodies.get(name, surface=surface)
        states = ifa.sample_states(body, 12, seed=4, cone_rad=cone_rad)
        # a ball that rolls at 4 m/s loses g 5e-5 / 0.0135 = 0.036 m/s each second
        batch = ifa.simulate_batch(body, states, until_s=120.0)
        assert (batch.status == ifa.SampleStatus.REST).all(), surface
        assert (batch.hit_count > 0).all()


def test_the_page_lists_them_as_they_are():
    page = (ROOT / "docs" / "bodies.md").read_text(encoding="utf-8")
    lines = [line for line in page.splitlines() if line.startswith("| ![")]
    rows = ifa.bodies.describe()
    assert len(lines) == len(rows)
    for line, row in zip(lines, rows, strict=True):
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        paper = row["paper_name"]
        assert cells == [
            f"![{row['name']}](bodies/{row['name']}.png)",
            f"`{row['name']}`",
            row["size"],
            f"{1e3 * row['mass_kg']:.1f} g",
            f"{np.degrees(row['cone_rad']):.0f}°",
            f"{1e3 * row['merge_gap_s']:.0f} ms",
            f"{paper} ({', '.join(row['paper_surfaces'])})" if paper else "-",
        ]
        picture = ROOT / "docs" / "bodies" / f"{row['name']}.png"
        assert 0 < picture.stat().st_size < 15_000
