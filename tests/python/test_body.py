import copy
import json
import pickle

import ifa
import numpy as np
import pytest

BRICK_M = (0.02, 0.04, 0.06)


def box_corners(size):
    return 0.5 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size


def box_moments(size, mass):
    a, b, c = np.square(size)
    return mass / 12.0 * np.array([b + c, c + a, a + b])


def same(a, b):
    return a.to_dict() == b.to_dict() and a.notes == b.notes


def test_from_vertices_finds_centre_and_inertia_of_the_solid():
    corners = box_corners(BRICK_M) + np.array([1.0, 2.0, 3.0])
    body = ifa.Body.from_vertices(corners, mass_kg=0.06)
    # rounding of coordinates near 3 m: 4e-16 m
    assert np.allclose(body.centre_of_mass_m, (1.0, 2.0, 3.0), rtol=0, atol=1e-14)
    assert np.allclose(body.vertices_m, corners - (1.0, 2.0, 3.0), rtol=0, atol=1e-14)
    assert np.allclose(body.inertia_kg_m2, np.diag(box_moments(BRICK_M, 0.06)), rtol=0, atol=1e-17)
    assert (body.restitution, body.friction, body.radius_m) == (0.5, 0.3, 0.0)


def test_given_inertia_makes_the_origin_the_centre_of_mass():
    corners = box_corners(BRICK_M)
    for inertia, expected in [
        (1e-5, np.diag([1e-5] * 3)),
        ([1e-5, 2e-5, 2.5e-5], np.diag([1e-5, 2e-5, 2.5e-5])),
        (np.diag([3.0, 4.0, 5.0]) + 0.5, np.diag([3.0, 4.0, 5.0]) + 0.5),
    ]:
        body = ifa.Body.from_vertices(corners, mass_kg=1.0, inertia_kg_m2=inertia)
        assert np.array_equal(body.inertia_kg_m2, expected)
        assert np.array_equal(body.vertices_m, corners)
        assert not body.centre_of_mass_m.any()
    moved = ifa.Body.from_vertices(
        corners, mass_kg=1.0, inertia_kg_m2=1e-5, centre_of_mass_m=(0.0, 0.0, 0.01)
    )
    assert np.array_equal(moved.vertices_m, corners - (0.0, 0.0, 0.01))


def test_box_size_includes_the_rounding():
    for radius in (0.0, 0.003, 0.01):
        body = ifa.Body.box(BRICK_M, mass_kg=0.1, radius_m=radius)
        outer = np.ptp(body.vertices_m, axis=0) + 2.0 * radius
        assert np.allclose(outer, BRICK_M, rtol=1e-15)
    sharp = ifa.Body.box(BRICK_M, density=1250.0)
    assert sharp.mass_kg == pytest.approx(0.06, rel=1e-14)
    # rounding takes mass from the edges: Steiner's formula
    a, b, c, r = 0.014, 0.034, 0.054, 0.003
    volume = a * b * c + 2 * (a * b + b * c + c * a) * r
    volume += np.pi * (a + b + c) * r**2 + 4 / 3 * np.pi * r**3
    rounded = ifa.Body.box(BRICK_M, density=1000.0, radius_m=r)
    assert rounded.mass_kg == pytest.approx(1000 * volume, rel=1e-14)


def test_ball():
    body = ifa.Body.ball(0.01, density=1000.0)
    mass = 4 / 3 * np.pi * 1e-3
    assert body.mass_kg == pytest.approx(mass, rel=1e-14)
    assert np.allclose(body.inertia_kg_m2, 0.4 * mass * 1e-4 * np.eye(3), rtol=1e-14)
    assert body.vertices_m.shape == (1, 3)
    assert body.triangles.shape == (0, 3)


def test_triangles_draw_the_hull_outward():
    body = ifa.bodies.get("d12")
    a, b, c = (body.vertices_m[body.triangles[:, k]] for k in range(3))
    assert (np.einsum("ij,ij->i", a, np.cross(b, c)) > 0).all()
    assert len(body.triangles) == 2 * len(body.vertices_m) - 4  # Euler


def test_replace():
    body = ifa.bodies.get("eraser")
    softer = body.replace(restitution=0.2, name="soft")
    assert (softer.restitution, softer.name, softer.friction) == (0.2, "soft", body.friction)
    assert np.array_equal(softer.inertia_kg_m2, body.inertia_kg_m2)
    assert body.restitution == 0.35
    heavy = body.replace(mass_kg=2 * body.mass_kg)
    assert np.array_equal(heavy.inertia_kg_m2, 2 * body.inertia_kg_m2)
    both = body.replace(mass_kg=1.0, inertia_kg_m2=[1.0, 1.0, 1.0])
    assert np.array_equal(both.inertia_kg_m2, np.eye(3))


