"""What a kind of cases has to reach, and whether it did."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from .measure import Row


@dataclass(frozen=True)
class Bar:
    """Least numbers of `cases`, and largest figures.

    Retiming is the median, over the cases that succeeded, of the worst mark's; times are of all.
    """

    cases: int
    succeeded: int
    plausible: int = 0
    median_retime_percent: float = math.inf
    median_solve_s: float = math.inf
    longest_solve_s: float = math.inf


def median(values: Sequence[float]) -> float:
    """The median; NaN of nothing."""
    return statistics.median(values) if values else math.nan


def worst_retimings_percent(rows: Sequence[Row]) -> list[float]:
    """Of the worst mark of each case that succeeded."""
    return [row.retime_percent for row in rows if row.succeeded]


def judged(bar: Bar, rows: Sequence[Row]) -> tuple[bool, str]:
    """Whether everything is cleared, and a line for each thing asked that says so.

    Only what the verifier passed counts as succeeded or plausible.
    """
    good = [row for row in rows if row.verified]
    times_s = [row.solve_s for row in rows]
    counts = (
        ("succeeded and verified", bar.succeeded, sum(row.succeeded for row in good)),
        ("plausible and verified", bar.plausible, sum(row.plausible for row in good)),
    )
    retiming = median(worst_retimings_percent(good))
    largest = (
        ("median of the worst retiming", bar.median_retime_percent, retiming, "%"),
        ("median solve", bar.median_solve_s, median(times_s), "s"),
        ("longest solve", bar.longest_solve_s, max(times_s), "s"),
    )
    checks = [(len(rows) == bar.cases, f"{bar.cases} cases", str(len(rows)))]
    checks += [
        (got >= least, f"{least} of {bar.cases} {what}", str(got))
        for what, least, got in counts
        if least
    ]
    checks += [
        (got <= most, f"{what} at most {most:g} {unit}", f"{got:.2f} {unit}")  # NaN misses
        for what, most, got, unit in largest
        if most < math.inf
    ]
    lines = [
        f"    bar: {what}: {got}: {'cleared' if met else 'MISSED'}" for met, what, got in checks
    ]
    return all(met for met, _, _ in checks), "\n".join(lines)
