"""The kinds of cases, and what each has to reach on two cores."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import ifa

from . import recorded, rhythm, simulated
from .bars import Bar
from .cases import Case, spread


@dataclass(frozen=True)
class Kind:
    """Cases of one kind.

    make: the cases, of the folder of evaluation data, and at most so many. file: of that folder, if
    it is needed. argument: of `ifa.solve`, if one is needed that it may not have yet.
    """

    name: str
    what: str
    make: Callable[[Path, int | None], list[Case]]
    bar: Bar
    file: str = ""
    argument: str = ""

    def missing(self, shared: Path) -> str:
        """Why the cases cannot be made or solved, in one sentence; empty if they can."""
        if self.file and not (shared / self.file).exists():
            return f"{self.name}: skipped, there is no evaluation data at {shared / self.file}"
        if self.argument and self.argument not in inspect.signature(ifa.solve).parameters:
            return f"{self.name}: skipped, ifa.solve has no argument {self.argument!r} yet"
        return ""


def _spread(make: Callable[[Path], list[Case]]) -> Callable[[Path, int | None], list[Case]]:
    return lambda shared, limit: spread(make(shared), limit)


_KINDS = (
    Kind(
        "sounds", "recordings, every hit, material fitted", _spread(recorded.sounds),
        Bar(12, succeeded=12, plausible=12, median_retime_percent=2.0, median_solve_s=0.5,
            longest_solve_s=10.0),
        file="sounds",
    ),
    Kind(
        "labels", "recordings, labels with spans, material fitted", _spread(recorded.labels),
        Bar(12, succeeded=11),
        file="sounds",
    ),
    Kind(
        "tosses", "tosses of a cube, every hit, material measured", _spread(recorded.tosses),
        Bar(179, succeeded=179, plausible=170),
        file="tosses/cube_tosses.json",
    ),
    Kind(
        "toss_events", "tosses of a cube, intervals of contact as in the paper",
        _spread(recorded.toss_events),
        Bar(179, succeeded=162),  # 90 %
        file="tosses/cube_tosses.json",
    ),
    Kind(
        "balls", "bounces of real balls, no loudness, open, material fitted",
        _spread(recorded.balls),
        Bar(22, succeeded=22, plausible=20),  # 90 %
        file="tosses/ball_bounces.json",
    ),
    Kind(
        "simulated", "simulations, restitution off by 10 % and shape by 3 %",
        lambda _, limit: simulated.simulated(limit),
        Bar(500, succeeded=495, plausible=450),  # 99 %, 90 %
    ),
    Kind(
        "rolls", "30 marks of simulated rolls, off as much, open",
        _spread(lambda _: simulated.rolls()),
        Bar(5, succeeded=5, longest_solve_s=2.0),
    ),
    Kind(
        "rhythm", "200 hits of a drum pattern, energy gain allowed, open",
        _spread(lambda _: rhythm.rhythm()),
        Bar(2, succeeded=2, longest_solve_s=10.0),
    ),
    Kind(
        "nudges", "a simulated roll of 15 marks again, one of them 5 ms later",
        _spread(lambda _: simulated.nudges()),
        Bar(3, succeeded=3, longest_solve_s=0.1),
        argument="reuse",
    ),
)  # fmt: skip

KINDS = {kind.name: kind for kind in _KINDS}
