"""Table 1: each body and surface of the paper, a database, and signatures held out of it."""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, median

import ifa

from .attempt import METHODS, attempt, warm
from .databases import build, hearing
from .heldout import heldout
from .published import TABLE_1
from .records import Records

Key = tuple[str, str]


@dataclass(frozen=True)
class Row:
    """One signature solved by one method. `restitution` is that of the body that was heard."""

    body: str
    surface: str
    simulations: int
    nodes: int
    build_s: float
    prepare_s: float
    signature: int
    restitution: float
    marks: int
    method: str
    succeeded: bool
    plausible: bool
    verified: bool
    score: float
    bound: float
    search_s: float
    note: str


def run(keys: Sequence[Key], records: Records[Row], options: argparse.Namespace) -> None:
    """Solve what `records` does not have yet of these rows, and print each row when it is done."""
    for name, surface in keys:
        began_s = time.perf_counter()
        folder = options.output / "databases" / f"{name}_{surface}"
        _run_row((name, surface), folder, records, options)
        if not options.keep:
            shutil.rmtree(folder, ignore_errors=True)
        own = [row for row in records.rows if (row.body, row.surface) == (name, surface)]
        print(text(own), f"    {time.perf_counter() - began_s:.1f} s in all", sep="\n", flush=True)


def _run_row(key: Key, folder: Path, records: Records[Row], options: argparse.Namespace) -> None:
    done = [row for row in records.rows if (row.body, row.surface) == key]
    cases = [(k, m) for k in range(options.signatures) for m in options.method]
    left = [case for case in cases if case not in {(row.signature, row.method) for row in done}]
    if not left:
        return
    body = ifa.bodies.get(*key)
    simulations, budget_s = options.simulations, options.budget_per_row
    if done:  # as many again, whatever the clock says now
        simulations, budget_s = done[0].simulations, None
    built = build(body, folder, simulations, budget_s, options.threads, **hearing(key[0]))
    database = built.database
    warm(database)
    signatures = heldout(*key, TABLE_1[key].marks, options.signatures)
    for k, method in left:
        if k >= len(signatures):
            continue  # so few throws come to rest with a sound
        marks = signatures[k].marks
        began_s = time.perf_counter()
        found = attempt(
            body, marks, method, database, time_budget_s=options.time_budget,
            threads=options.threads,
        )  # fmt: skip
        gone_s = time.perf_counter() - began_s
        s = found.solution
        records.add(
            Row(
                body=key[0],
                surface=key[1],
                simulations=database.simulations,
                nodes=database.nodes,
                build_s=built.build_s,
                prepare_s=built.prepare_s,
                signature=k,
                restitution=signatures[k].restitution,
                marks=len(marks),
                method=method,
                succeeded=s is not None and s.succeeded,
                plausible=s is not None and s.plausible,
                verified=found.verified,
                score=s.score if s else 0.0,
                bound=found.bound,
                search_s=s.solve_s if s else gone_s,
                note=found.note,
            )
        )


HEADER = (
    f"{'body':18} {'surface':7} {'method':16} {'nodes':>9} {'n':>5} {'success':>8} "
    f"{'plausible':>9} {'verified':>8} {'search':>9} {'Score':>5}"
)


def text(rows: Sequence[Row]) -> str:
    """Lines below HEADER for one body and surface: each method's, and the paper's."""
    first = rows[0]
    lead = f"{first.body:18} {first.surface:7}"
    lines = []
    for method in METHODS:
        own = [row for row in rows if row.method == method]
        if own:
            lines.append(
                f"{lead} {method:16} {first.nodes:9,} {fmean(r.marks for r in own):5.1f} "
                f"{_of([r.succeeded for r in own]):>8} {_of([r.plausible for r in own]):>9} "
                f"{_of([r.verified for r in own]):>8} {_time(own):>9} {_score(own):>5}"
            )
    paper = TABLE_1[first.body, first.surface]
    lines.append(
        f"{lead} {'the paper':16} {paper.nodes:9,} {paper.marks:5.1f} "
        f"{f'{paper.solved}/{paper.sounds}':>8} {'':>9} {'':>8} "
        f"{f'{paper.minutes:.1f} min':>9} {paper.score:5.2f}"
    )
    return "\n".join(lines)


def markdown(rows: Sequence[Row]) -> str:
    """All rows as a table in Markdown, beside the paper's."""
    lines = [
        "| body, surface | simulations, nodes | n | " + " | ".join(METHODS.values())
        + " | the paper: nodes, n, success, search, Score |",
        "|---|---|---|" + "---|" * len(METHODS) + "---|",
    ]  # fmt: skip
    for key in dict.fromkeys((row.body, row.surface) for row in rows):
        of_key = [row for row in rows if (row.body, row.surface) == key]
        cells = [
            f"{key[0]}, {key[1]}",
            f"{of_key[0].simulations:,}, {of_key[0].nodes:,}",
            f"{fmean(row.marks for row in of_key):.1f}",
        ]
        for method in METHODS:
            own = [row for row in of_key if row.method == method]
            cells.append(_cell(own) if own else "")
        paper = TABLE_1[key]
        cells.append(
            f"{paper.nodes:,}, {paper.marks}, {paper.solved}/{paper.sounds}, "
            f"{paper.minutes} min, {paper.score:.2f}"
        )
        lines.append("| " + " | ".join(cells) + " |")
    lines.append("| " + " | ".join(_total(rows)) + " |")
    return "\n".join(lines) + "\n"


def _total(rows: Sequence[Row]) -> list[str]:
    keys = {(row.body, row.surface) for row in rows}
    paper = [TABLE_1[key] for key in keys]
    cells = ["all", "", f"{fmean(row.marks for row in rows):.1f}"]
    for method in METHODS:
        own = [row for row in rows if row.method == method]
        cells.append(_cell(own) if own else "")
    solved, sounds = sum(row.solved for row in paper), sum(row.sounds for row in paper)
    return [*cells, f"{solved}/{sounds}"]


def _cell(rows: Sequence[Row]) -> str:
    return (
        f"{_of([r.succeeded for r in rows])}, {_of([r.plausible for r in rows])}, "
        f"{_of([r.verified for r in rows])}, {_time(rows)}, {_score(rows)}"
    )


def _of(values: Sequence[bool]) -> str:
    return f"{sum(values)}/{len(values)}"


def _time(rows: Sequence[Row]) -> str:
    """The median over all, also those without success."""
    time_s = median(row.search_s for row in rows)
    return f"{1e3 * time_s:.0f} ms" if time_s < 1.0 else f"{time_s:.1f} s"


def _score(rows: Sequence[Row]) -> str:
    """The mean over those that have succeeded, as in the paper."""
    scores = [row.score for row in rows if row.succeeded]
    return f"{fmean(scores):.2f}" if scores else "-"
