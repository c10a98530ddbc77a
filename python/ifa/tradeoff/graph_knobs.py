"""Knobs of method="graph": its database, how much of the graph is searched, its connections."""

from __future__ import annotations

import shutil
import tempfile
import time
import weakref
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ifa import _core
from ifa._core import Cancelled, IfaError
from ifa.database import Database
from ifa.solution import Solution
from ifa.solving import solve
from ifa.tradeoff.curve import Outcome, Scene, Setting, Study
from ifa.tradeoff.search_knobs import ERROR_NAME, attempt

_SIZES = (300, 1000, 3000, 10_000)
_QUICK_SIZES = (200, 700, 2000)
_FIXED_SIZE, _QUICK_FIXED_SIZE = 3000, 1000  # of the database that the other knobs search

_NEIGHBOURS = (1, 2, 4, 8, 16, 32)
_QUICK_NEIGHBOURS = (1, 4, 32)
_CHILDREN = (1, 2, 5, 10, 20)
_QUICK_CHILDREN = (1, 5)
_STATES = (100, 300, 1000, 3000, 20_000, 100_000)
_QUICK_STATES = (100, 1000, 20_000)
_WIDEST_STATES = 1_000_000
_ANY_PATH_RUNG = 3  # of the graph's ladder: any path that may succeed, in the widest layers
_ROUNDING = 1e-4  # of a path's weight: transitions keep theirs in steps of 3e-4
_PAPER_TIME_S, _QUICK_PAPER_TIME_S = 5.0, 1.0  # for branch and bound, which needs not end before

_TOLERANCES_RAD = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, _core.SHOOTING_TOLERANCE_RAD)
_QUICK_TOLERANCES_RAD = (1e-1, 1e-3, 1e-6, _core.SHOOTING_TOLERANCE_RAD)
_PAPER_TOLERANCES_RAD = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
_QUICK_PAPER_TOLERANCES_RAD = (1e-1, 1e-3)
_PAPER_ITERATIONS = 200
_CONNECTIONS, _QUICK_CONNECTIONS = 500, 100
_DRAWN_FROM = 200  # simulations

_REPEATS = (
    "Repeats take databases of other seeds, built before and not timed. A failure is a database "
    "whose best motion has not succeeded by the paper's standard; one that is not plausible, as "
    "many that the graph splices are, has its Score, and that it is not is named."
)


class _Databases:
    """Databases of a scene's body, each built when it is first asked for, until this is dropped."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._folder = Path(tempfile.mkdtemp(prefix="ifa-tradeoff-"))
        self._made: dict[tuple[int, int], tuple[Database, float]] = {}
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)

    def get(self, simulations: int, repeat: int) -> Database:
        """One with its transitions."""
        key = simulations, repeat
        if key not in self._made:
            began_s = time.perf_counter()
            database = Database.build(
                self._scene.body,
                self._folder / f"{simulations}-{repeat}",
                simulations,
                (self._scene.seed + repeat) % 2**64,
                threads=self._scene.threads,
                progress=self._scene.progress,
            ).prepare(self._scene.threads, self._scene.progress)
            self._made[key] = database, time.perf_counter() - began_s
        return self._made[key][0]

    def build_s(self, simulations: int, repeat: int) -> float:
        """How long it took to make, s; 0 where it could not be."""
        made = self._made.get((simulations, repeat))
        return made[1] if made else 0.0

    def solve(self, simulations: int, repeat: int, **options: Any) -> Solution:
        """The scene by such a database."""
        return solve(
            self._scene.body,
            self._scene.marks,
            method="graph",
            database=self.get(simulations, repeat),
            threads=self._scene.threads,
            progress=self._scene.progress,
            **options,
        )

    def attempt(
        self, simulations: int, repeat: int, found: list[Solution] | None = None, **options: Any
    ) -> Outcome:
        """What that gave, by the paper's standard; the solution is added to `found`."""

        def solving() -> Solution:
            solution = self.solve(simulations, repeat, **options)
            if found is not None:
                found.append(solution)
            return solution

        try:
            self.get(simulations, repeat)  # not timed
        except Cancelled:
            raise
        except IfaError as error:
            return Outcome(0.0, 0.0, str(error))
        return attempt(solving, implausible_fails=False)


