"""Read the vertices and triangles of OBJ, STL, PLY and OFF files; the rest of them is ignored.

Readers of our own, for a body needs little of a mesh file and all of it exactly: a number that is
not one, an index out of range or a truncated file must be an error that names the line, not a mesh
that is nearly right.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from ifa._core import IfaFileError

Mesh = tuple[np.ndarray, np.ndarray, list[str]]  # vertices (n, 3), triangles (m, 3), notes


class _Bad(Exception):
    """What is wrong with the file, without its name."""


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Vertices (n, 3) in the file's unit, triangles (m, 3) and notes on what was read in doubt.

    Faces of more than three corners are split into fans. The ending of the name chooses the format.

    Raises:
        IfaFileError: the file is missing, of another format, malformed or without triangles.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        kinds = ", ".join(sorted(_READERS))
        raise IfaFileError(f"{path}: not a mesh file of a known kind; its name must end in {kinds}")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise IfaFileError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        if not data.strip():
            raise _Bad("the file is empty")
        vertices, faces, notes = reader(data)
        vertices = np.ascontiguousarray(vertices, dtype=np.float64).reshape(-1, 3)
        finite = np.isfinite(vertices).all(axis=1)
        if not finite.all():
            raise _Bad(f"vertex {int(np.argmin(finite)) + 1} has a coordinate that is not finite")
        triangles = np.ascontiguousarray(faces, dtype=np.int64).reshape(-1, 3)
        if not len(triangles):
            raise _Bad("holds no faces")
        if triangles.min() < 0 or triangles.max() >= len(vertices):
            raise _Bad(f"a face names a vertex outside the file's {len(vertices)}")
    except _Bad as error:
        raise IfaFileError(f"{path}: {error}") from None
    return vertices, triangles, notes


def _text(data: bytes) -> str:
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") or data[:4] == b"\x00\x00\xfe\xff":
        raise _Bad("is UTF-16 or UTF-32 text; save it as ASCII or UTF-8")
    if b"\x00" in data:
        raise _Bad("holds binary data where text is due")
    # names and comments may be in any 8-bit encoding; what is read here is ASCII
    return data.removeprefix(b"\xef\xbb\xbf").decode("latin-1")


def _numbers(words: list[str], line: int, what: str) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError:
        raise _Bad(f"line {line}: {what} '{' '.join(words)[:60]}' is not numbers") from None


def _integer(word: str, line: int) -> int:
    try:
        return int(word)
    except ValueError:
        raise _Bad(f"line {line}: '{word[:30]}' is not a whole number") from None


def _fan(corners: list[int]) -> Iterator[tuple[int, int, int]]:
    return ((corners[0], corners[i - 1], corners[i]) for i in range(2, len(corners)))


def _read_obj(data: bytes) -> Mesh:
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    pending: list[tuple[int, list[int]]] = []
    relative = bad_colour = False
    text = _text(data).replace("\\\r\n", " ").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        if words[0] == "v":
            if len(words) < 4:
                raise _Bad(f"line {number}: a vertex needs three coordinates")
            vertices.append(_numbers(words[1:4], number, "vertex"))
            bad_colour |= not np.isfinite(_numbers(words[4:], number, "vertex colour")).all()
        elif words[0] == "f":
            if len(words) < 4:
                raise _Bad(f"line {number}: a face needs at least three corners")
            corners = []
            for word in words[1:]:
                index = _integer(word.split("/", 1)[0], number)
                if index < 0:
                    relative = True
                    index += len(vertices) + 1
                    if index < 1:
                        raise _Bad(
                            f"line {number}: face corner '{word}' lies before the first vertex"
                        )
                elif index == 0:
                    raise _Bad(f"line {number}: vertices count from 1, but a face names vertex 0")
                corners.append(index - 1)
            pending.append((number, corners))
    for number, corners in pending:  # now all vertices are known
        if max(corners) >= len(vertices):
            raise _Bad(f"line {number}: a face names vertex {max(corners) + 1} of {len(vertices)}")
        triangles.extend(_fan(corners))
    notes = []
    if relative:
        notes.append(
            "some faces count their vertices backwards; read as relative to the face's line"
        )
    if bad_colour:
        notes.append("some vertex colours are not finite; colours are ignored")
    return np.array(vertices), np.array(triangles), notes


def _read_off(data: bytes) -> Mesh:
    lines = [
        (number, words)
        for number, line in enumerate(_text(data).splitlines(), 1)
        if (words := line.split("#", 1)[0].split())
    ]
    number, head = lines[0] if lines else (1, [""])
    if head[0] not in ("OFF", "COFF", "NOFF", "CNOFF"):
        raise _Bad("does not begin with OFF")
    head = head[1:]
    lines = lines[1:]
    if not head:
        if not lines:
            raise _Bad("ends after its first line")
        number, head = lines.pop(0)
    if len(head) < 2:
        raise _Bad(f"line {number}: the numbers of vertices and faces are due")
    vertex_count, face_count = _integer(head[0], number), _integer(head[1], number)
    if vertex_count < 0 or face_count < 0 or vertex_count + face_count > len(lines):
        raise _Bad(
            f"announces {vertex_count} vertices and {face_count} faces, but has {len(lines)} lines"
        )
    vertices = []
    for number, words in lines[:vertex_count]:
        if len(words) < 3:
            raise _Bad(f"line {number}: a vertex needs three coordinates")
        vertices.append(_numbers(words[:3], number, "vertex"))
    triangles: list[tuple[int, int, int]] = []
    for number, words in lines[vertex_count : vertex_count + face_count]:
        count = _integer(words[0], number)
        if count < 3 or len(words) < count + 1:
            raise _Bad(
                f"line {number}: a face needs its number of corners, 3 or more, and that many"
            )
        corners = [_integer(word, number) for word in words[1 : count + 1]]
        if min(corners) < 0 or max(corners) >= vertex_count:
            raise _Bad(f"line {number}: a face names a vertex outside 0 to {vertex_count - 1}")
        triangles.extend(_fan(corners))
    return np.array(vertices), np.array(triangles), []


def _read_stl(data: bytes) -> Mesh:
    # Binary files may begin with "solid" too, so the length decides first.
    if len(data) >= 84:
        (count,) = struct.unpack_from("<I", data, 80)
        if len(data) == 84 + 50 * count:
            return _stl_mesh(_binary_stl(data, count))
    if data.lstrip()[:5].lower() != b"solid" or b"\x00" in data:
        if len(data) < 84:
            raise _Bad("is too short for a binary STL file and does not begin with 'solid'")
        if len(data) > 84 + 50 * count and count:
            return _stl_mesh(_binary_stl(data, count))  # some writers append their own data
        raise _Bad(f"announces {count} triangles, which does not fit its {len(data)} bytes")
    corners: list[list[float]] = []
    open_loop = 0
    for number, line in enumerate(_text(data).splitlines(), 1):
        words = line.split()
        keyword = words[0].lower() if words else ""
        if keyword == "outer":
            open_loop = len(corners)
        elif keyword == "vertex":
            if len(words) != 4:
                raise _Bad(f"line {number}: a vertex needs three coordinates")
            corners.append(_numbers(words[1:], number, "vertex"))
        elif keyword == "endloop" and len(corners) - open_loop != 3:
            raise _Bad(f"line {number}: a facet needs three vertices")
    if len(corners) % 3:
        raise _Bad("ends within a facet")
    return _stl_mesh(np.array(corners).reshape(-1, 3))


def _binary_stl(data: bytes, count: int) -> np.ndarray:
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.frombuffer(data, facet, count, 84)["corners"].reshape(-1, 3).astype(np.float64)


def _stl_mesh(corners: np.ndarray) -> Mesh:
    return corners, np.arange(len(corners)).reshape(-1, 3), []


_PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip


def _read_ply(data: bytes) -> Mesh:
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise _Bad("has no PLY header")
    body_start = data.find(b"\n", end) + 1
    kind = ""
    elements: list[tuple[str, int, list[tuple[str, ...]]]] = []
    for number, line in enumerate(data[:end].decode("latin-1").splitlines(), 1):
        words = line.split()
        try:
            if words[:1] == ["format"]:
                kind = words[1]
            elif words[:1] == ["element"]:
                elements.append((words[1], _integer(words[2], number), []))
            elif words[:1] == ["property"]:
                types = words[2:4] if words[1] == "list" else words[1:2]
                elements[-1][2].append((words[-1], *(_PLY_TYPES[t] for t in types)))
        except (IndexError, KeyError):
            raise _Bad(f"line {number}: '{line[:60]}' is not a PLY header line") from None
    next_value = _ply_values(data[body_start:], kind)
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for name, count, properties in elements:
        names = [p[0] for p in properties]
        if count < 0 or (count > len(data) and properties):
            raise _Bad(f"announces {count} of element '{name}', more than its bytes can hold")
        if name == "vertex" and not {"x", "y", "z"} <= set(names):
            raise _Bad("its vertices have no x, y and z")
        for _ in range(count if properties else 0):
            row: dict[str, list[float]] = {}
            for property_name, *types in properties:
                many = int(next_value(types[0])) if len(types) == 2 else 1
                row[property_name] = [next_value(types[-1]) for _ in range(many)]
            if name == "vertex":
                vertices.append([row["x"][0], row["y"][0], row["z"][0]])
            elif name == "face":
                corners = row.get("vertex_indices", row.get("vertex_index", []))
                if len(corners) < 3:
                    raise _Bad("a face has fewer than three corners")
                triangles.extend(_fan([int(c) for c in corners]))
    return np.array(vertices), np.array(triangles), []


def _ply_values(body: bytes, kind: str) -> Callable[[str], float]:
    """A function that gives the next value of a NumPy type code from the body of a PLY file."""
    if kind == "ascii":
        words = iter(_text(body).split())

        def next_word(code: str) -> float:
            word = next(words, None)
            if word is None:
                raise _Bad("ends before all its elements")
            try:
                return float(word) if code[0] == "f" else int(word)
            except ValueError:
                raise _Bad(f"'{word[:30]}' is not a number of the announced type") from None

        return next_word
    if kind not in ("binary_little_endian", "binary_big_endian"):
        raise _Bad(f"has the unknown PLY format '{kind}'")
    order = "<" if kind == "binary_little_endian" else ">"
    characters = {
        "i1": "b",
        "u1": "B",
        "i2": "h",
        "u2": "H",
        "i4": "i",
        "u4": "I",
        "f4": "f",
        "f8": "d",
    }
    structs = {code: struct.Struct(order + character) for code, character in characters.items()}
    position = 0

    def next_binary(code: str) -> float:
        nonlocal position
        try:
            (value,) = structs[code].unpack_from(body, position)
        except struct.error:
            raise _Bad("ends before all its elements") from None
        position += structs[code].size
        return value

    return next_binary


_READERS: dict[str, Callable[[bytes], Mesh]] = {
    ".obj": _read_obj,
    ".off": _read_off,
    ".ply": _read_ply,
    ".stl": _read_stl,
}
