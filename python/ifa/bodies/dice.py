"""Dice of solid resin: fair polyhedra with rounded edges.

Their density is 1180 kg/m3, their size that between opposite faces (d4: the edge, before rounding),
their edges are rounded by 4 % of that distance (d4: of twice the distance from centre to face). The
moments are exact for the rounded solid.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from ifa.bodies.entry import Entry
from ifa.body import Body

_RESIN_KG_M3 = 1180.0
_ROUNDING = 0.04
_GOLDEN = (1.0 + np.sqrt(5.0)) / 2.0
_D4_EDGE_M = 20e-3


def _signs(*magnitudes: float) -> list[tuple[float, ...]]:
    return list(product(*[(m, -m) if m else (0.0,) for m in magnitudes]))


def _cyclic(points: list[tuple[float, ...]]) -> np.ndarray:
    return np.concatenate([np.roll(points, shift, axis=1) for shift in range(3)])


def _d4() -> np.ndarray:
    return np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / np.sqrt(8.0)  # edge 1


def _d6() -> np.ndarray:
    return np.array(_signs(0.5, 0.5, 0.5))


def _d8() -> np.ndarray:
    return _cyclic(_signs(1.0, 0.0, 0.0))


def _d10() -> np.ndarray:
    # A pentagonal trapezohedron. A face joins the apex (0, 0, H), two ring points at height h on
    # either side and the one between at -h, in one plane if H (1 - c) = h (1 + c), c = cos 36.
    c = np.cos(np.pi / 5.0)
    apex = 1.0  # as high as the ring is wide, which gives the usual blunt die
    angle = np.arange(10) * np.pi / 5.0
    height = apex * (1.0 - c) / (1.0 + c) * np.where(np.arange(10) % 2 == 0, 1.0, -1.0)
    ring = np.column_stack([np.cos(angle), np.sin(angle), height])
    return np.concatenate([ring, [(0.0, 0.0, apex), (0.0, 0.0, -apex)]])


def _d12() -> np.ndarray:
    return np.concatenate([_signs(1.0, 1.0, 1.0), _cyclic(_signs(0.0, 1.0 / _GOLDEN, _GOLDEN))])


def _d20() -> np.ndarray:
    return _cyclic(_signs(0.0, 1.0, _GOLDEN))


def _inradius(vertices: np.ndarray) -> float:
    """Distance from the origin to the nearest face: all are equally far in a fair die."""
    sharp = Body.from_vertices(vertices, mass_kg=1.0)
    a, b, c = (sharp.vertices_m[sharp.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return float((np.einsum("ij,ij->i", a, normals) / np.linalg.norm(normals, axis=1)).min())


def _die(shape: Callable[[], np.ndarray], across_m: float) -> Callable[..., Body]:
    """A die `across_m` between opposite faces, or twice as far as its faces are from the centre."""

    def make(**common: Any) -> Body:
        vertices = shape()
        radius = _ROUNDING * across_m
        core = vertices * ((0.5 * across_m - radius) / _inradius(vertices))
        # mass from the rounded solid at the density of resin
        return Body._from_hull(core, radius, None, _RESIN_KG_M3, common.pop("name"), common)

    return make


DICE = {
    "d4": Entry("edge 20 mm", "resin", _die(_d4, _D4_EDGE_M / np.sqrt(6.0))),
    "d6": Entry("16 mm across", "resin", _die(_d6, 16e-3)),
    "d8": Entry("15 mm across", "resin", _die(_d8, 15e-3)),
    "d10": Entry("16 mm across", "resin", _die(_d10, 16e-3)),
    "d12": Entry("18 mm across", "resin", _die(_d12, 18e-3)),
    "d20": Entry("20 mm across", "resin", _die(_d20, 20e-3)),
}