def database_size(scene: Scene, *, quick: bool) -> Study:
    """Score and success of method="graph" against the number of simulations in its database."""
    databases = _Databases(scene)

    def run(simulations: int, building: bool) -> Callable[[int], Outcome]:
        def once(repeat: int) -> Outcome:
            outcome = databases.attempt(simulations, repeat)
            build_s = databases.build_s(simulations, repeat) if building else 0.0
            return replace(outcome, time_s=outcome.time_s + build_s)

        return once

    return Study(
        "database_size",
        "Database size",
        ERROR_NAME,
        tuple(
            Setting(f"{simulations} simulations", run(simulations, building), series)
            for simulations in (_QUICK_SIZES if quick else _SIZES)
            for building, series in ((False, "solve alone"), (True, "build and solve"))
        ),
        f"The error is 1 - Score of the motion, as it was made. {_REPEATS}",
        slow=True,
    )


def neighbours(scene: Scene, *, quick: bool) -> Study:
    """Score and success against how many ways on from a node the searches look at."""
    databases = _Databases(scene)
    simulations = _QUICK_FIXED_SIZE if quick else _FIXED_SIZE
    paper_s = _QUICK_PAPER_TIME_S if quick else _PAPER_TIME_S

    def exact(most: int) -> Callable[[int], Outcome]:
        return lambda repeat: databases.attempt(simulations, repeat, expert={"neighbours": most})

    def paper(most: int) -> Callable[[int], Outcome]:
        return lambda repeat: databases.attempt(
            simulations,
            repeat,
            search="branch_and_bound",
            time_budget_s=paper_s,
            expert={"children": most},
        )

    return Study(
        "neighbours",
        "Neighbours of a node",
        ERROR_NAME,
        (
            *(
                Setting(f"{most} transitions", exact(most), "exact search")
                for most in (_QUICK_NEIGHBOURS if quick else _NEIGHBOURS)
            ),
            *(
                Setting(f"{most} children", paper(most), "branch and bound")
                for most in (_QUICK_CHILDREN if quick else _CHILDREN)
            ),
        ),
        f"In a database of {simulations} simulations: the best transitions of a node, which has 32 "
        "at most, in the exact search, and the children of a node in the paper's branch and "
        f"bound, which ends at a Score of 0.3 or after {paper_s:g} s. {_REPEATS}",
        slow=True,
    )


