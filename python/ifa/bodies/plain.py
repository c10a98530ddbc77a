"""Things of one solid piece: the rounded hull is the thing, its mass spread evenly over it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ifa.bodies.entry import Entry
from ifa.body import Body


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


PLAIN = {
    "ball": Entry(
        "27 mm, solid", "rubber", lambda **common: Body.ball(13.5e-3, mass_kg=12e-3, **common)
    ),
    "coin": Entry("25.75 x 2.2 mm", "metal", _coin),
    "eraser": Entry("43 x 17 x 11 mm", "vinyl", _box((43e-3, 17e-3, 11e-3), 11e-3, 0.8e-3)),
    "card": Entry("85.6 x 54 x 0.76 mm", "plastic", _box((85.6e-3, 54e-3, 0.76e-3), 5e-3, 0.1e-3)),
}
