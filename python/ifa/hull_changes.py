"""Coarser hulls, and hulls whose faces are moved."""

from __future__ import annotations

import numpy as np

from ifa import _core
from ifa._core import IfaValueError

_SAME_POINT = 1e-9  # of the hull's size: corners that meet there are one


def farthest_points(points_m: np.ndarray, count: int) -> np.ndarray:
    """At most `count` of the points (n, 3), each the farthest from those before it.

    The first is the farthest from the origin, ties go to the earlier row. No other choice of as
    many halves the distance that the points left out are from the nearest one kept (Gonzalez 1985).
    """
    if count >= len(points_m):
        return points_m.copy()
    kept = [int(np.argmax((points_m**2).sum(axis=1)))]
    nearest = np.full(len(points_m), np.inf)
    while len(kept) < count:
        nearest = np.minimum(nearest, ((points_m - points_m[kept[-1]]) ** 2).sum(axis=1))
        kept.append(int(np.argmax(nearest)))
    return points_m[sorted(kept)]


def inset_hull(
    vertices_m: np.ndarray, rings_m: np.ndarray, inset_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """The hull of vertices (n, 3) or of rings (k, 7) with every face moved inwards by `inset_m`.

    Negative moves them outwards. The origin is inside and stays so, else IfaValueError. A body of
    both vertices and rings is refused.
    """
    if inset_m == 0.0:
        return vertices_m, rings_m
    if not len(rings_m):
        return _inset_vertices(vertices_m, inset_m), rings_m
    if len(vertices_m):
        raise IfaValueError("radius_m: cannot be changed of a body of vertices and circular edges")
    rings = rings_m.copy()
    height = (rings[:, :3] * rings[:, 3:6]).sum(axis=1, keepdims=True)
    rings[:, :3] -= np.sign(height) * inset_m * rings[:, 3:6]
    rings[:, 6] -= inset_m
    if (np.abs(height[:, 0]) <= inset_m).any() or (rings[:, 6] <= 0.0).any():
        raise IfaValueError("radius_m: leaves nothing of the body's circular edges")
    return np.empty((0, 3)), rings


def _inset_vertices(vertices_m: np.ndarray, inset_m: float) -> np.ndarray:
    """Corners of the moved faces, by duality.

    A face n.x = d is the point n / d of the dual hull, and a face m.y = 1 of the dual hull is the
    corner m.
    """
    normals, distances_m = _faces(vertices_m)
    if not len(normals) or distances_m.min() <= 0.0:
        raise IfaValueError("radius_m: cannot be changed of a hull without volume about its centre")
    moved_m = distances_m - inset_m
    if moved_m.min() <= 0.0:
        raise IfaValueError(
            f"radius_m: must be less than {1e3 * distances_m.min():.4g} mm more than it is"
        )
    dual_normals, dual_distances = _faces(normals / moved_m[:, None])
    corners = dual_normals / dual_distances[:, None]
    keys = np.round(corners / (_SAME_POINT * np.abs(corners).max()))
    return corners[np.sort(np.unique(keys, axis=0, return_index=True)[1])]


def _faces(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outward unit normals (m, 3) and distances (m,) from the origin of the hull's triangles."""
    hull, triangles, _ = _core.convex_hull(points)
    if not len(triangles):
        return np.empty((0, 3)), np.empty(0)
    a, b, c = (hull[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, (normals * a).sum(axis=1)
