"""Solves signatures of nine kinds, verifies every motion, and judges each kind against its bar.

    .venv/bin/python -m benchmarks.solve [--only KIND ...] [--quick] [--limit N] [--seed N]
                                         [--time-budget S] [--threads N] [--method NAME ...]
                                         [--shared DIR] [--output DIR]

One case after the other; each solve uses all threads. The kinds that need the evaluation data
beside the project are left out where it is absent. The tables are also written as CSV. The exit
code is 1 where a bar is missed, 2 where nothing could be run; with --limit or --quick, which take
a part of the cases, no bar is judged.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import ifa

from benchmarks.physics.report import machine

from . import report
from .bars import judged
from .kinds import KINDS, Kind
from .measure import METHODS, Row, solve

ROOT = Path(__file__).resolve().parents[2]
QUICK_CASES = 2


def run(kind: Kind, options: argparse.Namespace, header: list[str]) -> tuple[bool, str]:
    """Solve the cases of a kind by each method; whether its bar is cleared, and the summary."""
    print(f"\n{kind.name}: {kind.what}\n{report.HEADER}")
    rows: list[Row] = []
    for case in kind.make(options.shared, options.limit):
        for method in options.method:
            rows.append(solve(case, method, options))
            print(report.line(rows[-1]), flush=True)
    path = options.output / f"{kind.name}.csv"
    report.write(path, header, rows)
    cleared = True
    lines = []
    for method in options.method:
        own = [row for row in rows if row.method == method]
        lines.append(report.summary(f"{kind.name}, {method}", own))
        if options.limit is None:
            met, text = judged(kind.bar, own)
            cleared = cleared and met
            lines.append(text)
    return cleared, "\n".join([*lines, f"    {path}"])


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.solve", description="Solve signatures and print tables."
    )
    parser.add_argument("--only", action="append", choices=KINDS, help="may be given again")
    parser.add_argument("--limit", type=int, help="cases of each kind, evenly spread")
    parser.add_argument("--quick", action="store_true", help=f"--limit {QUICK_CASES}")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--time-budget", type=float, default=10.0, help="s for each solve")
    parser.add_argument("--threads", type=int)
    parser.add_argument("--method", action="append", choices=METHODS, help="may be given again")
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "benchmarks" / "solve")
    options = parser.parse_args(arguments)
    if options.limit is None and options.quick:
        options.limit = QUICK_CASES
    if options.limit is not None and options.limit < 1:
        parser.error("--limit: must be 1 or more")
    options.method = options.method or list(METHODS)

    header = machine(
        [
            f"ifa {ifa.__version__}, seed {options.seed}, budget {options.time_budget:g} s, "
            f"{options.threads or 'all'} threads, {time.strftime('%Y-%m-%d')}",
        ]
    )
    print("\n".join(header))
    outcomes = []
    for name in options.only or KINDS:
        if missing := KINDS[name].missing(options.shared):
            print(f"\n{missing}")
        else:
            outcomes.append(run(KINDS[name], options, header))
    if not outcomes:
        return 2
    print("\n" + "\n".join(text for _, text in outcomes))
    return 0 if all(cleared for cleared, _ in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
