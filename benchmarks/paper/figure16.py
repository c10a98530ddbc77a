"""Figure 16: the Score against the size of the database."""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import ifa

from .attempt import METHODS, attempt, warm
from .databases import build, hearing, there
from .heldout import heldout
from .published import TABLE_1
from .records import Records

SURFACE = "desk"


@dataclass(frozen=True)
class Row:
    """One signature by one method on one size; the forward search, which has none, on 0."""

    body: str
    simulations: int
    nodes: int
    signature: int
    marks: int
    method: str
    succeeded: bool
    plausible: bool
    verified: bool
    score: float
    bound: float
    search_s: float
    note: str


def run(
    bodies: Sequence[str], sizes: Sequence[int], records: Records[Row], options: argparse.Namespace
) -> None:
    """Solve what `records` does not have yet, in databases that grow, and print it."""
    done = {(row.body, row.simulations, row.signature, row.method) for row in records.rows}
    for name in bodies:
        began_s = time.perf_counter()
        key = (name, SURFACE)
        body = ifa.bodies.get(*key)
        signatures = heldout(*key, TABLE_1[key].marks, options.signatures)
        folder = options.output / "databases" / name
        for size in (0, *sizes):
            methods = [m for m in options.method if (m == "forward") == (size == 0)]
            cases = [(k, m) for k in range(len(signatures)) for m in methods]
            left = [(k, m) for k, m in cases if (name, size, k, m) not in done]
            database: ifa.Database | None = None
            if left and size:
                if there(folder) > size:  # of a run that was stopped, or of --keep
                    shutil.rmtree(folder)
                database = build(
                    body, folder, size, None, options.threads, **hearing(name)
                ).database
                warm(database)
            for k, method in left:
                found = attempt(
                    body, signatures[k].marks, method, database,
                    time_budget_s=options.time_budget, threads=options.threads,
                )  # fmt: skip
                s = found.solution
                records.add(
                    Row(
                        body=name,
                        simulations=size,
                        nodes=database.nodes if database else 0,
                        signature=k,
                        marks=len(signatures[k].marks),
                        method=method,
                        succeeded=s is not None and s.succeeded,
                        plausible=s is not None and s.plausible,
                        verified=found.verified,
                        score=s.score if s and s.succeeded else 0.0,
                        bound=found.bound,
                        search_s=s.solve_s if s else options.time_budget,
                        note=found.note,
                    )
                )
            for method in methods:
                print(line([r for r in records.rows if _of(r, name, size, method)]), flush=True)
        if not options.keep:
            shutil.rmtree(folder, ignore_errors=True)
        print(f"    {time.perf_counter() - began_s:.1f} s in all", flush=True)


HEADER = (
    f"{'body':12} {'simulations':>11} {'nodes':>9} {'method':16} {'n':>5} {'success':>7} "
    f"{'Score':>5} {'bound':>5} {'s':>6}"
)


def line(rows: Sequence[Row]) -> str:
    """The signatures of one body, size and method below HEADER: the Score is their mean."""
    first = rows[0]
    return (
        f"{first.body:12} {first.simulations:11,} {first.nodes:9,} {first.method:16} "
        f"{fmean(r.marks for r in rows):5.1f} "
        f"{f'{sum(r.succeeded for r in rows)}/{len(rows)}':>7} {_mean_score(rows):5.2f} "
        f"{fmean(r.bound for r in rows):5.2f} {fmean(r.search_s for r in rows):6.2f}"
    )


def markdown(rows: Sequence[Row]) -> str:
    """Mean Scores in Markdown: a row for each body and size."""
    out = [
        "| body | simulations | nodes | " + " | ".join(METHODS.values()) + " |",
        "|---|---|---|" + "---|" * len(METHODS),
    ]
    for name, size in dict.fromkeys((r.body, r.simulations) for r in rows if r.simulations):
        cells = []
        for method in METHODS:
            own = [r for r in rows if _of(r, name, 0 if method == "forward" else size, method)]
            solved = sum(r.succeeded for r in own)
            cells.append(f"{_mean_score(own):.2f} ({solved}/{len(own)})" if own else "")
        nodes = next(r.nodes for r in rows if (r.body, r.simulations) == (name, size))
        out.append(f"| {name} | {size:,} | {nodes:,} | " + " | ".join(cells) + " |")
    return "\n".join(out) + "\n"


def draw(rows: Sequence[Row], path: Path) -> None:
    """A panel for each body: mean Score against simulations, the forward search as a level."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    styles = {
        "branch_and_bound": ("#edae49", "s", 8, "-"),
        "exact": ("#d1495b", "o", 5, "-"),
        "forward": ("#22313f", "", 0, "--"),
    }
    names = list(dict.fromkeys(row.body for row in rows))
    figure, panels = plt.subplots(
        1, len(names), figsize=(3.1 * len(names) + 0.6, 3.3), sharey=True, squeeze=False,
        layout="constrained",
    )  # fmt: skip
    for axes, name in zip(panels[0], names, strict=True):
        for method, (colour, marker, size_pt, stroke) in styles.items():
            own = [row for row in rows if (row.body, row.method) == (name, method)]
            sizes = sorted({row.simulations for row in own})
            means = [_mean_score([r for r in own if r.simulations == size]) for size in sizes]
            if sizes == [0]:
                axes.axhline(means[0], color=colour, ls=stroke, lw=1.4, label=METHODS[method])
            elif sizes:
                axes.plot(
                    sizes, means, stroke, color=colour, marker=marker, ms=size_pt,
                    label=METHODS[method], clip_on=False, zorder=3,
                )  # fmt: skip
        mean_n = fmean(row.marks for row in rows if row.body == name)
        axes.set_title(f"{name}, n = {mean_n:.3g}", fontsize=10)
        axes.set_xscale("log")
        axes.set_ylim(0.0, 1.0)
        axes.set_xlabel("simulations in the database")
        axes.grid(alpha=0.25, lw=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0][0].set_ylabel("mean Score (without success: 0)")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False, fontsize=9)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def _of(row: Row, name: str, size: int, method: str) -> bool:
    return (row.body, row.simulations, row.method) == (name, size, method)


def _mean_score(rows: Sequence[Row]) -> float:
    return fmean(row.score for row in rows)
