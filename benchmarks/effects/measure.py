"""Times two ways of doing one thing in turns."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Row:
    """One effect on one scene: medians of CPU seconds, and what leaving the effect out changes.

    `spread` is that of the ratio between repeats, or seeds, from the lower to the upper quartile.
    `error` says of what it is in `error_of`, with its unit.
    """

    effect: str
    scene: str
    with_s: float
    without_s: float
    ratio: float
    spread: float
    error: float
    error_of: str

    def line(self) -> str:
        """As the table prints it."""
        return (
            f"{self.effect:18} {self.scene:34} {1e3 * self.with_s:9.2f} "
            f"{1e3 * self.without_s:9.2f} {self.ratio:6.2f} {self.spread:6.2f}  "
            f"{self.error:.3g} {self.error_of}"
        )


HEADER = (
    f"{'effect':18} {'scene':34} {'with ms':>9} {'without':>9} {'ratio':>6} {'+-':>6}"
    "  off by, without it"
)


def in_turns(
    with_it: Callable[[], Any], without_it: Callable[[], Any], repeats: int
) -> tuple[float, float, float, float]:
    """Median CPU seconds of both, and the median and quartile spread of their ratio.

    They take turns, so that what else the machine does falls on both.
    """
    took: list[tuple[float, float]] = []
    for _ in range(repeats + 1):
        pair = []
        for work in (with_it, without_it):
            start = time.process_time()
            work()
            pair.append(time.process_time() - start)
        took.append((pair[0], pair[1]))
    took = took[1:]  # the first warms up
    ratios = sorted(a / b for a, b in took)
    quartile = len(ratios) // 4
    return (
        statistics.median(a for a, _ in took),
        statistics.median(b for _, b in took),
        statistics.median(ratios),
        ratios[-1 - quartile] - ratios[quartile],
    )
