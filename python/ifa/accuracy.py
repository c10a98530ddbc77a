"""How accurately to solve: three presets, chosen by measurement, and the figures they rest on."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from ifa import _core, arguments
from ifa._core import IfaValueError

_LARGEST_BEAM = 1_000_000  # states; far beyond what any memory holds


@dataclass(frozen=True)
class Accuracy:
    """One preset of accuracy: how hard `ifa.solve` searches, and how exactly keys follow.

    ladder: states in the beam of each rung that is climbed. until: "succeeded" or "plausible", the
    motion that ends the climb. least_rung: which is climbed to even where a lower one reached that;
    of all rungs' motions the best is kept. time_budget_s: after which no rung begins, unless
    `ifa.solve` is given another. key_position_m, key_angle_rad: what keys made of the motion may
    leave it by, in between.
    """

    name: str
    ladder: tuple[int, ...]
    until: str
    least_rung: int
    time_budget_s: float
    key_position_m: float
    key_angle_rad: float

    def __post_init__(self) -> None:
        if self.until not in ("succeeded", "plausible"):
            raise IfaValueError(f'until: must be "succeeded" or "plausible", got {self.until!r}')
        if not self.ladder:
            raise IfaValueError("ladder: needs a rung")
        for beam in self.ladder:
            arguments.whole(beam, "ladder", _LARGEST_BEAM, least=1)
        arguments.whole(self.least_rung, "least_rung", len(self.ladder) - 1)
        for name in ("time_budget_s", "key_position_m", "key_angle_rad"):
            arguments.positive(getattr(self, name), name)

    def reached(self, *, succeeded: bool, plausible: bool) -> bool:
        """Whether such a motion is what the climb is after."""
        return plausible or (succeeded and self.until == "succeeded")


_STANDARD: tuple[int, ...] = _core.LADDER

ACCURACIES: Mapping[str, Accuracy] = {
    accuracy.name: accuracy
    for accuracy in (
        # A beam of 10 costs a quarter of the first standard rung and succeeds on half of the easy
        # scenes; from there on the ladder is the standard one, so that hard scenes are not lost.
        Accuracy("draft", (10, *_STANDARD), "succeeded", 0, 10.0, 2e-4, math.radians(0.1)),
        Accuracy("good", _STANDARD, "plausible", 0, 10.0, 5e-5, math.radians(0.02)),
        # More rungs find better motions more often than one larger one does.
        Accuracy("best", _STANDARD, "plausible", 3, 60.0, 1e-5, math.radians(0.005)),
    )
}
"""The presets by name, from the fastest to the most accurate."""


def named(name: Any) -> Accuracy:
    """The preset of that name, or one of the caller's own; raises IfaValueError."""
    if isinstance(name, Accuracy):
        return name
    try:
        return ACCURACIES[name]
    except (KeyError, TypeError):
        names = ", ".join(f'"{each}"' for each in ACCURACIES)
        raise IfaValueError(f"accuracy: must be one of {names}, got {name!r}") from None


@cache
def recorded() -> dict[str, Any]:
    """What `benchmarks/accuracy_presets --record` measured; CONVENTIONS.md describes it.

    `measured`: machine, date, versions. `points`: for each preset and each candidate the median and
    90th percentile of time (s) and error, and how many cases succeeded. `climbs`: what each rung
    cost and found on each case, which predictions compare with.
    """
    text = resources.files("ifa").joinpath("data/accuracy.json").read_text(encoding="utf-8")
    return json.loads(text)
