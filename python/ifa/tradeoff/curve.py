"""What a knob costs and what it buys: settings that are measured, and the curve that they make."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from ifa._core import Progress
from ifa.body import Body
from ifa.marks import Signature
from ifa.solution import Solution
from ifa.solving import solve


@dataclass(frozen=True)
class Scene:
    """What is solved while the knobs are turned.

    progress: for calls that take long, so that they can be cancelled; their fraction goes nowhere.
    """

    body: Body
    marks: Signature
    seed: int = 0
    threads: int | None = None
    progress: Progress | None = None

    @cached_property
    def solution(self) -> Solution:
        """The scene solved once, for the knobs that need a motion. Raises as `ifa.solve` does."""
        return solve(
            self.body,
            self.marks,
            seed=self.seed,
            threads=self.threads,
            time_budget_s=2.0,
            progress=self.progress,
        )


@dataclass(frozen=True)
class Outcome:
    """One run of a setting: its time beside its error.

    error: of the study's own measure, 0 is exact. failure: why there is no error (then `error` does
    not count); empty where the run did what it should. losses: parts of the run that failed, each
    named, where the error is that of the rest ("2 of 40 throws: ODE could not go on").
    """

    time_s: float
    error: float
    failure: str = ""
    losses: tuple[str, ...] = ()


@dataclass(frozen=True)
class Setting:
    """One position of a knob. `run(k)` is its k-th repeat; searches take k for their seed."""

    label: str
    run: Callable[[int], Outcome]
    series: str = ""  # settings of one series are joined by a line


@dataclass(frozen=True)
class Study:
    """One knob on one scene.

    settings: the cheap ones first, as the first is run once more to warm up, and the costly ones
    are what a time limit leaves out. None where the knob does nothing on this scene: `note` says
    why.
    """

    knob: str  # a file name: "beam", "engine_step"
    title: str
    error_name: str  # with its unit: "contact-time error, ms"
    settings: tuple[Setting, ...]
    note: str = ""  # how the error is measured, against what
    slow: bool = False  # its first run makes much ready, a database: it waits for the others


@dataclass(frozen=True)
class Point:
    """A setting, measured: medians and the least and largest of its repeats that did not fail.

    Where all repeats failed the times are those of the failed runs. Where none was reached all
    figures are NaN.
    """

    label: str
    series: str
    time_s: float
    time_range_s: tuple[float, float]
    error: float  # NaN where all repeats failed
    error_range: tuple[float, float]
    repeats: int  # that were run, failed ones included
    failures: tuple[str, ...]  # one for each repeat that failed
    on_front: bool  # no other point is both faster and more accurate (Pareto), failures included
    not_reached: int = 0  # repeats that a time limit left out
    losses: tuple[str, ...] = ()  # of all repeats: parts of them that failed, each once

    @property
    def success(self) -> float:
        """The share of the repeats that did not fail; NaN where none was reached."""
        return 1.0 - len(self.failures) / self.repeats if self.repeats else math.nan


@dataclass(frozen=True)
class Curve:
    """A study, measured."""

    study: Study
    points: tuple[Point, ...]
