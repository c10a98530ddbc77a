"""An entry of the library: how large, of what, and how it is made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from ifa.bodies.composition import Model, Part
from ifa.body import Body


def _one_piece() -> tuple[Part, ...]:
    return ()


@dataclass(frozen=True)
class Entry:
    """`size`, outer, as text; `material`, a key of `MATERIALS`; what makes the body and its parts.

    `make` takes what `Body.from_vertices` takes beside shape and mass. `wheel`: how many times
    larger than a coin the edge is that it rolls on, and with it the lever arm of the rolling
    friction: the share of its weight that stops a wheel does not depend on its size.
    """

    size: str
    material: str
    make: Callable[..., Body]
    parts: Callable[[], tuple[Part, ...]] = _one_piece
    wheel: float = 1.0

    @classmethod
    def of(cls, size: str, material: str, model: Callable[[], Model], wheel: float = 1.0) -> Entry:
        """The entry of a thing that is put together from parts."""
        model = cache(model)
        return cls(
            size,
            material,
            lambda **common: model().body(**common),
            lambda: model().parts,
            wheel,
        )
