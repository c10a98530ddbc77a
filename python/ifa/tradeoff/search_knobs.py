"""Knobs of the forward search: what its beam, its proposals and its time buy."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from ifa import _core
from ifa._core import Cancelled, IfaError
from ifa.solution import Solution
from ifa.solving import solve
from ifa.tradeoff.curve import Outcome, Scene, Setting, Study

ERROR_NAME = "1 - Score"

_SEEDS = (
    "Repeats take other seeds. The error is 1 - Score of the motions that are plausible; a failure "
    "is a seed that finds none, so the share of repeats without failure is the success rate."
)
_QUICK_RUNGS = 3
_PROPOSALS_RUNG = 1  # larger ones seldom miss, whatever is proposed
_ROOTS = (1, 2, 3, 5, 8)
_VARIANTS = (0, 2, 4, 8, 16)
_QUICK_ROOTS = (1, 3, 8)
_QUICK_VARIANTS = (0, 4, 16)
DEFAULT_ROOTS, DEFAULT_VARIANTS = 3, 4  # of ifa.solve


def beam(scene: Scene, *, quick: bool) -> Study:
    """Score and success of single rungs: how many states the beam keeps."""

    def run(rung: int) -> Callable[[int], Outcome]:
        return lambda repeat: attempt(lambda: _solve(scene, repeat, rung))

    return Study(
        "beam",
        "Beam size",
        ERROR_NAME,
        tuple(
            Setting(f"{states} states", run(rung))
            for rung, states in enumerate(_core.LADDER[: _rungs(quick)])
        ),
        f"One rung of the ladder alone, its beam so wide. {_SEEDS} A wider beam prefers motions "
        "with fewer marks retimed to those with a higher Score, which can raise the error.",
    )


def proposals(scene: Scene, *, quick: bool) -> Study:
    """Score and success against how many changes of an impact are tried for each state."""

    def run(**expert: int) -> Callable[[int], Outcome]:
        return lambda repeat: attempt(lambda: _solve(scene, repeat, _PROPOSALS_RUNG, expert))

    settings = [
        Setting(f"{roots} roots", run(roots=roots), "root searches of a state")
        for roots in (_QUICK_ROOTS if quick else _ROOTS)
    ] + [
        Setting(f"{variants} variants", run(variants=variants), "variants of a root")
        for variants in (_QUICK_VARIANTS if quick else _VARIANTS)
    ]
    return Study(
        "proposals",
        "Proposals of each state",
        ERROR_NAME,
        tuple(settings),
        f"A beam of {_core.LADDER[_PROPOSALS_RUNG]} states. In one series the root searches for a "
        "change of the impact that meets the next mark, in the other the variants of each change "
        f"found; ifa.solve has {DEFAULT_ROOTS} and {DEFAULT_VARIANTS}. {_SEEDS}",
    )


def time_budget(scene: Scene, *, quick: bool) -> Study:
    """The anytime curve: the best motion so far against the time since the solve began."""
    climbs: dict[int, list[tuple[float, Solution | IfaError]]] = {}

    def rung_of(repeat: int, rung: int) -> None:
        """Adds the next rung of a climb."""
        began_s = time.perf_counter()
        found: Solution | IfaError
        try:
            found = _solve(scene, repeat, rung)
            time_s = found.solve_s
        except Cancelled:
            raise
        except IfaError as error:
            found, time_s = error, time.perf_counter() - began_s
        climbs.setdefault(repeat, []).append((time_s, found))

    def run(rung: int) -> Callable[[int], Outcome]:
        def up_to(repeat: int) -> Outcome:
            if rung == 0:  # begins anew: the run that warms up is not to be counted
                climbs.pop(repeat, None)
            for next_rung in range(len(climbs.get(repeat, ())), rung + 1):
                rung_of(repeat, next_rung)
            climb = climbs[repeat][: rung + 1]
            time_s = sum(rung_s for rung_s, _ in climb)
            motions = [found for _, found in climb if isinstance(found, Solution)]
            if not motions:
                return Outcome(time_s, 0.0, str(climb[-1][1]))
            return judged(max(motions, key=_rank), time_s)

        return up_to

    return Study(
        "time_budget",
        "Time budget: the best so far",
        ERROR_NAME,
        tuple(Setting(f"rungs 0 to {rung}", run(rung)) for rung in range(_rungs(quick))),
        "The ladder is climbed on whether or not a motion is plausible; a point is the best motion "
        f"of all rungs so far and the time of all of them. {_SEEDS} With ifa.solve the first "
        "plausible motion ends the climb.",
    )


def attempt(solving: Callable[[], Solution], *, implausible_fails: bool = True) -> Outcome:
    """What a solve gave; where it raised an error of the library, that is the failure."""
    began_s = time.perf_counter()
    try:
        solution = solving()
    except Cancelled:
        raise
    except IfaError as error:
        return Outcome(time.perf_counter() - began_s, 0.0, str(error))
    return judged(solution, solution.solve_s, implausible_fails=implausible_fails)


def judged(solution: Solution, time_s: float, *, implausible_fails: bool = True) -> Outcome:
    """1 - Score; a motion that is not plausible has failed, or is said to have a loss."""
    error, short = 1.0 - solution.score, shortfall(solution)
    if short and solution.succeeded and not implausible_fails:
        return Outcome(time_s, error, losses=(short,))
    return Outcome(time_s, error, short)


def shortfall(solution: Solution) -> str:
    """Why a motion is not plausible, or nothing."""
    if solution.plausible:
        return ""
    if solution.succeeded:
        return "succeeded, but is not plausible"
    if solution.missed_hits:
        return "not succeeded: marks are missed"
    if solution.extra_hits:
        return "not succeeded: hits without a mark"
    return "not succeeded"


def _solve(
    scene: Scene, repeat: int, rung: int, expert: Mapping[str, int] | None = None
) -> Solution:
    return solve(
        scene.body,
        scene.marks,
        seed=(scene.seed + repeat) % 2**64,
        threads=scene.threads,
        progress=scene.progress,
        rung=rung,
        expert=expert,
    )


def _rank(solution: Solution) -> tuple[Any, ...]:
    """By which the core takes the better of two rungs' motions."""
    wrong = solution.missed_hits + solution.extra_hits
    return solution.plausible, solution.succeeded, -wrong, solution.score


def _rungs(quick: bool) -> int:
    return _QUICK_RUNGS if quick else len(_core.LADDER)
