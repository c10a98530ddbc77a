"""Read the vertices and triangles of OBJ, STL, PLY and OFF files with trimesh.

A body needs little of a mesh file and all of it exactly, while trimesh reads what it can. So a file
is checked for what trimesh would pass over: what is announced or begun must have been read.
"""

from __future__ import annotations

import io
import logging
import os
import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ifa._core import IfaFileError

Mesh = tuple[np.ndarray, np.ndarray, list[str]]  # vertices (n, 3), triangles (m, 3), notes

_KINDS = (".obj", ".off", ".ply", ".stl")


class _Bad(Exception):
    """What is wrong with the file, without its name."""


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Vertices (n, 3) in the file's unit, triangles (m, 3) and notes on what was read in doubt.

    Faces of more than three corners are split into fans, plane or not. The ending of the name
    chooses the format. Nothing else that the file names, as a material, is opened.

    Raises:
        IfaFileError: the file is missing, of another format, malformed or without triangles.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in _KINDS:
        kinds = ", ".join(_KINDS)
        raise IfaFileError(f"{path}: not a mesh file of a known kind; its name must end in {kinds}")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise IfaFileError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        if not data.strip():
            raise _Bad("the file is empty")
        return _CHECKED[kind](data)
    except _Bad as error:
        raise IfaFileError(f"{path}: {error}") from None


def _load(data: bytes, kind: str) -> tuple[np.ndarray, np.ndarray, Any]:
    """Vertices, triangles and the raw elements of a PLY file, as trimesh reads them."""
    import trimesh  # takes half a second, which `import ifa` shall not

    try:
        with _quiet():
            scene = trimesh.load_scene(
                io.BytesIO(data), file_type=kind, resolver=None, process=False,
                skip_materials=True, maintain_order=True, fix_texture=False,
            )  # fmt: skip
            meshes = [m for m in scene.geometry.values() if isinstance(m, trimesh.Trimesh)]
            faces = [np.asarray(m.faces, dtype=np.int64) for m in meshes]
            vertices = [np.asarray(m.vertices, dtype=np.float64) for m in meshes]
    except Exception as error:  # whatever a malformed file makes trimesh stumble over
        reason = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, KeyError):
            reason += " is missing or unknown"
        elif "unmatched data" in reason:
            reason = "there is text where a number is due"
        raise _Bad(f"cannot be read as {kind.upper()}: {reason}") from None
    if not any(map(len, faces)):
        raise _Bad("holds no faces")
    for points, triangles in zip(vertices, faces, strict=True):
        if points.shape[1] != 3:
            raise _Bad("a vertex needs three coordinates")
        finite = np.isfinite(points).all(axis=1)
        if not finite.all():
            raise _Bad(f"vertex {int(np.argmin(finite)) + 1} has a coordinate that is not finite")
        if triangles.min() < 0 or triangles.max() >= len(points):
            raise _Bad(f"a face names a vertex outside the file's {len(points)}")
    offsets = np.cumsum([0, *map(len, vertices[:-1])])
    triangles = np.concatenate([f + k for f, k in zip(faces, offsets, strict=True)])
    return np.concatenate(vertices), triangles, meshes[0].metadata.get("_ply_raw")


@contextmanager
def _quiet() -> Iterator[None]:
    """No word from trimesh; text that is no number is an error with every NumPy."""
    log = logging.getLogger("trimesh")
    before = log.disabled
    log.disabled = True
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.filterwarnings("error", "string or file could not be read")
            yield
    finally:
        log.disabled = before


