"""One solve, checked by `ifa.verify`, as a row of figures."""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace
from typing import Any

import ifa

from .cases import Case

METHODS = ("forward",)  # each solves the same marks in the same run


@dataclass(frozen=True)
class Row:
    """What became of a case. Errors, retiming and excess are those of the worst mark.

    retimings_percent: of each mark but the first, to which nothing leads.
    """

    case: str
    method: str
    body: str
    marks: int
    succeeded: bool = False
    plausible: bool = False
    score: float = 0.0
    error_ms: float = float("nan")
    retime_percent: float = float("nan")
    excess: float = float("nan")
    restitution: float = float("nan")
    friction: float = float("nan")
    verified: bool = False
    rung: int = -1
    solve_s: float = float("nan")
    retimings_percent: tuple[float, ...] = ()
    note: str = ""


def solve(case: Case, method: str, options: argparse.Namespace) -> Row:
    """Solve and verify a case; what the solver refuses, or finds no motion for, is the row's note.

    options: `seed`, `time_budget` (s) and `threads`, as `ifa.solve` takes them.
    """
    row = Row(case.name, method, case.body.name, len(case.marks))
    common: dict[str, Any] = {
        "method": method,
        "events": case.events,
        "seed": options.seed,
        "time_budget_s": options.time_budget,
        "threads": options.threads,
        "material": case.material,
        "energy_gain_j": case.energy_gain_j,
    }
    begin_s = time.perf_counter()
    try:
        if case.before is not None:
            common["reuse"] = ifa.solve(case.body, case.before, **common)
            begin_s = time.perf_counter()
        solution = ifa.solve(case.body, case.marks, **common)
    except (ifa.NoMotionError, ifa.IfaValueError) as error:
        return replace(row, solve_s=time.perf_counter() - begin_s, note=str(error))
    events = solution.events
    certificate = ifa.verify(
        solution.motion,
        solution.body,
        case.marks,
        retime=[event.retime for event in events],
        energy_gain_j=case.energy_gain_j,
    )
    return replace(
        row,
        succeeded=solution.succeeded,
        plausible=solution.plausible,
        score=solution.score,
        error_ms=1e3 * solution.max_abs_error_s,
        retime_percent=100.0 * max(event.retiming for event in events),
        excess=max(event.excess for event in events),
        restitution=solution.restitution,
        friction=solution.friction,
        verified=certificate.passed,
        rung=solution.rung,
        solve_s=solution.solve_s,
        retimings_percent=tuple(100.0 * event.retiming for event in events[1:]),
        note="; ".join(certificate.failures),
    )
