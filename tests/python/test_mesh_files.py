"""Files that hold a mesh, whole, odd and broken: they are read right or refused by name."""

import struct

import ifa
import numpy as np
import pytest
from test_meshes import CUBE, QUADS, TRIANGLES, load


def write_obj(path, vertices=CUBE, faces=QUADS):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices).tolist()]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def write_off(path):
    lines = ["OFF # a cube", "", "8 6 12", *(" ".join(map(str, v)) for v in CUBE.tolist())]
    path.write_text("\n".join(lines + ["4 " + " ".join(map(str, q)) for q in QUADS]))


def write_ascii_stl(path):
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CUBE[t].tolist())
        + "endloop\nendfacet"
        for t in TRIANGLES
    ]
    path.write_text("solid cube\n" + "\n".join(facets) + "\nendsolid cube\n")


def write_binary_stl(path, header=b"solid but binary"):
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *CUBE[t].ravel(), 0) for t in TRIANGLES)
    path.write_bytes(header.ljust(80) + struct.pack("<I", len(TRIANGLES)) + body)


def write_ply(path, kind="ascii"):
    header = (
        f"ply\nformat {kind} 1.0\ncomment a cube\nelement vertex 8\nproperty float x\n"
        "property float y\nproperty float z\nproperty uchar red\nelement face 6\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    if kind == "ascii":
        rows = [" ".join(map(str, [*v, 255])) for v in CUBE.tolist()]
        rows += ["4 " + " ".join(map(str, q)) for q in QUADS]
        path.write_text(header + "\n".join(rows) + "\n")
        return
    order = "<" if "little" in kind else ">"
    body = b"".join(struct.pack(order + "3fB", *v, 255) for v in CUBE)
    body += b"".join(struct.pack(order + "B4i", 4, *q) for q in QUADS)
    path.write_bytes(header.encode() + body)


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("cube.obj", write_obj),
        ("cube.OFF", write_off),
        ("ascii.stl", write_ascii_stl),
        ("binary.STL", write_binary_stl),
        ("ascii.ply", write_ply),
        ("little.ply", lambda p: write_ply(p, "binary_little_endian")),
        ("big.ply", lambda p: write_ply(p, "binary_big_endian")),
    ],
)
def test_a_cube_in_every_format(name, write, tmp_path):
    path = tmp_path / name
    write(path)
    body, notes = load(path, unit="mm", density=1000.0, friction=0.7, radius_m=1e-5)
    assert notes == ()
    assert body.name == path.stem
    assert (body.friction, body.radius_m) == (0.7, 1e-5)
    assert body.mass_kg == pytest.approx(1e-6, rel=1e-13)
    assert np.allclose(body.inertia_kg_m2, 1e-12 / 6 * np.eye(3), rtol=1e-12, atol=1e-26)
    assert len(body.vertices_m) == 8


TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"
FACET = (
    b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    b"endloop\nendfacet\n"
)
PLY_HEAD = (
    b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    b"property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
)