def test_a_body_cannot_be_changed():
    body = ifa.bodies.get("d6")
    with pytest.raises(AttributeError):
        body.mass_kg = 1.0
    for values in (body.vertices_m, body.triangles, body.centre_of_mass_m):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0
    body.inertia_kg_m2[0, 0] = 1.0  # a copy
    assert body.inertia_kg_m2[0, 0] < 1e-6


@pytest.mark.parametrize("name", ["d10", "ball", "coin"])
def test_round_trips(name, tmp_path):
    body = ifa.bodies.get(name, surface="wood")
    assert same(body, pickle.loads(pickle.dumps(body)))
    assert same(body, copy.deepcopy(body))
    path = tmp_path / "körper.json"
    body.write(path)
    assert same(body, ifa.Body.read(path))


def test_mesh_offset_survives_a_body_file(tmp_path):
    corners = box_corners(BRICK_M) + np.array([0.5, 0.0, 0.0])
    body = ifa.Body.from_vertices(corners, mass_kg=1.0, friction=0.7)
    body.write(tmp_path / "b.json")
    again = ifa.Body.read(tmp_path / "b.json")
    assert same(body, again)
    assert np.array_equal(again.centre_of_mass_m, body.centre_of_mass_m)


def test_body_file_needs_only_vertices_and_mass(tmp_path):
    path = tmp_path / "b.json"
    path.write_text(json.dumps({"vertices_m": box_corners(BRICK_M).tolist(), "mass_kg": 0.06}))
    body = ifa.Body.read(path)
    assert np.allclose(np.diag(body.inertia_kg_m2), box_moments(BRICK_M, 0.06), rtol=1e-14)


BALL = '"vertices_m": [[0, 0, 0]], "radius_m": 0.01'


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "JSON"),
        ("[1, 2]", "object"),
        ("{" + BALL + "}", "mass_kg: is missing"),
        ('{"mass_kg": 1}', "vertices_m: is missing"),
        ("{" + BALL + ', "mass_kg": NaN}', "NaN"),
        ("{" + BALL + ', "mass_kg": 1e999}', "mass_kg"),
        ("{" + BALL + ', "mass_kg": "1"}', "mass_kg: must be a number"),
        ("{" + BALL + ', "mass_kg": 1, "mass_kg": 2}', "twice"),
        ("{" + BALL + ', "mass_kg": 1, "masss": 2}', "masss"),
        ("{" + BALL + ', "mass_kg": 1, "rings_m": [[0, 0, 1]]}', "rings_m"),
        ("{" + BALL + ', "mass_kg": 1, "inertia_kg_m2": [1, 1, 3]}', "inertia_kg_m2"),
        ('{"vertices_m": [[0, 0], [1]], "mass_kg": 1}', "vertices_m"),
        ('{"vertices_m": [], "mass_kg": 1}', "vertices_m"),
        ("{" + BALL + ', "mass_kg": 1, "name": 7}', "name"),
        ("[" * 100_000, "JSON"),
    ],
)
def test_bad_body_files_name_the_file_and_the_field(text, complaint, tmp_path):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(ifa.IfaFileError, match=complaint) as error:
        ifa.Body.read(path)
    assert "bad.json" in str(error.value)
    assert isinstance(error.value, OSError)


def test_missing_and_binary_body_files(tmp_path):
    with pytest.raises(ifa.IfaFileError, match=r"none\.json"):
        ifa.Body.read(tmp_path / "none.json")
    (tmp_path / "b.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ifa.IfaFileError, match="UTF-8"):
        ifa.Body.read(tmp_path / "b.json")
    with pytest.raises(ifa.IfaFileError):
        ifa.bodies.get("d6").write(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"vertices_m": "corner"}, "vertices_m"),
        ({"vertices_m": [[0, 0, np.nan]]}, "vertices_m"),
        ({"vertices_m": [[0, 0, 1]], "radius_m": 0.0}, "vertices_m"),
        ({"radius_m": -1.0}, "radius_m"),
        ({"radius_m": None}, "radius_m"),
        ({"mass_kg": np.nan}, "mass_kg"),
        ({"mass_kg": [1.0]}, "mass_kg"),
        ({"inertia_kg_m2": [1.0, 1.0]}, "inertia_kg_m2"),
        ({"inertia_kg_m2": [[1.0], [1.0, 2.0]]}, "inertia_kg_m2"),
        ({"inertia_kg_m2": 0.0}, "inertia_kg_m2"),
        ({"centre_of_mass_m": [0.0, 0.0, np.inf]}, "centre_of_mass_m"),
        ({"centre_of_mass_m": 0.0}, "centre_of_mass_m"),
        ({"rings_m": [[0.0, 0.0, 1.0]]}, "rings_m"),
        ({"restitution": 1.5}, "restitution"),
        ({"friction": -0.1}, "friction"),
        ({"rolling_friction_m": np.inf}, "rolling_friction_m"),
        ({"name": None}, "name"),
    ],
)
def test_bad_arguments_are_named(arguments, field):
    good = {"vertices_m": box_corners(BRICK_M), "mass_kg": 1.0}
    with pytest.raises(ifa.IfaValueError, match=f"^{field}: ") as error:
        ifa.Body.from_vertices(**{**good, **arguments})
    assert isinstance(error.value, ValueError)


