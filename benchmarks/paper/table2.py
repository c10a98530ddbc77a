"""Table 2: measured positions as constraints. The paper's motions were its own; ours are tosses."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

import ifa
import numpy as np

from benchmarks.solve.cases import spread
from benchmarks.solve.recorded import tosses

from .attempt import METHODS, attempt, warm
from .databases import build
from .published import TABLE_2
from .records import Records

FILE = "tosses/cube_tosses.json"
SAMPLING: dict[str, Any] = {"cone_rad": float(np.radians(60.0))}  # tosses travel


@dataclass(frozen=True)
class Row:
    """One toss by one method; errors are those of its hits. `longest_m` is the paper's L."""

    toss: str
    marks: int
    method: str
    succeeded: bool
    plausible: bool
    verified: bool
    score: float
    largest_m: float
    mean_m: float
    longest_m: float
    search_s: float
    note: str


@dataclass(frozen=True)
class Toss:
    """A measured toss: where the centre of the cube was at each mark, (n, 2), m."""

    name: str
    body: ifa.Body
    marks: ifa.Signature
    positions_m: np.ndarray

    @property
    def longest_m(self) -> float:
        """The longest edge of the positions' bounding box."""
        return float(np.ptp(self.positions_m, axis=0).max())


def measured(shared: Path, limit: int | None) -> list[Toss]:
    """Tosses evenly spread over all, of which none is there twice."""
    rows = json.loads((shared / FILE).read_text(encoding="utf-8"))["tosses"]
    both = [
        Toss(case.name, case.body, case.marks, np.array([(h["x"], h["y"]) for h in row["hits"]]))
        for case, row in zip(tosses(shared), rows, strict=True)
        if row.get("duplicate_of") is None
    ]
    return spread(both, limit)


def run(records: Records[Row], options: argparse.Namespace) -> None:
    """Solve what `records` does not have yet, and print it."""
    done = {(row.toss, row.method) for row in records.rows}
    database = None
    for toss in measured(options.shared, options.signatures):
        for method in options.method:
            if (toss.name, method) in done:
                continue
            if method != "forward" and database is None:
                database = _database(toss.body, options)
            records.add(_row(toss, method, database, options))
            print(line(records.rows[-1]), flush=True)


def _database(body: ifa.Body, options: argparse.Namespace) -> ifa.Database:
    folder = options.output / "databases" / "cube"
    database = build(
        body, folder, options.simulations, options.budget_per_row, options.threads,
        sampling=SAMPLING,
    ).database  # fmt: skip
    warm(database)
    return database


def _row(
    toss: Toss, method: str, database: ifa.Database | None, options: argparse.Namespace
) -> Row:
    asked = [ifa.Position(k, tuple(at)) for k, at in enumerate(toss.positions_m.tolist())]
    found = attempt(
        toss.body, toss.marks, method, database, constraints=asked,
        time_budget_s=options.time_budget, threads=options.threads,
    )  # fmt: skip
    s = found.solution
    errors_m = [float(report.error_m or 0.0) for report in s.constraints] if s else [np.nan]
    return Row(
        toss=toss.name,
        marks=len(toss.marks),
        method=method,
        succeeded=s is not None and s.succeeded,
        plausible=s is not None and s.plausible,
        verified=found.verified,
        score=s.score if s else 0.0,
        largest_m=max(errors_m),
        mean_m=fmean(errors_m),
        longest_m=toss.longest_m,
        search_s=s.solve_s if s else np.nan,
        note=found.note,
    )


HEADER = (
    f"{'motion':16} {'n':>3} {'method':16} {'success':>7} {'plausible':>9} {'Score':>5} "
    f"{'max cm':>7} {'max/L':>6} {'mean cm':>7} {'mean/L':>6} {'L cm':>6} {'s':>6}"
)


def line(row: Row) -> str:
    return (
        f"{row.toss:16} {row.marks:3} {row.method:16} {_yes(row.succeeded):>7} "
        f"{_yes(row.plausible):>9} {row.score:5.2f} {100 * row.largest_m:7.1f} "
        f"{row.largest_m / row.longest_m:6.2f} {100 * row.mean_m:7.1f} "
        f"{row.mean_m / row.longest_m:6.2f} {100 * row.longest_m:6.1f} {row.search_s:6.1f}"
    )


def markdown(rows: Sequence[Row]) -> str:
    """Each method's means in Markdown, beside the paper's, then row by row."""
    out = [
        "| | motions | succeeded | plausible | verified | max, cm | max / L | mean, cm | mean / L "
        "| largest max / L |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for method, what in METHODS.items():
        own = [row for row in rows if row.method == method]
        there = [row for row in own if np.isfinite(row.largest_m)]
        if there:
            counts = [
                sum(getattr(r, n) for r in own) for n in ("succeeded", "plausible", "verified")
            ]
            of_longest = [row.largest_m / row.longest_m for row in there]
            out.append(
                f"| {what} | {len(own)} | {counts[0]} | {counts[1]} | {counts[2]} "
                f"| {100 * fmean(r.largest_m for r in there):.1f} | {fmean(of_longest):.2f} "
                f"| {100 * fmean(r.mean_m for r in there):.1f} "
                f"| {fmean(r.mean_m / r.longest_m for r in there):.2f} | {max(of_longest):.2f} |"
            )
    out.append(
        f"| the paper | {len(TABLE_2)} | | | | {fmean(r.largest_cm for r in TABLE_2):.1f} "
        f"| {fmean(r.largest_of_longest for r in TABLE_2):.2f} "
        f"| {fmean(r.mean_cm for r in TABLE_2):.1f} "
        f"| {fmean(r.mean_of_longest for r in TABLE_2):.2f} "
        f"| {max(r.largest_of_longest for r in TABLE_2):.2f} |"
    )
    out += [
        "",
        "| motion | n | method | succeeded | Score | max: cm, of L | mean: cm, of L | L, cm | s |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    out += [
        f"| {r.toss} | {r.marks} | {r.method} | {_yes(r.succeeded)} | {r.score:.2f} "
        f"| {100 * r.largest_m:.1f}, {r.largest_m / r.longest_m:.2f} "
        f"| {100 * r.mean_m:.1f}, {r.mean_m / r.longest_m:.2f} | {100 * r.longest_m:.1f} "
        f"| {r.search_s:.1f} |"
        for r in rows
    ]
    out += [
        f"| {r.motion} | | the paper | | | {r.largest_cm:.1f}, {r.largest_of_longest:.2f} "
        f"| {r.mean_cm:.1f}, {r.mean_of_longest:.2f} | {r.longest_cm:.1f} | |"
        for r in TABLE_2
    ]
    return "\n".join(out) + "\n"


def _yes(value: bool) -> str:
    return "yes" if value else "NO"