@pytest.mark.parametrize(
    ("name", "content", "complaint"),
    [
        ("a.obj", b"", "empty"),
        ("a.obj", b"# nothing\n", "no faces"),
        ("a.obj", b"v 0 0\nf 1 1 1\n", "three coordinates.*'v 0 0'"),
        ("a.obj", b"v 0 0 zero\nf 1 1 1\n", "text where a number"),
        ("a.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 1.*not finite"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "index 3 is out of bounds"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "vertex 0"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3.5\n", "text where a number"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "out of bounds"),
        ("a.obj", "v 0 0 0\n".encode("utf-16"), "UTF-16"),
        ("a.obj", b"\x00\x01\x02", "binary"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "volume"),
        ("a.off", b"OFX\n", "OFF"),
        ("a.off", b"OFF\n", "numbers of its vertices"),
        ("a.off", b"OFF\n3 many 0\n", "numbers of its vertices"),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "outside the range"),
        ("a.off", b"OFF\n-3 1 0\n0 0 0\n", "numbers of its vertices"),
        ("a.stl", b"solid\n", "endsolid"),
        ("a.stl", b"solid\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nendloop\n", "three vertices"),
        ("a.stl", b"solid\nvertex 0 0 0\n", "three vertices"),
        ("a.stl", b"solid\nvertex 0 0 x\n", "three vertices"),
        ("a.stl", b"short", "too short"),
        ("a.stl", b"\x01" * 100, "announces"),
        ("a.ply", b"ply\n", "header"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex x\nend_header\n", "'x'"),
        ("a.ply", b"ply\nformat odd 1.0\nend_header\n", "odd"),
        ("a.ply", b"ply\nformat ascii 1.0\nproperty float x\nend_header\n", "before any element"),
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
            b"property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
            b"end_header\n0 0 0\n1 0 0\n3 0 1 2\n",
            "outside the file's 2",
        ),
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n0\n",
            "PLY",
        ),
        ("a.obj", TRIANGLE + b"f 1 2 0\n", "count from 1.*'f 1 2 0'"),
        ("a.obj", TRIANGLE + b"f 1 2 -9\n", "before the first vertex"),
        ("a.obj", TRIANGLE + b"f 1 2 3\nf 1// 2//\n", "three corners.*'f 1 2'"),
        ("a.obj", TRIANGLE.replace(b"1 0 0", b"1 0,5 0") + b"f 1 2 3\n", "text where a number"),
        ("a.off", b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 inf\n3 0 1 2\n", "vertex 3.*not finite"),
        ("a.off", b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 x\n3 0 1 2\n", "'x'"),
        ("a.off", b"OFF 3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "2 faces, but has 4 lines"),
        ("a.off", b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "number of corners.*'4 0 1 2'"),
        ("a.stl", FACET, "endsolid"),
        ("a.stl", FACET.replace(b"1 0 0", b"1 0 nan") + b"endsolid\n", "not finite"),
        ("a.stl", FACET.replace(b"1 0 0", b"1 0 x") + b"endsolid\n", "text where a number"),
        ("a.stl", bytes(84), "no faces"),
        ("a.ply", PLY_HEAD + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "ends before all 2.*'face'"),
        ("a.ply", PLY_HEAD + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n4 0 1 2\n", "number of corners"),
        ("a.ply", PLY_HEAD + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 -1\n", "outside the file's 3"),
        ("a.ply", PLY_HEAD + b"0 0 0\n1 0 0\n0 x 0\n3 0 1 2\n3 0 1 2\n", "text where a number"),
        ("a.txt", b"hello", "known kind"),
        ("a", b"hello", "known kind"),
    ],
)
def test_malformed_files_are_named(name, content, complaint, tmp_path):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ifa.IfaError, match=complaint) as error:
        load(path)
    assert str(path) in str(error.value)


def test_missing_files_and_directories(tmp_path):
    (tmp_path / "folder.obj").mkdir()
    for name in ("none.obj", "folder.obj"):
        with pytest.raises(ifa.IfaFileError, match=name):
            load(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "write", "unneeded"),
    [
        ("cut.ply", write_ply, b"\n"),
        ("cut.ply", lambda p: write_ply(p, "binary_little_endian"), b""),
        ("cut.stl", write_binary_stl, b""),
        ("cut.stl", write_ascii_stl, b" cube\n"),
        ("cut.off", write_off, b""),
    ],
)
def test_every_cut_of_a_file_is_an_error(name, write, unneeded, tmp_path):
    path = tmp_path / name
    write(path)
    whole = path.read_bytes()
    assert whole.endswith(unneeded)
    for length in range(len(whole) - len(unneeded)):
        path.write_bytes(whole[:length])
        with pytest.raises(ifa.IfaError, match=name):
            load(path)


def test_a_cut_obj_is_a_smaller_mesh_or_an_error(tmp_path):
    """The format announces nothing, so only what is begun and not ended can be seen."""
    path = tmp_path / "cut.obj"
    write_obj(path)
    whole = path.read_bytes()
    for length in range(len(whole) - 1):
        path.write_bytes(whole[:length])
        try:
            _, notes = load(path)
        except ifa.IfaError as error:
            assert path.name in str(error)
        else:
            assert any("open" in note for note in notes)


def test_obj_as_exporters_write_it(tmp_path, caplog, capfd):
    """Tabs, line ends, comments, materials, seams, backward counts before the last vertex."""
    path = tmp_path / "tetrahedron.obj"
    path.write_bytes(
        b"# caf\xe9\r\nmtllib no/such.mtl\n\tv  0 0 0 # first\nv 1 0 0\r\nv\t0 1 0 1 0.5 0\n"
        b"vt 0 0\nvt 1 0\nvn 0 0 1\nusemtl none/such\nf -3//1 -1//1 -2//1\nv 0 0 1\nusemtl b\n"
        b" f 1/1/1 2/2/1 4/2/1\no e\xe9\ng part\nf 2 3 \\\n4\nf -4/1 -1/2 -2/1 \n"
    )
    body, notes = load(path)
    assert body.mass_kg == pytest.approx(1 / 6, rel=1e-14)
    assert body.centre_of_mass_m == pytest.approx([0.25] * 3, rel=1e-14)
    assert len(notes) == 1
    assert "backwards" in notes[0]
    assert caplog.records == []
    assert capfd.readouterr() == ("", "")


def prism(corners):
    """Vertices, polygons and volume of a regular prism of height 1 in the unit circle."""
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(corners)], 1)
    sides = [(i, (i + 1) % corners) for i in range(corners)]
    faces = [tuple(range(corners))[::-1], tuple(range(corners, 2 * corners))]
    faces += [(i, j, j + corners, i + corners) for i, j in sides]
    volume = corners / 2 * np.sin(2 * np.pi / corners)
    return np.concatenate([ring, ring + np.array([0, 0, 1])]), faces, volume


