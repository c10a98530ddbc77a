"""The tables, and the CSV files with the same rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from textwrap import shorten

from benchmarks.physics.report import write_csv

from .bars import median, worst_retimings_percent
from .measure import Row

LONGEST_NOTE = 200
HEADER = (
    f"{'case':26} {'method':8} {'body':6} {'marks':>5} {'succeeded':>9} {'plausible':>9} "
    f"{'score':>6} {'error ms':>8} {'retime %':>8} {'excess':>7} {'e':>5} {'verify':>6} "
    f"{'rung':>4} {'s':>6}"
)


def line(row: Row) -> str:
    """The row below HEADER; its note, cut where it is long, on a line of its own."""

    def yes(value: bool) -> str:
        return "yes" if value else "NO"

    text = (
        f"{row.case:26} {row.method:8} {row.body:6} {row.marks:5} {yes(row.succeeded):>9} "
        f"{yes(row.plausible):>9} {row.score:6.3f} {row.error_ms:8.3f} {row.retime_percent:8.2f} "
        f"{row.excess:7.3f} {row.restitution:5.2f} {yes(row.verified):>6} {row.rung:4} "
        f"{row.solve_s:6.2f}"
    )
    return f"{text}\n    {shorten(row.note, LONGEST_NOTE)}" if row.note else text


def summary(name: str, rows: Sequence[Row]) -> str:
    """What became of a kind's cases by one method."""
    solved = [row for row in rows if row.succeeded]
    times_s = [row.solve_s for row in rows]
    text = (
        f"{name}: succeeded {len(solved)} of {len(rows)}, plausible "
        f"{sum(row.plausible for row in rows)} of {len(rows)}, verified "
        f"{sum(row.verified for row in rows)}; solve {median(times_s):.2f} s median, "
        f"{max(times_s):.2f} s longest, {sum(times_s):.1f} s in all"
    )
    if solved:
        scores = [row.score for row in solved]
        marks = [percent for row in solved for percent in row.retimings_percent]
        text += (
            f"\n    of those that succeeded: score {median(scores):.3f} median, {min(scores):.3f} "
            f"lowest; retiming {median(worst_retimings_percent(rows)):.2f} % median of the worst "
            f"mark, {median(marks):.2f} % median of all marks; excess "
            f"{median([row.excess for row in solved]):.3f} median of the worst mark"
        )
    return text


def write(path: Path, header: Sequence[str], rows: Sequence[Row]) -> None:
    """The rows as CSV; retimings of the marks between spaces."""
    write_csv(
        path,
        header,
        [
            asdict(row)
            | {"retimings_percent": " ".join(f"{percent:.6g}" for percent in row.retimings_percent)}
            for row in rows
        ],
    )