def _text(data: bytes) -> bytes:
    """ASCII with plain line ends; names and comments may be in any 8-bit encoding."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") or data[:4] == b"\x00\x00\xfe\xff":
        raise _Bad("is UTF-16 or UTF-32 text; save it as ASCII or UTF-8")
    if b"\x00" in data:
        raise _Bad("holds binary data where text is due")
    return re.sub(rb"\r\n?", b"\n", re.sub(rb"[^\x00-\x7f]", b"", data))


def _shown(line: bytes) -> str:
    return f"'{line.decode('ascii')[:60]}'"


def _read_obj(data: bytes) -> Mesh:
    # Out goes all that trimesh would split vertices or meshes by: textures, normals, materials.
    text = re.sub(rb"[ \t]+", b" ", _text(data).replace(b"\\\n", b" "))
    text = re.sub(rb"(?m)^ | ?#.*$|^usemtl.*$|/\S*| $", b"", text)
    notes = []
    for line in re.findall(rb"(?m)^v(?: \S+){0,2}$", text):
        raise _Bad(f"a vertex needs three coordinates, but {_shown(line)} has not")
    for line in re.findall(rb"(?m)^f(?: \S+){0,2}$", text):
        raise _Bad(f"a face needs at least three corners, but {_shown(line)} has not")
    if re.search(rb"(?m)^f .*-", text):
        text = _counted_forwards(text)
        notes.append(
            "some faces count their vertices backwards; read as relative to the face's line"
        )
    for line in re.findall(rb"(?m)^f .*(?<![\d.])-?0+(?= |$).*$", text):
        raise _Bad(f"vertices count from 1, but {_shown(line)} names vertex 0")
    vertices, triangles, _ = _load(text, "obj")  # raises where a coordinate is not finite
    if re.search(rb"(?mi)^v .*(?:nan|inf)", text):
        notes.append("some vertex colours are not finite; colours are ignored")
    faces = re.findall(rb"(?m)^f .*$", text)
    due = sum(face.count(b" ") - 2 for face in faces)
    if len(vertices) != len(re.findall(rb"(?m)^v ", text)) or len(triangles) != due:
        raise _Bad("some of its vertices or faces cannot be read")
    return vertices, triangles, notes


def _counted_forwards(text: bytes) -> bytes:
    """Negative indices made positive: to trimesh they count from the end of the file."""
    lines = text.split(b"\n")
    count = 0
    for i, line in enumerate(lines):
        count += line.startswith(b"v ")
        if line.startswith(b"f ") and b"-" in line:
            lines[i] = b" ".join(
                b"%d" % (count + 1 + int(word)) if re.fullmatch(rb"-\d+", word) else word
                for word in line.split(b" ")
            )
            if b"-" in lines[i]:
                raise _Bad(f"{_shown(line)} counts back to before the first vertex")
    return b"\n".join(lines)


def _read_off(data: bytes) -> Mesh:
    text = re.sub(rb"#.*", b"", _text(data))
    head = re.match(rb"\s*C?N?OFF\s+(\d+)\s+(\d+).*", text)
    if not head:
        raise _Bad("does not begin with OFF and the numbers of its vertices and faces")
    lines = [line for line in text[head.end() :].split(b"\n") if line.strip()]
    vertex_count, face_count = int(head[1]), int(head[2])
    if vertex_count + face_count > len(lines):
        raise _Bad(
            f"announces {vertex_count} vertices and {face_count} faces, but has {len(lines)} lines"
        )
    faces = []  # as fans, for trimesh reads at most four corners in this format
    for line in lines[vertex_count : vertex_count + face_count]:
        corners = _corners(line)
        faces += [b" ".join((b"3", corners[0], *pair)) for pair in pairwise(corners[1:])]
    text = b"OFF\n%d %d 0\n" % (vertex_count, len(faces))
    return *_load(text + b"\n".join(lines[:vertex_count] + faces), "off")[:2], []


def _corners(line: bytes) -> list[bytes]:
    """Of a face's line, which begins with their number."""
    count, *words = line.split() or [b""]
    if not re.fullmatch(rb"\d{1,9}", count) or not 3 <= int(count) <= len(words):
        raise _Bad(f"a face needs its number of corners, 3 or more, and that many: {_shown(line)}")
    return words[: int(count)]


def _read_stl(data: bytes) -> Mesh:
    # Binary files may begin with "solid" too, so the length decides first.
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + 50 * count:
        return *_load(data, "stl")[:2], []
    if data.lstrip()[:5].lower() != b"solid" or b"\x00" in data:
        if len(data) < 84:
            raise _Bad("is too short for a binary STL file and does not begin with 'solid'")
        raise _Bad(f"announces {count} triangles, which does not fit its {len(data)} bytes")
    text = _text(data)
    facets, corners, solids, ends = (
        len(re.findall(rb"(?mi)^\s*%s\b" % word, text))
        for word in (b"facet", b"vertex", b"solid", b"endsolid")
    )
    loop = rb"(?i)\bouter\s+loop(?:\s+vertex\s+\S+[ \t]+\S+[ \t]+\S+){3}\s+endloop\b"
    if not facets == len(re.findall(loop, text)) == corners / 3:
        raise _Bad("not every facet has exactly three vertices of three coordinates")
    if solids != ends:
        raise _Bad("does not end every solid with endsolid")
    vertices, triangles, _ = _load(text, "stl")
    if len(triangles) != facets:
        raise _Bad(f"has {facets} facets, of which {len(triangles)} are within solid and endsolid")
    return vertices, triangles, []


def _read_ply(data: bytes) -> Mesh:
    head = re.match(rb"ply\s*\n\s*format (\S+).*?\nend_header *\r?\n", data, re.DOTALL)
    if not head:
        raise _Bad("has no whole PLY header")
    kind = head[1].decode("latin-1")
    if kind not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise _Bad(f"has the unknown PLY format '{kind}'")
    if kind == "ascii":
        data = _text(data)
    try:
        vertices, triangles, elements = _load(data, "ply")
    except _Bad as error:
        if kind == "ascii":
            raise
        hint = "; in a binary file all faces must have the same number of corners"
        raise _Bad(f"{error}{hint}") from None
    face = elements["face"]
    first = next(iter(face["properties"].values()))
    if kind != "ascii":
        # trimesh takes the first face's number of corners for that of all
        for name in face["data"].dtype.names:
            column = face["data"][name]
            if column.dtype.names == ("f0", "f1") and (column["f0"] != column["f0"][0]).any():
                raise _Bad("is a binary file whose faces differ in their numbers of corners")
        return vertices, triangles, []
    lines = data[data.index(b"end_header") :].split(b"\n")[1:]
    start = 0
    for name, element in elements.items():
        rows = lines[start : start + element["length"]]
        start += element["length"]
        if len(rows) < element["length"] or any(not row.strip() for row in rows):
            raise _Bad(f"ends before all {element['length']} of its element '{name}'")
        if name == "face" and "LIST" in first:
            for row in rows:
                _corners(row)
    return vertices, triangles, []


_CHECKED: dict[str, Callable[[bytes], Mesh]] = {
    ".obj": _read_obj,
    ".off": _read_off,
    ".ply": _read_ply,
    ".stl": _read_stl,
}
