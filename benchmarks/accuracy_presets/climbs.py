"""Rungs of the search, each on its own, over cases that are not those which predictions face."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import ifa
from ifa.prediction import Rung

from benchmarks.solve.cases import Case
from benchmarks.solve.kinds import KINDS

BEAMS = (10, 20, *ifa.ACCURACIES["good"].ladder[:-1])
LARGEST_FOR_ALL = 1080  # a larger beam is for those that have no plausible motion yet
MEASURED_MORE = 3  # tosses for each throw: marks of real bodies are harder, as sounds are
LONGEST_RUNG_S = 4.0  # of one core; after such a one no larger one is run

CLOCKS: dict[str, Callable[[], float]] = {"wall": time.perf_counter, "cpu": time.process_time}


@dataclass(frozen=True)
class Measured:
    """The rungs of one case, from the smallest beam."""

    case: str
    kind: str
    marks: int
    material: str
    rungs: tuple[Rung, ...]


def cases(options: argparse.Namespace) -> Iterator[tuple[str, Case]]:
    """Simulated scenes, with the material given and fitted, and tosses where they are there.

    Not the recordings: these are what predictions are judged by.
    """
    for kind, times in (("simulated", 1), ("tosses", MEASURED_MORE)):
        if KINDS[kind].missing(options.shared):
            continue
        for case in KINDS[kind].make(options.shared, times * options.limit):
            yield kind, case
            if kind == "simulated":
                yield kind, replace(case, name=f"{case.name}_fit", material="fit")


def measured(options: argparse.Namespace) -> Iterator[Measured]:
    """All cases, one after the other or side by side; in their order."""
    with ProcessPoolExecutor(options.processes) as pool:
        yield from pool.map(partial(measure, options), *zip(*cases(options), strict=True))


def solve_one(
    case: Case, accuracy: ifa.Accuracy, options: argparse.Namespace, **more: object
) -> tuple[ifa.Solution | None, float]:
    """The solution, None where there is no motion, and its seconds by the clock asked for."""
    clock = CLOCKS[options.clock]
    begin_s = clock()
    try:
        solution = ifa.solve(
            case.body,
            case.marks,
            accuracy=accuracy,
            material=case.material,
            events=case.events,
            energy_gain_j=case.energy_gain_j,
            seed=options.seed,
            threads=options.threads,
            **more,
        )
    except ifa.NoMotionError:
        solution = None
    return solution, clock() - begin_s


def measure(options: argparse.Namespace, kind: str, case: Case) -> Measured:
    """Each rung by itself: a climb is a sequence of just these."""
    rungs: list[Rung] = []
    for beam in BEAMS:
        if rungs and rungs[-1].time_s > LONGEST_RUNG_S:
            break
        if beam > LARGEST_FOR_ALL and any(rung.plausible for rung in rungs):
            break
        alone = replace(ifa.ACCURACIES["good"], ladder=(beam,))
        solution, time_s = solve_one(case, alone, options)
        rungs.append(
            Rung(beam, time_s, solution.succeeded, solution.plausible, solution.error)
            if solution
            else Rung(beam, time_s, False, False, 1.0)
        )
    return Measured(case.name, kind, len(case.marks), case.material, tuple(rungs))