def search_exactness(scene: Scene, *, quick: bool) -> Study:
    """The optimality gap: how far the path that is found is below what no path exceeds."""
    databases = _Databases(scene)
    simulations = _QUICK_FIXED_SIZE if quick else _FIXED_SIZE
    paper_s = _QUICK_PAPER_TIME_S if quick else _PAPER_TIME_S
    bounds: dict[int, float] = {}

    def bound(repeat: int) -> float:
        """Of the Score of all paths that may succeed."""
        if repeat not in bounds:
            bounds[repeat] = databases.solve(
                simulations, repeat, rung=_ANY_PATH_RUNG, expert={"states": _WIDEST_STATES}
            ).search["bound"]
        return bounds[repeat]

    def gap(repeat: int, **options: Any) -> Outcome:
        found: list[Solution] = []
        outcome = databases.attempt(simulations, repeat, found, **options)
        if not found:
            return outcome
        if found[0].missed_hits:  # a path that does not go all the way has no weight
            return Outcome(outcome.time_s, 0.0, outcome.failure)
        left = bound(repeat) - found[0].search["score"]
        if left < -_ROUNDING:
            return Outcome(outcome.time_s, 0.0, "a path that the bound does not cover")
        return Outcome(outcome.time_s, max(0.0, left))

    def exact(states: int) -> Callable[[int], Outcome]:
        return lambda repeat: gap(repeat, rung=_ANY_PATH_RUNG, expert={"states": states})

    def paper(repeat: int) -> Outcome:
        return gap(repeat, search="branch_and_bound", time_budget_s=paper_s)

    return Study(
        "search_exactness",
        "Exactness of the graph's search",
        "optimality gap, Score",
        (
            *(
                Setting(f"{states} states", exact(states), "exact search")
                for states in (_QUICK_STATES if quick else _STATES)
            ),
            Setting("branch and bound", paper, "branch and bound"),
        ),
        f"In a database of {simulations} simulations, of the search's own weight of a path (not "
        "that of the motion made of it): what no path exceeds that is retimed by at most 30 %, "
        f"less what the motion's own has. The bound is that of layers of {_WIDEST_STATES} states. "
        "What is left with these is that better paths could not be flown, or made a motion less "
        "good: of those tried the best motion is taken, so a wider search can end with a larger "
        "gap. Repeats take databases of other seeds; a failure is a search that finds no path to "
        "the last mark.",
        slow=True,
    )


def connection_tolerance(scene: Scene, *, quick: bool) -> Study:
    """The angle that connections miss their target by, against how near they were asked to come."""
    problems: dict[int, _core.Connections] = {}
    count = _QUICK_CONNECTIONS if quick else _CONNECTIONS

    def run(tolerance_rad: float, paper: bool) -> Callable[[int], Outcome]:
        def once(repeat: int) -> Outcome:
            if repeat not in problems:
                try:
                    problems[repeat] = _core.Connections(
                        scene.body._core,
                        seed=(scene.seed + repeat) % 2**64,
                        simulations=_DRAWN_FROM,
                        count=count,
                    )
                except IfaError as error:
                    return Outcome(0.0, 0.0, str(error))
            return connect(problems[repeat], tolerance_rad, paper)

        return once

    ours = _QUICK_TOLERANCES_RAD if quick else _TOLERANCES_RAD
    papers = _QUICK_PAPER_TOLERANCES_RAD if quick else _PAPER_TOLERANCES_RAD
    return Study(
        "connection_tolerance",
        "Tolerance of connections",
        "angle missed at the splice, degrees",
        (
            *(Setting(f"{tol:g} rad", run(tol, False), "Newton, continuation") for tol in ours),
            *(Setting(f"{tol:g} rad", run(tol, True), "the paper's scheme") for tol in papers),
        ),
        f"Of {count} flights from one random take-off to where another one's flight ends, within "
        "the paper's cut-off: the largest angle by which those that converged miss their target, "
        "measured by flying them, and the mean time of one. Losses are those that did not converge"
        f" (the paper's scheme: within {_PAPER_ITERATIONS} iterations). A body of three equal "
        "moments is connected in closed form, at any tolerance. Repeats take other flights.",
    )


def connect(connections: _core.Connections, tolerance_rad: float, paper: bool) -> Outcome:
    """Connections made to a tolerance, by ours or the paper's scheme."""
    began_s = time.perf_counter()
    if paper:
        spins, converged, _ = connections.connect_as_paper(tolerance_rad, _PAPER_ITERATIONS)
    else:
        spins, converged, _ = connections.connect(tolerance_rad)
    time_s = (time.perf_counter() - began_s) / len(converged)
    missed_deg = np.degrees(connections.missed_rad(spins))[np.asarray(converged)]
    lost = len(converged) - len(missed_deg)
    loss = f"{lost} of {len(converged)} connections did not converge"
    if lost == len(converged):
        return Outcome(time_s, 0.0, loss)
    return Outcome(time_s, float(missed_deg.max()), losses=(loss,) if lost else ())
