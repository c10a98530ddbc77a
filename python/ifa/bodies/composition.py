"""Mass and shape of real things, put together from simple parts.

A part knows its mass, its centre and its inertia, and has triangles to be drawn with. Round parts
are exact; lofts are exact for the polygons they are drawn with. Joints may overlap by the thickness
of what they join. Lengths in m, densities in kg/m3.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ifa import _core
from ifa.body import Body

_CORNERS = 48  # of circles that are drawn


@dataclass(frozen=True)
class Part:
    """Mass properties, and a surface for drawing.

    mass_kg; centre_m (3,); inertia_kg_m2 (3, 3) about that centre; points_m (n, 3) and triangles
    (m, 3), indices into them, wound either way.
    """

    mass_kg: float
    centre_m: np.ndarray
    inertia_kg_m2: np.ndarray
    points_m: np.ndarray
    triangles: np.ndarray

    def moved(self, by_m: ArrayLike, axis: int = 2, turn_rad: float = 0.0) -> Part:
        """Turned about a coordinate axis through the origin, then shifted by `by_m` (3,)."""
        a, b = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[[a, b], [a, b]] = np.cos(turn_rad)
        turn[b, a], turn[a, b] = np.sin(turn_rad), -np.sin(turn_rad)
        shift = np.asarray(by_m)
        return Part(
            self.mass_kg,
            turn @ self.centre_m + shift,
            turn @ self.inertia_kg_m2 @ turn.T,
            self.points_m @ turn.T + shift,
            self.triangles,
        )


def join(parts: Iterable[Part]) -> Part:
    """All of them as one rigid part, by the parallel-axis theorem."""
    parts = list(parts)
    mass = sum(part.mass_kg for part in parts)
    centre = sum((part.mass_kg * part.centre_m for part in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        d = part.centre_m - centre
        inertia += part.inertia_kg_m2 + part.mass_kg * (d @ d * np.eye(3) - np.outer(d, d))
    first = np.cumsum([0, *(len(part.points_m) for part in parts)])
    return Part(
        mass,
        centre,
        inertia,
        np.concatenate([part.points_m for part in parts]),
        np.concatenate([part.triangles + k for part, k in zip(parts, first, strict=False)]),
    )


@dataclass(frozen=True)
class Model:
    """What a thing is made of, and the rounded hull with which it touches the ground.

    `vertices_m`, `radius_m` and `rings_m` as of `Body.from_vertices`, in the axes of the parts.
    """

    parts: tuple[Part, ...]
    vertices_m: np.ndarray
    radius_m: float
    rings_m: Sequence[Sequence[float]] = ()

    def body(self, **common: Any) -> Body:
        """The body, with `common` as the other arguments of `Body.from_vertices`."""
        whole = join(self.parts)
        return Body.from_vertices(
            self.vertices_m,
            self.radius_m,
            self.rings_m,
            mass_kg=whole.mass_kg,
            inertia_kg_m2=whole.inertia_kg_m2,
            centre_of_mass_m=whole.centre_m,
            **common,
        )


def box(size_m: ArrayLike, centre_m: ArrayLike, density: float) -> Part:
    """A solid box along the axes, of size (3,) about its centre (3,)."""
    size, centre = np.asarray(size_m, float), np.asarray(centre_m, float)
    mass = density * float(np.prod(size))
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    ends = [centre + 0.5 * size * np.column_stack([signs, np.full(4, end)]) for end in (-1.0, 1.0)]
    return Part(
        mass, centre, mass / 12.0 * np.diag(size @ size - size**2), *_loft(ends, around=True)
    )


def tube(
    start_m: ArrayLike, end_m: ArrayLike, radius_m: float, density: float, inner_m: float = 0.0
) -> Part:
    """A cylinder between the centres (3,) of its ends, with a bore of radius `inner_m`."""
    start, end = np.asarray(start_m, float), np.asarray(end_m, float)
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length
    mass = density * np.pi * (radius_m**2 - inner_m**2) * length
    along = 0.5 * mass * (radius_m**2 + inner_m**2)
    across = 0.5 * along + mass * length**2 / 12.0
    inertia = across * np.eye(3) + (along - across) * np.outer(axis, axis)
    outer = [_around(centre, axis, radius_m) for centre in (start, end)]
    inner = [_around(centre, axis, inner_m) for centre in (start, end)]
    surface = _loft([inner[0], outer[0], outer[1], inner[1], inner[0]], around=True)
    return Part(mass, 0.5 * (start + end), inertia, *surface)


def wire(points_m: ArrayLike, radius_m: float, density: float, closed: bool = False) -> Part:
    """Straight round rods through the points (n, 3); where `closed`, back to the first one."""
    points = np.asarray(points_m, float)
    if closed:
        points = np.concatenate([points, points[:1]])
    rods = join(tube(a, b, radius_m, density) for a, b in pairwise(points))
    along = np.diff(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    before = np.concatenate([along[-1:] if closed else along[:1], along])
    after = np.concatenate([along, along[:1] if closed else along[-1:]])
    across = np.cross(along[0], np.eye(3)[np.argmin(np.abs(along[0]))])
    sections = []  # drawn mitred, where rods would leave gaps
    for point, axis in zip(points, before + after, strict=True):
        axis = axis / np.linalg.norm(axis)
        across = across - across @ axis * axis
        across /= np.linalg.norm(across)
        x, y, _ = circle(radius_m, 0.0, _CORNERS // 2).T
        sections.append(point + np.outer(x, across) + np.outer(y, np.cross(axis, across)))
    points, triangles = _loft(sections, around=True)
    return replace(rods, points_m=points, triangles=triangles)


def lathe(profile_m: ArrayLike, thickness_m: float, density: float) -> Part:
    """A thin shell of revolution about z: conical bands through the (r, z) of a profile (n, 2)."""
    profile = np.asarray(profile_m, float)
    mass, moment, r2, z2 = 0.0, 0.0, 0.0, 0.0
    nodes = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)  # Gauss: exact for the cubics below
    for (r0, z0), (r1, z1) in pairwise(profile):
        r, z = r0 + (r1 - r0) * nodes, z0 + (z1 - z0) * nodes
        dm = np.pi * r * np.hypot(r1 - r0, z1 - z0) * thickness_m * density
        mass += dm.sum()
        moment += dm @ z
        r2 += dm @ r**2
        z2 += dm @ z**2
    height = moment / mass
    across = 0.5 * r2 + z2 - mass * height**2
    z_axis = np.array([0.0, 0.0, 1.0])
    sections = [_around(z * z_axis, z_axis, r) for r, z in profile]
    surface = _loft(sections, around=True, capped=False)
    return Part(float(mass), height * z_axis, np.diag([across, across, r2]), *surface)


def solid(sections_m: Iterable[ArrayLike], density: float, closed: bool = False) -> Part:
    """What polygons of equal length (k, 3) enclose, one after another and capped by the end ones.

    The caps are fans about their centres. `closed`: the last goes on into the first, uncapped.
    """
    sections = [np.asarray(s, float) for s in sections_m]
    points, triangles = _loft(
        [*sections, sections[0]] if closed else sections, around=True, capped=not closed
    )
    if _core.mass_properties(points, triangles, 1.0)[0] < 0.0:
        triangles = triangles[:, ::-1]
    volume, centre, inertia = _core.mass_properties(points, triangles, density)
    return Part(density * volume, centre, inertia, points, triangles)


def plate(
    left_m: ArrayLike, right_m: ArrayLike, low_m: float, high_m: float, density: float
) -> Part:
    """A flat solid from z = `low_m` to `high_m`, between two lines (n, 2) of points in x and y."""
    left, right = np.asarray(left_m, float), np.asarray(right_m, float)
    return solid(
        [
            [(*a, low_m), (*b, low_m), (*b, high_m), (*a, high_m)]
            for a, b in zip(left, right, strict=True)
        ],
        density,
    )


def skin(
    sections_m: Iterable[ArrayLike], thickness_m: float, density: float, around: bool = True
) -> Part:
    """A thin sheet through lines of equal length (k, 3), one after another.

    `around`: the lines close on themselves. Open ends stay open; a line whose points coincide
    closes one.
    """
    points, triangles = _loft([np.asarray(s, float) for s in sections_m], around, capped=False)
    corners = points[triangles]  # (m, 3, 3)
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    masses = 0.5 * np.linalg.norm(np.cross(ab, ac), axis=1) * thickness_m * density
    mass = float(masses.sum())
    total = corners.sum(axis=1)
    centre = masses @ total / (3.0 * mass)
    # of a triangle: the integral of r r^T is m / 12 (sum of its corners' r r^T, and of their sum's)
    corners = corners - centre
    total = total - 3.0 * centre
    second = np.einsum("t,tki,tkj->ij", masses, corners, corners)
    second += np.einsum("t,ti,tj->ij", masses, total, total)
    second /= 12.0
    return Part(mass, centre, np.trace(second) * np.eye(3) - second, points, triangles)


def mm(*values: float) -> np.ndarray:
    """A point or a size in mm, as metres."""
    return 1e-3 * np.array(values)


def corners(x_m: float, y_m: float, *z_m: float) -> np.ndarray:
    """The corners (4 k, 3) of rectangles of half sizes x and y at k heights, as polygons."""
    turns = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    return np.array([(x * x_m, y * y_m, z) for z in z_m for x, y in turns])


def circle(radius_m: ArrayLike, z_m: ArrayLike, count: int = _CORNERS) -> np.ndarray:
    """Points (count, 3) around z, counter-clockwise from the x axis."""
    angle = 2.0 * np.pi / count * np.arange(count)
    z = np.broadcast_to(z_m, count)
    return np.column_stack([radius_m * np.cos(angle), radius_m * np.sin(angle), z])


def ring(z_m: float, radius_m: float, x_m: float = 0.0) -> list[float]:
    """A row of `rings_m`: a circular edge about an axis along z."""
    return [x_m, 0.0, z_m, 0.0, 0.0, 1.0, radius_m]


def directions(count: int) -> np.ndarray:
    """Unit vectors (count, 3) spread evenly, on a Fibonacci spiral."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (3.0 - np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z**2)
    return np.column_stack([across * np.cos(angle), across * np.sin(angle), z])


