"""The solid that a triangle mesh encloses, as meshes come: flipped, in pieces, badly welded."""

from __future__ import annotations

from collections import deque

import numpy as np

from ifa import _core
from ifa._core import IfaValueError

# Vertices closer than this share of the extent are one: above the noise of single precision files.
_WELD = 1e-6
# Gaps that total less than this share of the extent squared are closed: T-junctions of exporters.
_GAP_AREA = 1e-6
# Holes that total less than this share of the surface are closed too, and that is said.
_HOLE_SHARE = 0.01
_SMALLEST = 1e-15  # a piece of less than this share of the cubed extent encloses nothing
_OVERLAP_SAMPLES = 128  # points of a piece tested for lying inside another


def mesh_mass_properties(
    vertices: np.ndarray, triangles: np.ndarray, radius_m: float
) -> tuple[float, np.ndarray, np.ndarray, list[str]]:
    """Volume, centre (3,) and inertia (3, 3) at density 1 of a mesh's solid, and notes.

    Of the mesh without the rounding where it encloses a volume, else of its hull with it.

    Raises:
        IfaValueError: neither has a volume.
    """
    hull = _core.rounded_hull_mass_properties(vertices, radius_m, 1.0)
    if hull[0] <= 0.0:
        raise IfaValueError("vertices_m: their hull has no volume, which needs a radius_m above 0")
    solid = enclosed_solid(vertices, triangles)
    if solid is None:
        note = (
            "the mesh is open and encloses no volume; mass properties are those of its convex hull"
        )
        return *hull, [note]
    points, faces, notes = solid
    properties = _core.mass_properties(points, faces, 1.0)
    # more than the hull's, by more than rounding
    if not 0.0 < properties[0] <= hull[0] * (1.0 + 1e-6):
        note = "the mesh crosses itself; mass properties are those of its convex hull"
        return *hull, [note]
    return *properties, notes


def enclosed_solid(
    vertices: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray, list[str]] | None:
    """Vertices (n, 3) and outward triangles (m, 3) around the enclosed volume, and notes.

    Every closed piece is turned outwards; a piece inside another is a cavity if the two are wound
    against each other, else it adds nothing. None where the mesh does not enclose a volume.
    """
    for tolerance in (0.0, _WELD):
        points, faces = _weld(vertices, triangles, tolerance)
        notes: list[str] = []
        if not len(faces):
            continue
        if len(_boundary(faces)) and _turn_to_agree(faces):
            notes.append("some faces were wound against their neighbours and have been turned")
        closed = _close_gaps(points, faces, notes)
        if closed is None:
            continue
        solid = _oriented(points, _pieces(closed), notes)
        if solid is not None:
            return points, solid, notes
    return None