def test_bad_shorthands_are_named():
    box, ball = ifa.Body.box, ifa.Body.ball
    for call, field in [
        (lambda: box((1, 1, 0), mass_kg=1), "size_m"),
        (lambda: box((1, 1, 1), mass_kg=1, radius_m=0.6), "radius_m"),
        (lambda: box((1, 1, 1)), "mass_kg"),
        (lambda: box((1, 1, 1), mass_kg=1, density=1), "mass_kg"),
        (lambda: box((1, 1, 1), density=-1), "density"),
        (lambda: box((1, 1, 1), mass_kg=1, bounce=1), "bounce"),
        (lambda: ball(0.0, mass_kg=1), "radius_m"),
        (lambda: ball(1.0, mass_kg=1).replace(colour=1), "colour"),
        (lambda: ifa.bodies.get("d7"), "d20"),
        (lambda: ifa.bodies.get("d6", surface="ice"), "carpet"),
    ]:
        with pytest.raises(ifa.IfaValueError, match=field):
            call()


def test_library_is_complete():
    first = ["d4", "d6", "d8", "d10", "d12", "d20", "ball", "coin", "eraser", "card"]
    assert ifa.bodies.names()[:10] == first
    rows = ifa.bodies.describe()
    assert [row["name"] for row in rows] == ifa.bodies.names()
    json.dumps(rows, allow_nan=False)
    for row in rows:
        for surface, material in row["surfaces"].items():
            body = ifa.bodies.get(row["name"], surface=surface)
            assert (body.restitution, body.friction) == tuple(material.values())
            assert body.mass_kg == row["mass_kg"]
            assert 0.5e-3 < body.mass_kg < 1.0
            assert 0 < body.rolling_friction_m < 0.1 * np.abs(body.outline_m).max() + 0.01


def face_planes(body):
    """Distinct face planes (unit normal, distance) of the hull before rounding."""
    a, b, c = (body.vertices_m[body.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    planes = np.column_stack([normals, np.einsum("ij,ij->i", normals, a) * 1000])
    return np.unique(np.round(planes, 9) + 0.0, axis=0)


@pytest.mark.parametrize(
    ("name", "faces", "corners"),
    [("d4", 4, 4), ("d6", 6, 8), ("d8", 8, 6), ("d10", 10, 12), ("d12", 12, 20), ("d20", 20, 12)],
)
def test_dice_are_fair(name, faces, corners):
    body = ifa.bodies.get(name)
    planes = face_planes(body)
    assert len(planes) == faces  # so the kites of the d10 are plane, to 1e-9
    assert len(body.vertices_m) == corners
    # every face equally far from the centre of mass
    assert np.ptp(planes[:, 3]) < 2e-9
    moments = np.diag(body.inertia_kg_m2)
    # two equal moments for the d10, three for the others
    assert np.ptp(moments[:2] if name == "d10" else moments) < 1e-12 * moments.max()
    gaps = np.linalg.norm(body.vertices_m[:, None] - body.vertices_m[None], axis=2)
    shortest = np.sort(gaps, axis=1)[:, 1]
    if name != "d10":  # all edges equal
        assert np.ptp(shortest) < 1e-12 * shortest.max()


def test_outer_sizes_are_those_of_the_real_things():
    across_mm = {"d6": 16, "d8": 15, "d10": 16, "d12": 18, "d20": 20}
    for name, size in across_mm.items():
        body = ifa.bodies.get(name)
        assert 2 * (face_planes(body)[0, 3] + 1000 * body.radius_m) == pytest.approx(size, rel=1e-8)
    sizes_mm = {
        "ball": (27, 27, 27),
        "coin": (25.75, 25.75, 2.2),
        "eraser": (43, 17, 11),
        "card": (85.6, 54, 0.76),
    }
    for name, size in sizes_mm.items():
        body = ifa.bodies.get(name)
        outer = np.ptp(body.outline_m, axis=0) + 2 * body.radius_m
        assert np.allclose(1000 * outer, size, rtol=1e-12)