def extremes(points_m: np.ndarray, count: int) -> np.ndarray:
    """At most `count` of the points (n, 3): the farthest ones in directions spread evenly."""
    return points_m[np.unique(np.argmax(directions(count) @ points_m.T, axis=1))]


def _around(centre: np.ndarray, axis: np.ndarray, radius_m: float) -> np.ndarray:
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    x, y, _ = circle(radius_m, 0.0).T
    return centre + np.outer(x, across) + np.outer(y, np.cross(axis, across))


def _loft(
    sections: Sequence[np.ndarray], around: bool, capped: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of the bands between lines; `capped`: fans close the end ones.

    Each four-sided cell is a fan about its centre, so that what is symmetric stays so.
    """
    n, k = len(sections), len(sections[0])
    i, j = np.meshgrid(np.arange(n - 1), np.arange(k if around else k - 1), indexing="ij")
    a, b = (i * k + j).ravel(), (i * k + (j + 1) % k).ravel()
    cells = np.column_stack([a, b, b + k, a + k])
    rims = [np.arange(k)[::-1], np.arange(k) + (n - 1) * k] if capped else []
    points = np.concatenate(sections)
    middles = [points[cells].mean(axis=1), *(points[rim].mean(axis=0)[None] for rim in rims)]
    middle = n * k + np.arange(len(cells))
    fans = [np.column_stack([cells[:, e], cells[:, (e + 1) % 4], middle]) for e in range(4)]
    for which, rim in enumerate(rims):
        top = np.full(k, n * k + len(cells) + which)
        fans.append(np.column_stack([rim, np.roll(rim, -1), top]))
    return np.concatenate([points, *middles]), np.concatenate(fans)