def _weld(
    vertices: np.ndarray, triangles: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Merge vertices, then drop triangles without three distinct corners and repeated ones."""
    points, inverse = np.unique(vertices, axis=0, return_inverse=True)
    index = inverse.reshape(-1)
    cell = tolerance * float(np.ptp(points, axis=0).max())
    if cell > 0.0:
        # several shifted grids, so that no pair of near vertices is parted by a cell's wall in all
        for shift in (0.0, 0.25, 0.5, 0.75):
            _, first, inverse = np.unique(
                np.floor((points - points[0]) / cell + shift), axis=0, return_index=True,
                return_inverse=True,
            )  # fmt: skip
            points, index = points[first], inverse.reshape(-1)[index]
    faces = index[triangles]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    if not len(faces):
        return points, faces
    start = np.argmin(faces, axis=1)
    turned = np.stack(
        [np.take_along_axis(faces, (start[:, None] + k) % 3, 1)[:, 0] for k in range(3)], 1
    )
    return points, np.unique(turned, axis=0)


def _directed_edges(faces: np.ndarray) -> np.ndarray:
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def _boundary(faces: np.ndarray) -> np.ndarray:
    """Directed edges (k, 2), repeated as often as they lack a partner the other way round."""
    edges = _directed_edges(faces)
    forward = edges[:, 0] < edges[:, 1]
    unique, inverse = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    balance = np.rint(np.bincount(inverse.reshape(-1), np.where(forward, 1.0, -1.0))).astype(int)
    rows = np.where((balance > 0)[:, None], unique, unique[:, ::-1])
    return np.repeat(rows, np.abs(balance), axis=0)


def _turn_to_agree(faces: np.ndarray) -> bool:
    """Turn faces, in place, to agree with their neighbours over edges of two faces."""
    edges = _directed_edges(faces)
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.lexsort(np.sort(edges, axis=1).T)
    same = np.all(np.diff(np.sort(edges, axis=1)[order], axis=0) == 0, axis=1)
    neighbours: list[list[tuple[int, bool]]] = [[] for _ in faces]
    for k in np.flatnonzero(same):
        shared_by_more = (k > 0 and same[k - 1]) or (k + 1 < len(same) and same[k + 1])
        if shared_by_more:
            continue
        i, j = order[k], order[k + 1]
        agree = edges[i, 0] != edges[j, 0]
        neighbours[owner[i]].append((owner[j], agree))
        neighbours[owner[j]].append((owner[i], agree))
    turn = np.full(len(faces), -1)
    for root in range(len(faces)):
        if turn[root] >= 0:
            continue
        turn[root] = 0
        patch, queue = [root], deque([root])
        while queue:
            here = queue.popleft()
            for there, agree in neighbours[here]:
                if turn[there] < 0:
                    turn[there] = turn[here] if agree else 1 - turn[here]
                    patch.append(there)
                    queue.append(there)
        if 2 * turn[patch].sum() > len(patch):  # the majority keeps its winding
            turn[patch] = 1 - turn[patch]
    turned = turn == 1
    faces[turned] = faces[turned][:, ::-1]
    return bool(turned.any())


def _close_gaps(points: np.ndarray, faces: np.ndarray, notes: list[str]) -> np.ndarray | None:
    """Cover gaps, as T-junctions leave them, and small holes; None where a large one is open."""
    boundary = _boundary(faces)
    if not len(boundary):
        return faces
    label = _components(len(points), boundary)
    loop = label[boundary[:, 0]]
    caps = np.column_stack([boundary[:, ::-1], loop])  # cones, the label is the lowest vertex
    area = _area(points, caps)
    if area > _GAP_AREA * float(np.ptp(points, axis=0).max()) ** 2:
        share = area / _area(points, faces)
        if share > _HOLE_SHARE:
            return None
        notes.append(f"the mesh is open; holes of {100 * share:.2g} % of its surface are closed")
    caps = caps[(caps[:, 0] != caps[:, 2]) & (caps[:, 1] != caps[:, 2])]
    return np.concatenate([faces, caps])


def _area(points: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _components(count: int, links: np.ndarray) -> np.ndarray:
    """For each of `count` items the lowest item that the links (k, 2) join it to."""
    label = np.arange(count)
    while True:
        low = np.minimum(label[links[:, 0]], label[links[:, 1]])
        new = label.copy()
        np.minimum.at(new, label[links[:, 0]], low)
        np.minimum.at(new, label[links[:, 1]], low)
        new = new[new]
        if np.array_equal(new, label):
            return label
        label = new


def _pieces(faces: np.ndarray) -> list[np.ndarray]:
    """Closed pieces: parted at edges of more than two faces if that leaves each closed."""
    edges = np.sort(_directed_edges(faces), axis=1)
    owner = np.tile(np.arange(len(faces)), 3)
    _, inverse, counts = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    simple = np.flatnonzero(counts[inverse.reshape(-1)] == 2)
    simple = simple[np.argsort(inverse.reshape(-1)[simple], kind="stable")]
    label = _components(len(faces), owner[simple].reshape(-1, 2))
    pieces = [faces[label == k] for k in np.unique(label)]
    if all(not len(_boundary(piece)) for piece in pieces):
        return pieces
    touching = _components(int(faces.max()) + 1, _directed_edges(faces))[faces[:, 0]]
    return [faces[touching == k] for k in np.unique(touching)]


def _volume(points: np.ndarray, faces: np.ndarray) -> float:
    return float(_core.mass_properties(points, faces, 1.0)[0])


def _winding(points: np.ndarray, faces: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Winding number of a closed piece about points (van Oosterom and Strackee 1983)."""
    out = np.empty(len(at))
    for k, p in enumerate(at):
        a, b, c = (points[faces[:, i]] - p for i in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        above = np.einsum("ij,ij->i", a, np.cross(b, c))
        below = (
            la * lb * lc
            + np.einsum("ij,ij->i", a, b) * lc
            + np.einsum("ij,ij->i", b, c) * la
            + np.einsum("ij,ij->i", c, a) * lb
        )
        out[k] = np.arctan2(above, below).sum() / (2.0 * np.pi)
    return out


def _surface_sample(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Corners of a piece and points along its edges, evenly thinned."""
    edges = points[np.unique(np.sort(_directed_edges(faces), axis=1), axis=0)]
    along = [(1.0 - t) * edges[:, 0] + t * edges[:, 1] for t in (0.21, 0.5, 0.83)]
    sample = np.concatenate([points[np.unique(faces)], *along])
    return sample[:: -(-len(sample) // _OVERLAP_SAMPLES)]


def _oriented(points: np.ndarray, pieces: list[np.ndarray], notes: list[str]) -> np.ndarray | None:
    """All triangles of the solid, outward; None where the pieces enclose no volume."""
    extent = float(np.ptp(points, axis=0).max())
    volumes = [_volume(points, piece) for piece in pieces]
    order = [
        k for k in np.argsort(np.abs(volumes))[::-1] if abs(volumes[k]) > _SMALLEST * extent**3
    ]
    low = {k: points[np.unique(pieces[k])].min(axis=0) for k in order}
    high = {k: points[np.unique(pieces[k])].max(axis=0) for k in order}
    factor: dict[int, int] = {}  # 1 adds volume, -1 is a cavity, 0 adds nothing
    overlap = False
    for k in order:
        factor[k] = 1
        for j in reversed([j for j in factor if j != k and factor[j] != 0]):  # the smallest first
            if (low[k] > high[j]).any() or (low[j] > high[k]).any():
                continue
            winding = np.abs(_winding(points, pieces[j], _surface_sample(points, pieces[k])))
            inside, outside = int((winding > 0.75).sum()), int((winding < 0.25).sum())
            if inside and not outside:
                against = np.sign(volumes[k]) != np.sign(volumes[j])
                factor[k] = -factor[j] if against else 0
                if not against:
                    notes.append("a closed piece lies inside another and is counted once")
                break
            overlap |= bool(inside and outside)
    if overlap:
        notes.append("closed pieces overlap; their common volume is counted twice")
    if any(volumes[k] * factor[k] < 0 and factor[k] > 0 for k in order):
        notes.append("wound inside out; turned")
    kept = [
        pieces[k] if volumes[k] * factor[k] > 0 else pieces[k][:, ::-1] for k in order if factor[k]
    ]
    if not kept:
        return None
    return np.concatenate(kept)
