"""One solve by one of the three searches, verified."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ifa

METHODS = {
    "branch_and_bound": "branch and bound (the paper's)",
    "exact": "exact search of the graph",
    "forward": "forward search, without a database",
}


@dataclass(frozen=True)
class Attempt:
    """What became of a solve. solution: None where there is no motion, and `note` says why.

    bound: what no path of the graph exceeds; 1 where that is not known.
    """

    solution: ifa.Solution | None
    verified: bool
    bound: float
    note: str


def warm(database: ifa.Database) -> None:
    """Make what searches make when they first meet a database, so that none is timed with it."""
    database.prepare()
    marks = ifa.Signature([0.0, 0.1], ending="open")
    for search in ("exact", "branch_and_bound"):
        attempt(database.body, marks, search, database, time_budget_s=0.01)


def attempt(
    body: ifa.Body,
    marks: ifa.Signature,
    method: str,
    database: ifa.Database | None,
    **options: Any,
) -> Attempt:
    """Solve and verify; method: one of METHODS; options: of `ifa.solve`."""
    if method != "forward":
        options |= {"method": "graph", "search": method, "database": database}
    try:
        solution = ifa.solve(body, marks, **options)
    except (ifa.NoMotionError, ifa.IfaValueError) as error:
        return Attempt(None, False, 1.0, str(error))
    certificate = ifa.verify(solution.motion, solution.body, solution.marks)
    note = "; ".join(certificate.failures)
    return Attempt(solution, certificate.passed, solution.search.get("bound", 1.0), note)
