"""The symmetry group of a body."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Symmetry:
    """The turns and reflections that carry a body's hull and mass properties onto themselves.

    name: Schoenflies' name of the group, such as "Oh" (a cube), "D2h" (a box), "C1" (none);
    "Dinfh" and "Cinfv" turn freely about one axis (a coin, a cup), "Kh" about any (a ball).
    order: how many elements it has; `math.inf` with free turns. A prism of 64 sides or more counts
    with a subgroup of at most 255.
    elements: (n, 3, 3) orthogonal matrices in the body's axes, the identity first, then the other
    turns (determinant 1), then the reflections (-1). With free turns what is left without them:
    the maps that carry a half plane that is bounded by `axis` onto itself.
    axis: (3,) unit vector, in the body's axes, of the free turns; None where there are none, or
    where any axis is one.
    """

    name: str
    order: float
    elements: np.ndarray = field(repr=False)
    axis: np.ndarray | None = field(repr=False)

    @classmethod
    def _of(cls, core_body: object) -> Symmetry:
        name, continuous, elements, axis = core_body.symmetry()  # type: ignore[attr-defined]
        elements.flags.writeable = axis.flags.writeable = False
        order = math.inf if continuous else len(elements)
        return cls(name, order, elements, axis if continuous and name != "Kh" else None)