def test_polygons_of_several_sizes(tmp_path):
    vertices, faces, volume = prism(7)
    points = [" ".join(map(repr, v)) for v in vertices.tolist()]
    rows = [" ".join(map(str, (len(f), *f))) for f in faces]
    counts = f"{len(points)} {len(rows)} 0\n"
    head = (
        f"element vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(rows)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    write_obj(tmp_path / "prism.obj", vertices, faces)
    (tmp_path / "prism.off").write_text("OFF\n" + counts + "\n".join(points + rows))
    (tmp_path / "prism.ply").write_text(
        "ply\nformat ascii 1.0\n" + head + "\n".join(points + rows) + "\n"
    )
    for ending in ("obj", "off", "ply"):
        body, notes = load(tmp_path / f"prism.{ending}")
        assert notes == ()
        assert body.mass_kg == pytest.approx(volume, rel=1e-14)
    # The second order has the length that faces all like its first would have.
    for order in (faces, [(0, 1, 2, 3), (0, 1, 2), (0, 1, 2, 3, 4)]):
        header = head.replace(f"face {len(rows)}", f"face {len(order)}")
        body = b"".join(struct.pack(f"<B{len(f)}i", len(f), *f) for f in order)
        (tmp_path / "mixed.ply").write_bytes(
            b"ply\nformat binary_little_endian 1.0\n" + header.encode() + vertices.tobytes() + body
        )
        with pytest.raises(ifa.IfaFileError, match=r"mixed\.ply.*corners|outside"):
            load(tmp_path / "mixed.ply")


def test_every_solid_of_an_stl_counts(tmp_path):
    path = tmp_path / "two.stl"
    write_ascii_stl(path)
    first = path.read_text()
    path.write_text(first + first.replace("0.5", "0.25").replace("cube", "cavity"))
    body, _ = load(path)
    assert body.mass_kg == pytest.approx(1.0, rel=1e-14)  # one within the other, wound alike
    path.write_text(first + first.replace(" 0.5", " 1.5").replace(" -0.5", " 0.5"))
    body, _ = load(path)
    assert body.mass_kg == pytest.approx(2.0, rel=1e-14)
