"""A library of everyday bodies, written from their real sizes: `get("d6", surface="desk")`.

Sizes and masses are of common real objects. Dice are solid resin of 1180 kg/m3, their size that
between opposite faces (d4: the edge, before rounding), their edges rounded by 4 % of that distance
(d4: of twice the distance from centre to face). The rest have the mass of the real thing. Mass is
spread evenly, and the moments are exact for the rounded solid. Restitution and friction are
estimates, good to perhaps 0.15: they vary more between two desks than between two kinds of dice.
Fit them to the sound where it matters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ifa._core import IfaValueError
from ifa.body import Body

_RESIN_KG_M3 = 1180.0
_DICE_ROUNDING = 0.04
_GOLDEN = (1.0 + np.sqrt(5.0)) / 2.0

# Estimates: (restitution, friction) on each surface.
_MATERIALS = {
    "resin": {"desk": (0.50, 0.25), "wood": (0.45, 0.30), "carpet": (0.15, 0.55)},
    "rubber": {"desk": (0.80, 0.70), "wood": (0.75, 0.70), "carpet": (0.50, 0.90)},
    "metal": {"desk": (0.45, 0.20), "wood": (0.40, 0.30), "carpet": (0.10, 0.45)},
    "vinyl": {"desk": (0.35, 0.60), "wood": (0.35, 0.60), "carpet": (0.15, 0.80)},
    "plastic": {"desk": (0.25, 0.25), "wood": (0.25, 0.30), "carpet": (0.05, 0.50)},
}
# Estimates: lever arm of the rolling and spinning resistance.
_ROLLING_M = {"desk": 5e-5, "wood": 8e-5, "carpet": 1e-3}


@dataclass(frozen=True)
class _Entry:
    size: str
    material: str
    make: Callable[..., Body]


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
        radius = _DICE_ROUNDING * across_m
        core = vertices * ((0.5 * across_m - radius) / _inradius(vertices))
        # mass from the rounded solid at the density of resin
        return Body._from_hull(core, radius, None, _RESIN_KG_M3, common.pop("name"), common)

    return make


def _box(
    size_m: tuple[float, float, float], mass_kg: float, radius_m: float
) -> Callable[..., Body]:
    return lambda **common: Body.box(size_m, mass_kg=mass_kg, radius_m=radius_m, **common)


def _coin(**common: Any) -> Body:
    diameter, thickness, radius = 25.75e-3, 2.2e-3, 0.2e-3
    rim, half = 0.5 * diameter - radius, 0.5 * thickness - radius
    rings = [[0.0, 0.0, z, 0.0, 0.0, 1.0, rim] for z in (half, -half)]
    return Body.from_vertices(
        [], radius, rings, mass_kg=8.5e-3, centre_of_mass_m=np.zeros(3), **common
    )


_D4_EDGE_M = 20e-3

_LIBRARY = {
    "d4": _Entry("edge 20 mm", "resin", _die(_d4, _D4_EDGE_M / np.sqrt(6.0))),
    "d6": _Entry("16 mm across", "resin", _die(_d6, 16e-3)),
    "d8": _Entry("15 mm across", "resin", _die(_d8, 15e-3)),
    "d10": _Entry("16 mm across", "resin", _die(_d10, 16e-3)),
    "d12": _Entry("18 mm across", "resin", _die(_d12, 18e-3)),
    "d20": _Entry("20 mm across", "resin", _die(_d20, 20e-3)),
    "ball": _Entry(
        "27 mm, solid", "rubber", lambda **common: Body.ball(13.5e-3, mass_kg=12e-3, **common)
    ),
    "coin": _Entry("25.75 x 2.2 mm", "metal", _coin),
    "eraser": _Entry("43 x 17 x 11 mm", "vinyl", _box((43e-3, 17e-3, 11e-3), 11e-3, 0.8e-3)),
    "card": _Entry("85.6 x 54 x 0.76 mm", "plastic", _box((85.6e-3, 54e-3, 0.76e-3), 5e-3, 0.1e-3)),
}


def names() -> list[str]:
    """The names that `get` knows."""
    return list(_LIBRARY)


def surfaces() -> list[str]:
    """The surfaces that `get` knows."""
    return list(_ROLLING_M)


def get(name: str, surface: str = "desk") -> Body:
    """The body `name` with its material on `surface`.

    Raises:
        IfaValueError: no such body or surface; the message lists those that exist.
    """
    entry = _LIBRARY.get(name) if isinstance(name, str) else None
    if entry is None:
        raise IfaValueError(f"body: no {name!r} in the library; it has {', '.join(_LIBRARY)}")
    if not isinstance(surface, str) or surface not in _ROLLING_M:
        raise IfaValueError(f"surface: no '{surface}'; there are {', '.join(_ROLLING_M)}")
    restitution, friction = _MATERIALS[entry.material][surface]
    return entry.make(
        name=name,
        restitution=restitution,
        friction=friction,
        rolling_friction_m=_ROLLING_M[surface],
        spin_friction_m=_ROLLING_M[surface],
    )


def describe() -> list[dict[str, Any]]:
    """One entry for each body: `name`, `size`, `material`, `mass_kg`, `radius_m`, `vertices` and
    `rings` (how many) and `surfaces`, which maps each to its `restitution` and `friction`.
    """  # noqa: D205
    rows = []
    for name, entry in _LIBRARY.items():
        body = get(name)
        rows.append(
            {
                "name": name,
                "size": entry.size,
                "material": entry.material,
                "mass_kg": body.mass_kg,
                "radius_m": body.radius_m,
                "vertices": len(body.vertices_m),
                "rings": len(body.rings_m),
                "surfaces": {
                    surface: {"restitution": restitution, "friction": friction}
                    for surface, (restitution, friction) in _MATERIALS[entry.material].items()
                },
            }
        )
    return rows
