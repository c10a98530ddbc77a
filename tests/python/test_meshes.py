import warnings
from pathlib import Path

import ifa
import numpy as np
import pytest

SHARED = Path(__file__).resolve().parents[3] / "shared" / "meshes"

CUBE = 0.5 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


def shared(kind):
    if not SHARED.is_dir():
        return [pytest.param(None, marks=pytest.mark.skip(reason="../shared/meshes is absent"))]
    return [pytest.param(path, id=path.name) for path in sorted((SHARED / kind).iterdir())]


def load(path, **arguments):
    """The body and its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        body = ifa.Body.from_mesh(path, **{"density": 1.0, **arguments})
    assert all(issubclass(w.category, ifa.MeshWarning) for w in caught)
    assert len(caught) == len(body.notes)
    assert all(path.name in str(w.message) for w in caught)
    return body, body.notes


def solid(vertices, triangles, **arguments):
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        return ifa.Body.from_triangles(vertices, triangles, **{"density": 1.0, **arguments})


def sampled_moments(vertices, triangles, lines):
    """Volume, centre and covariance by parallel lines through a mesh, and the volume's error.

    An independent second method: each line's crossings in order, in pairs, bound the inside.
    """
    random = np.random.default_rng(1)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    grid = int(np.sqrt(lines))
    i, j = np.meshgrid(np.arange(grid), np.arange(grid), indexing="ij")
    xy = np.stack([i.ravel(), j.ravel()], 1) + random.random((grid * grid, 2))
    xy = low[:2] + xy / grid * (high - low)[:2]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    det = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    keep = det != 0
    a, b, c, det = a[keep], b[keep], c[keep], det[keep]
    sums, lengths = np.zeros(10), []
    for x, y in xy:
        dx, dy = x - a[:, 0], y - a[:, 1]
        u = (dx * (c - a)[:, 1] - dy * (c - a)[:, 0]) / det
        v = ((b - a)[:, 0] * dy - (b - a)[:, 1] * dx) / det
        hit = (u >= 0) & (v >= 0) & (u + v <= 1)
        z = np.sort((a[:, 2] + u * (b - a)[:, 2] + v * (c - a)[:, 2])[hit])
        if len(z) % 2:
            z = z[:-1]
        z0, z1 = z[::2], z[1::2]
        n, f, s = (z1 - z0).sum(), (z1**2 - z0**2).sum() / 2, (z1**3 - z0**3).sum() / 3
        lengths.append(n)
        sums += [n, x * n, y * n, f, x * x * n, y * y * n, s, x * y * n, x * f, y * f]
    sums *= np.prod((high - low)[:2]) / len(xy)
    volume, centre = sums[0], sums[1:4] / sums[0]
    xx, yy, zz, xy_, xz, yz = sums[4:]
    second = np.array([[xx, xy_, xz], [xy_, yy, yz], [xz, yz, zz]]) / volume
    error = np.std(lengths) / np.sqrt(len(lengths)) / np.mean(lengths)
    return volume, centre, second - np.outer(centre, centre), error


@pytest.mark.parametrize("path", shared("good"))
def test_everyday_meshes_have_the_mass_of_their_solid(path):
    from ifa.mesh_files import read_mesh

    body, notes = load(path)
    vertices, triangles, _ = read_mesh(path)
    if any("hull" in note for note in notes):
        hull, _, _ = ifa._core.rounded_hull_mass_properties(vertices, 0.0, 1.0)
        assert body.mass_kg == pytest.approx(hull, rel=1e-12)
        return
    volume, centre, covariance, error = sampled_moments(vertices, triangles, 2500)
    extent = np.ptp(vertices, axis=0).max()
    # Five standard errors: of plain sampling, an upper bound for this stratified one, and of the
    # place of a line within its cell: (1/50) / sqrt(12) / sqrt(2500) < 1/2500.
    tolerance = 5 * (error + 1 / 2500)
    assert body.mass_kg == pytest.approx(volume, rel=tolerance)
    assert np.abs(body.centre_of_mass_m - centre).max() < tolerance * extent
    inertia = np.trace(covariance) * np.eye(3) - covariance
    assert np.abs(body.inertia_kg_m2 / body.mass_kg - inertia).max() < tolerance * extent**2


@pytest.mark.parametrize("path", shared("good"))
def test_everyday_meshes_survive_a_body_file(path, tmp_path):
    body, _ = load(path, unit="cm", density=1000.0)
    body.write(tmp_path / "body.json")
    again = ifa.Body.read(tmp_path / "body.json")
    assert again.to_dict() == body.to_dict()
    corners = body.vertices_m[body.triangles]
    assert len(corners) == 2 * len(body.vertices_m) - 4


@pytest.mark.parametrize("path", shared("bad"))
def test_bad_meshes_give_a_clear_error_or_a_stated_warning(path):
    try:
        _, notes = load(path)
    except ifa.IfaError as error:
        assert path.name in str(error)
        assert "\n" not in str(error)
    else:
        assert notes


@pytest.mark.skipif(not SHARED.is_dir(), reason="../shared/meshes is absent")
def test_two_crossed_bodies_are_told_apart_by_a_second_method():
    from ifa.mesh_files import read_mesh

    path = SHARED / "bad" / "trimesh_multibody.stl"
    body, notes = load(path)
    vertices, triangles, _ = read_mesh(path)
    volume, _, _, error = sampled_moments(vertices, triangles, 2500)
    assert body.mass_kg == pytest.approx(volume, rel=5 * error)
    assert any("turned" in note for note in notes)


def test_units_and_mass(tmp_path):
    path = tmp_path / "cube.off"
    rows = [*CUBE.tolist(), *((4, *quad) for quad in QUADS)]
    path.write_text("OFF 8 6 12\n" + "\n".join(" ".join(map(str, row)) for row in rows))
    for unit, metres in [("m", 1.0), ("cm", 0.01), ("mm", 1e-3), ("inch", 0.0254), ("ft", 0.3048)]:
        body, _ = load(path, unit=unit, density=None, mass_kg=2.0)
        assert body.mass_kg == 2.0
        assert np.allclose(np.ptp(body.vertices_m, axis=0), metres, rtol=1e-14)
        assert body.inertia_kg_m2[0, 0] == pytest.approx(2.0 / 6.0 * metres**2, rel=1e-13)
    body, notes = load(path, density=None)
    assert body.mass_kg == pytest.approx(1000.0, rel=1e-13)
    assert any("1000" in note for note in notes)
    with pytest.raises(ifa.IfaValueError, match="unit"):
        load(path, unit="furlong")
    with pytest.raises(ifa.IfaValueError, match="density"):
        load(path, mass_kg=1.0)


def test_inside_out_and_mixed_winding():
    good = solid(CUBE, TRIANGLES)
    assert good.notes == ()
    mixed = TRIANGLES.copy()
    mixed[::3] = mixed[::3, ::-1]
    for faces in (TRIANGLES[:, ::-1], mixed):
        body = solid(CUBE, faces)
        assert body.mass_kg == pytest.approx(1.0, rel=1e-14)
        assert np.allclose(body.inertia_kg_m2, good.inertia_kg_m2, rtol=0, atol=1e-15)
        assert any("turned" in note for note in body.notes)


def test_pieces_cavities_and_pieces_within_pieces():
    n = len(CUBE)
    inner = np.concatenate([CUBE, 0.5 * CUBE])
    hollow = np.concatenate([TRIANGLES, TRIANGLES[:, ::-1] + n])
    for faces in (hollow, hollow[:, ::-1]):
        body = solid(inner, faces)
        assert body.mass_kg == pytest.approx(1.0 - 0.125, rel=1e-14)
        moment = (1.0 - 0.5**5) / 6.0
        assert np.allclose(body.inertia_kg_m2, moment * np.eye(3), rtol=0, atol=1e-15)
    nested = solid(inner, np.concatenate([TRIANGLES, TRIANGLES + n]))
    assert nested.mass_kg == pytest.approx(1.0, rel=1e-14)
    assert any("inside another" in note for note in nested.notes)
    apart = np.concatenate([CUBE, CUBE + np.array([3.0, 0.0, 0.0])])
    for second in (TRIANGLES + n, TRIANGLES[:, ::-1] + n):  # the second piece may be inside out
        dumbbell = solid(apart, np.concatenate([TRIANGLES, second]))
        assert dumbbell.mass_kg == pytest.approx(2.0, rel=1e-14)
        assert np.allclose(dumbbell.centre_of_mass_m, (1.5, 0, 0), rtol=0, atol=1e-14)
        expected = 2.0 * np.diag([1 / 6, 1 / 6 + 2.25, 1 / 6 + 2.25])
        assert np.allclose(dumbbell.inertia_kg_m2, expected, rtol=0, atol=1e-13)
    bars = np.concatenate([CUBE * (3, 1, 1), CUBE * (1, 3, 0.8)])  # a plus: no corner inside
    for crossing in (np.concatenate([CUBE, CUBE + np.array([0.9, 0.1, 0.1])]), bars):
        body = solid(crossing, np.concatenate([TRIANGLES, TRIANGLES + n]))
        assert any("overlap" in note for note in body.notes)


def test_cubes_touching_along_an_edge_stay_two_pieces():
    corners = np.concatenate([CUBE, CUBE + np.array([1.0, 1.0, 0.0])])
    body = solid(corners, np.concatenate([TRIANGLES, TRIANGLES[:, ::-1] + len(CUBE)]))
    assert body.mass_kg == pytest.approx(2.0, rel=1e-14)


def test_noisy_welds_repeated_faces_and_t_junctions_are_closed():
    random = np.random.default_rng(2)
    soup = CUBE[TRIANGLES].reshape(-1, 3)
    noisy = soup + 1e-8 * random.standard_normal(soup.shape)
    body = solid(noisy, np.arange(len(soup)).reshape(-1, 3))
    assert body.notes == ()
    assert body.mass_kg == pytest.approx(1.0, rel=1e-6)  # noise of 1e-8 on each corner
    assert solid(CUBE, np.concatenate([TRIANGLES, TRIANGLES])).mass_kg == pytest.approx(1.0)
    # split one face at the middle of an edge that its neighbour does not split
    (a, b, c), rest = TRIANGLES[0], TRIANGLES[1:]
    points = np.concatenate([CUBE, [0.5 * (CUBE[a] + CUBE[b])]])
    body = solid(points, np.concatenate([rest, [(a, 8, c), (8, b, c)]]))
    assert body.notes == ()
    assert body.mass_kg == pytest.approx(1.0, rel=1e-14)


def test_open_meshes_fall_back_to_the_hull_and_say_so():
    for faces in (TRIANGLES[1:], TRIANGLES[:6]):
        with pytest.warns(ifa.MeshWarning, match="hull"):
            body = ifa.Body.from_triangles(CUBE, faces, density=1.0)
        assert any("hull" in note for note in body.notes)
        used = CUBE[np.unique(faces)]
        hull, _, _ = ifa._core.rounded_hull_mass_properties(used, 0.0, 1.0)
        assert body.mass_kg == pytest.approx(hull, rel=1e-14)
    sheet = solid(CUBE, TRIANGLES[:2], radius_m=0.1)  # a plate, by its rounding
    # Steiner's formula for a flat square of side 1
    expected = 2 * 0.1 + np.pi * 2 * 0.1**2 + 4 / 3 * np.pi * 0.1**3
    assert sheet.mass_kg == pytest.approx(expected, rel=1e-14)
    with pytest.raises(ifa.IfaValueError, match="no volume"):
        solid(CUBE, TRIANGLES[:2])


@pytest.mark.parametrize(("size", "closed"), [(0.3, True), (0.5, False)])
def test_small_holes_are_closed_and_said(size, closed):
    """A hole of size^2 / 12 of a cube's surface, on either side of one hundredth."""
    (a, b, c), rest = TRIANGLES[0], TRIANGLES[1:]
    corners = CUBE[[a, b, c]]
    centre = corners.mean(axis=0)
    points = np.concatenate([CUBE, centre + size * (corners - centre)])
    ring = [(a, b, 9), (a, 9, 8), (b, c, 10), (b, 10, 9), (c, a, 8), (c, 8, 10)]
    body = solid(points, np.concatenate([rest, ring]))
    assert any(("closed" if closed else "hull") in note for note in body.notes)
    assert body.mass_kg == pytest.approx(1.0, rel=1e-14)
    assert len(body.notes) == 1


def test_unused_vertices_do_not_count():
    body = solid(np.concatenate([CUBE, [(9.0, 9.0, 9.0)]]), TRIANGLES)
    assert len(body.vertices_m) == 8
    assert body.mass_kg == pytest.approx(1.0, rel=1e-14)


def test_bad_triangles_are_named():
    for faces in ([], [[0, 1]], [[0, 1, 8]], [[0, 1, -1]], [[0, 1, 0.5]], [[0, 1, np.nan]], "abc"):
        with pytest.raises(ifa.IfaValueError, match=r"^triangles: "):
            solid(CUBE, faces)
    with pytest.raises(ifa.IfaValueError, match=r"^vertices_m: "):
        solid(np.where(CUBE > 0, np.inf, CUBE), TRIANGLES)
