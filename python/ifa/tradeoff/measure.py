"""Measuring studies: every setting several times, all interleaved."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from statistics import median

from ifa._core import Cancelled, IfaError, Progress
from ifa.tradeoff.curve import Curve, Outcome, Point, Setting, Study
from ifa.tradeoff.pareto import pareto_front

# Where a setting has not been run yet it is expected to take so many times as long as the one
# before it in its study: steps and sizes are mostly doubled or tripled.
_GROWTH = 3.0
# A run that would take so many times its share of the time that is left waits for the shorter ones.
_PATIENCE = 4.0
_QUICK_SHARE = 0.6  # of the time, for studies that are not slow, where some are


def measure(
    studies: Sequence[Study],
    *,
    repeats: int,
    deadline_s: float = math.inf,
    progress: Progress | None = None,
    running: Progress | None = None,
) -> list[Curve]:
    """Run every setting of all studies `repeats` times and make the curves.

    All settings are run once before any is run again, the first ones of all studies before the
    second ones, so that a machine that slows down slows all of them; where time is short, long runs
    go to the end of their round. Before that the first setting of each study is run once without
    being counted: caches, threads and the clock warm up. Slow studies come after the others.

    Args:
        studies: What to measure.
        repeats: 1 or more.
        deadline_s: By `time.monotonic`. A run that would end later, going by what it or its
            predecessor took, is not begun; `Point.not_reached` counts them.
        progress: Cancels between runs.
        running: What the runs of these studies can be cancelled by. One that is under way at the
            deadline is, and counts as not reached.

    Raises:
        Cancelled: `progress` asked for it.
    """
    outcomes: dict[tuple[int, int], list[Outcome]] = {}
    took_s: dict[tuple[int, int], float] = {}

    def expected_s(study: int, row: int) -> float:
        if (study, row) in took_s:
            return took_s[study, row]
        return _GROWTH * expected_s(study, row - 1) if row else 0.0

    runs = max(1, sum(repeats * len(study.settings) + 1 for study in studies))
    done = 0
    until_s = deadline_s

    def turn(study: int, row: int, repeat: int) -> Outcome | None:
        nonlocal done
        if progress is not None:
            progress.raise_to(done / runs)
            if progress.cancelled:
                raise Cancelled("cancelled")
        done += 1
        began_s = time.monotonic()
        if began_s + expected_s(study, row) > until_s:
            return None
        try:
            outcome = _run(studies[study].settings[row], repeat)
        except Cancelled:
            asked = progress is not None and progress.cancelled
            if asked or running is None or not running.cancelled:
                raise
            return None
        # The longest so far: what a first run made ready, another repeat may have to make again.
        took_s[study, row] = max(took_s.get((study, row), 0.0), time.monotonic() - began_s)
        return outcome

    with _cancelled_at(deadline_s, running):
        for slow in (False, True):
            group = [k for k, study in enumerate(studies) if study.settings and study.slow == slow]
            left_s = deadline_s - time.monotonic()
            some_wait = not slow and any(study.slow for study in studies)
            until_s = time.monotonic() + _QUICK_SHARE * left_s if some_wait else deadline_s
            for index in group:
                turn(index, 0, 0)
            for repeat in range(repeats):
                pending, deferred = deque(_round_robin(studies, group)), deque[tuple[int, int]]()
                while pending or deferred:
                    index, row = (pending or deferred).popleft()
                    share_s = (until_s - time.monotonic()) / (1 + len(pending) + len(deferred))
                    if pending and expected_s(index, row) > _PATIENCE * share_s:
                        deferred.append((index, row))
                        continue
                    outcome = turn(index, row, repeat)
                    if outcome is not None:
                        outcomes.setdefault((index, row), []).append(outcome)
    return [
        _curve(
            study, [outcomes.get((index, row), []) for row in range(len(study.settings))], repeats
        )
        for index, study in enumerate(studies)
    ]


@contextmanager
def _cancelled_at(deadline_s: float, running: Progress | None) -> Iterator[None]:
    """Cancels what runs at the deadline."""
    if running is None or not math.isfinite(deadline_s):
        yield
        return
    timer = threading.Timer(max(0.0, deadline_s - time.monotonic()), running.cancel)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _round_robin(studies: Sequence[Study], group: Sequence[int]) -> Iterator[tuple[int, int]]:
    """(study, setting): the first setting of every study of the group, then the second ones."""
    for row in range(max((len(studies[index].settings) for index in group), default=0)):
        for index in group:
            if row < len(studies[index].settings):
                yield index, row


def _run(setting: Setting, repeat: int) -> Outcome:
    """One run; an error of the library is its failure, and NaN is one too."""
    began_s = time.perf_counter()
    try:
        outcome = setting.run(repeat)
    except Cancelled:
        raise
    except IfaError as error:
        return Outcome(time.perf_counter() - began_s, math.nan, str(error))
    if not outcome.failure and not math.isfinite(outcome.error):
        return Outcome(outcome.time_s, math.nan, "the error is not a finite number")
    return outcome


def _curve(study: Study, outcomes: Sequence[list[Outcome]], repeats: int) -> Curve:
    points = []
    for setting, runs in zip(study.settings, outcomes, strict=True):
        good = [run for run in runs if not run.failure]
        time_s, time_range_s = _spread([run.time_s for run in good or runs])
        error, error_range = _spread([run.error for run in good])
        points.append(
            Point(
                label=setting.label,
                series=setting.series,
                time_s=time_s,
                time_range_s=time_range_s,
                error=error,
                error_range=error_range,
                repeats=len(runs),
                failures=tuple(run.failure for run in runs if run.failure),
                on_front=False,
                not_reached=repeats - len(runs),
                losses=tuple(dict.fromkeys(loss for run in runs for loss in run.losses)),
            )
        )
    # A failure counts as boundless here, or a setting that fails often could shine by the rest.
    errors = [_median_error(runs) for runs in outcomes]
    front = pareto_front([p.time_s for p in points], errors)
    on_front = (replace(p, on_front=on) for p, on in zip(points, front, strict=True))
    # Without what its settings hold on to: databases, solves.
    return Curve(replace(study, settings=()), tuple(on_front))


def _median_error(runs: Sequence[Outcome]) -> float:
    """Over all repeats; NaN where the middle one failed."""
    error = median(math.inf if run.failure else run.error for run in runs) if runs else math.nan
    return error if math.isfinite(error) else math.nan


def _spread(values: Sequence[float]) -> tuple[float, tuple[float, float]]:
    if not values:
        return math.nan, (math.nan, math.nan)
    return median(values), (min(values), max(values))
