"""What a solve will take and how good its motion will be, said before it is made."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from ifa import _core, accuracy, arguments, solving
from ifa.accuracy import ACCURACIES, Accuracy
from ifa.body import Body
from ifa.marks import Signature
from ifa.solution import Prediction

CALIBRATION_S = 1.0
"""The longest that the calibration of a prediction takes, s."""

FACTOR = 2.0
"""A prediction is right where what comes true is within this factor of it."""

_Clock = Callable[[], float]

_ENDING_S = 0.05  # that the calibration keeps for what it cuts off
_POLL_S = 0.005  # how often the calibration's end is looked for
_LARGEST_BEAM = 1080  # that a calibration tries
_HOPE = 0.6  # a rung is begun if this share of what its beam lets expect fits: some end early
_MARKS_SCALE = 0.7  # of the logarithm of the number of marks, within which scenes count as alike
_LEAST_ERROR = 1e-6  # below which errors are not told apart
_LEAST_WEIGHT = 0.05  # of a recorded scene that is unlike in that
_PROBE = Accuracy("probe", (1,), "plausible", 0, 10.0, 1.0, 1.0)


@dataclass(frozen=True)
class Rung:
    """What one rung of a climb cost and found; error is 1 - Score.

    Where constraints are not met it counts as neither succeeded nor plausible.
    """

    beam: int
    time_s: float
    succeeded: bool
    plausible: bool
    error: float
    whole: bool = True  # else it was cut off: its time is extrapolated, and it says nothing else


Climb = Mapping[int, Rung]
"""Rungs of one scene by their beam."""


def predict(
    body: Body, marks: Signature, *, accuracy: str | Accuracy = "good", **options: Any
) -> Prediction:
    """How long `ifa.solve` with these arguments will take, and how good its motion will be.

    The first rungs of the search are run on this very scene for a second at most
    (CALIBRATION_S). What that leaves open is taken from recorded climbs that looked the same so far
    (`ifa.accuracy.recorded`): of their outcomes, the figure that most of them are within a factor
    of two of. Where the scene is easy the calibration ends early, and has seen the outcome itself.
    The solve does not depend on it. Give the result to `ifa.solve(..., prediction=)` and the
    solution carries both.

    Args:
        body: What moves.
        marks: When its contacts happen.
        accuracy: "draft", "good" or "best", or an `ifa.Accuracy` of one's own.
        **options: Those of `ifa.solve` that bear on it: `events`, `seed`, `time_budget_s`,
            `threads`, `material`, `energy_gain_j`, `constraints`, `effects`, `lead_in_s` and
            `progress`.

    Raises IfaValueError naming the argument, Cancelled.
    """
    (prediction,) = predict_all(body, marks, accuracies=(accuracy,), **options).values()
    return prediction


def predict_all(
    body: Body,
    marks: Signature,
    *,
    accuracies: Sequence[str | Accuracy] = tuple(ACCURACIES),
    clock: _Clock = time.perf_counter,
    **options: Any,
) -> dict[str, Prediction]:
    """Predictions by the name of the accuracy, from one calibration; otherwise as `predict`.

    clock: seconds, of which differences are taken; predicted seconds are its seconds.
    """
    presets = [accuracy.named(name) for name in accuracies]
    arguments.only_known(options, _OPTIONS)
    arguments.check_progress(options.get("progress"))
    budget_s = options.pop("time_budget_s", None)
    if budget_s is not None:
        budget_s = arguments.positive(budget_s, "time_budget_s")
        presets = [replace(preset, time_budget_s=budget_s) for preset in presets]
    began_s = clock()
    calibration = _Calibration(body, marks, options, clock, began_s + CALIBRATION_S - _ENDING_S)
    seen = calibration.climb(presets)
    calibration_s = clock() - began_s
    out = {}
    for preset in presets:
        time_s, error = expected(preset, seen, len(marks), recorded_climbs())
        reached = _end(preset, seen) is not None
        out[preset.name] = Prediction(preset.name, time_s, error, reached, calibration_s)
    return out


class _Calibration:
    """Runs rungs on a scene until its time is over."""

    def __init__(
        self,
        body: Body,
        marks: Signature,
        options: Mapping[str, Any],
        clock: _Clock,
        until_s: float,
    ) -> None:
        self._body, self._marks, self._options = body, marks, dict(options)
        self._asked: _core.Progress | None = self._options.pop("progress", None)
        self._clock, self._until_s = clock, until_s

    def climb(self, presets: Sequence[Accuracy]) -> dict[int, Rung]:
        """Rungs of the presets, from the smallest, as far as the time goes and as one is needed."""
        seen: dict[int, Rung] = {}
        for beam in sorted({beam for preset in presets for beam in preset.ladder}):
            if seen and (beam > _LARGEST_BEAM or not self._has_time(beam, seen)):
                break
            if any(beam in preset.ladder and _end(preset, seen) is None for preset in presets):
                rung = self._run(beam)
                if rung.whole or not seen:
                    seen[beam] = rung
                if not rung.whole:
                    break
        return seen

    def _has_time(self, beam: int, seen: Climb) -> bool:
        last = seen[max(seen)]
        return self._clock() + _HOPE * last.time_s * beam / last.beam <= self._until_s

    def _run(self, beam: int) -> Rung:
        """One rung; where it does not end in time its time is extrapolated."""
        progress = _core.Progress()
        done = threading.Event()

        def watch() -> None:
            while not done.wait(_POLL_S):
                if self._clock() >= self._until_s or (self._asked and self._asked.cancelled):
                    progress.cancel()

        watcher = threading.Thread(target=watch, daemon=True)
        watcher.start()
        began_s = self._clock()
        succeeded, plausible, error, share = False, False, 1.0, 1.0
        try:
            found = solving.solve(
                self._body,
                self._marks,
                accuracy=replace(_PROBE, ladder=(beam,)),
                progress=progress,
                **self._options,
            )
            met = found.constraints_met  # or the climb goes on
            succeeded, plausible = found.succeeded and met, found.plausible and met
            error = found.error
        except _core.NoMotionError:
            pass
        except _core.Cancelled:
            if self._asked is not None and self._asked.cancelled:
                raise
            share = max(progress.fraction, 0.5 / (len(self._marks) + 1))
        finally:
            done.set()
            watcher.join()
        time_s = (self._clock() - began_s) / share
        return Rung(beam, time_s, succeeded, plausible, error, share == 1.0)


def expected(
    preset: Accuracy, seen: Climb, marks: int, climbs: Sequence[tuple[int, Climb]]
) -> tuple[float, float]:
    """Seconds and error of a climb of which some rungs have been seen.

    marks: of the scene. climbs: recorded ones, each with its number of marks.
    """
    end = _end(preset, seen)
    known = [seen[beam] for beam in preset.ladder[:end] if beam in seen and seen[beam].whole]
    if end is not None:
        return sum(rung.time_s for rung in known), _best(known).error
    alike = [(n, climb) for n, climb in climbs if _same_so_far(preset, known, climb)]
    times_s, errors, weights = [], [], []
    for n, climb in alike or climbs:
        time_s, error = _continued(preset, seen, known, climb)
        times_s.append(time_s)
        errors.append(error)
        distance = np.log(n / marks) / _MARKS_SCALE
        weights.append(max(np.exp(-0.5 * distance**2), _LEAST_WEIGHT))
    return most_probable(times_s, weights), most_probable(errors, weights)


def _continued(
    preset: Accuracy, seen: Climb, known: Sequence[Rung], climb: Climb
) -> tuple[float, float]:
    """Seconds and error if the climb goes on as a recorded one did."""
    last = seen[max(seen)]
    scale = last.time_s / _recorded(climb, last.beam).time_s
    gone_s = sum(rung.time_s for rung in known)
    found = list(known)
    before_s = known[-1].time_s if known else 0.0
    for k in range(len(known), len(preset.ladder)):
        beam = preset.ladder[k]
        expected_s = before_s * beam / preset.ladder[k - 1] if k > 0 else 0.0
        if found and gone_s + expected_s > preset.time_budget_s:
            break
        rung = _recorded(climb, beam)
        before_s = scale * rung.time_s
        found.append(rung)
        gone_s += before_s
        if k >= preset.least_rung and _reached(preset, found):
            break
    if not _reached(preset, known):
        return gone_s, _best(found).error
    # What is there can only become better, and does so as it did then.
    then = [_recorded(climb, rung.beam) for rung in known]
    better = _best(then + found[len(known) :]).error / max(_best(then).error, _LEAST_ERROR)
    return gone_s, _best(known).error * min(1.0, better)


def _recorded(climb: Climb, beam: int) -> Rung:
    """A rung of a recorded climb; where it lacks that beam, the nearest one, as much dearer."""
    nearest = climb[min(climb, key=lambda b: abs(np.log(b / beam)))]
    return replace(nearest, beam=beam, time_s=nearest.time_s * beam / nearest.beam)


def most_probable(values: Sequence[float], weights: Sequence[float]) -> float:
    """The value that most of the weight is within FACTOR of; in the middle where several are.

    Values below _LEAST_ERROR count as that.
    """
    order = np.argsort(values)
    logs = np.log(np.maximum(np.asarray(values, float)[order], _LEAST_ERROR))
    total = np.concatenate([[0.0], np.cumsum(np.asarray(weights, float)[order])])
    ends = np.searchsorted(logs, logs + 2.0 * np.log(FACTOR), side="right")
    masses = total[ends] - total[:-1]
    first = int(np.argmax(masses))
    return float(np.exp(0.5 * (logs[first] + logs[ends[first] - 1])))


def _end(preset: Accuracy, seen: Climb) -> int | None:
    """How many rungs the preset climbs, if those that were seen say so."""
    known: list[Rung] = []
    for k, beam in enumerate(preset.ladder):
        if beam not in seen:
            return None
        if not seen[beam].whole:
            return None
        known.append(seen[beam])
        if k >= preset.least_rung and _reached(preset, known):
            break
    return len(known)


def _same_so_far(preset: Accuracy, known: Sequence[Rung], climb: Climb) -> bool:
    """Whether a recorded climb had reached as much after the same rungs."""
    if any(rung.beam not in climb for rung in known):
        return False
    return _reached(preset, known) == _reached(preset, [climb[rung.beam] for rung in known])


def _reached(preset: Accuracy, rungs: Sequence[Rung]) -> bool:
    return any(preset.reached(succeeded=r.succeeded, plausible=r.plausible) for r in rungs)


def _best(rungs: Sequence[Rung]) -> Rung:
    """The one whose motion a solve keeps."""
    return max(rungs, key=lambda r: (r.plausible, r.succeeded, -r.error))


@cache
def recorded_climbs() -> list[tuple[int, Climb]]:
    """The climbs of `ifa.accuracy.recorded`, each with its number of marks."""
    return [
        (climb["marks"], {rung[0]: Rung(*rung) for rung in climb["rungs"]})
        for climb in accuracy.recorded()["climbs"]
    ]


_OPTIONS = (
    "events",
    "seed",
    "time_budget_s",
    "threads",
    "material",
    "energy_gain_j",
    "constraints",
    "effects",
    "lead_in_s",
    "progress",
)
