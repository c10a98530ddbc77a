"""Prints what each effect costs, and writes it as CSV.

    .venv/bin/python -m benchmarks.effects [--quick] [--seed N] [--output DIR] [--record]

Each effect is timed on a scene that needs it, with and without it in turns; beside the time stands
what leaving it out changes. Then how long planning takes. With --record the ratios become what
`ifa.plan` and `ifa solve --explain` say that each effect costs.
"""

from __future__ import annotations

import argparse
import itertools
import platform
from dataclasses import asdict
from pathlib import Path

import ifa
from ifa.effect_costs import RECORDED

from benchmarks.physics.report import write_csv

from . import engine, planning, solving
from .measure import HEADER, Row
from .record import cost_table

ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    """The table, line by line as it is measured."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer throws and repeats")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "bench")
    parser.add_argument(
        "--record", action="store_true", help="keep the ratios in the package; not with --quick"
    )
    options = parser.parse_args()
    if options.record and options.quick:
        parser.error("--record: is for the full run")
    simulations, repeats = (100, 3) if options.quick else (1000, 15)
    about = (
        f"{platform.machine()}, {ifa.instruction_sets()[-1]}, one thread; CPU time, the median of "
        f"{repeats} in turns"
    )
    print(f"{about}\n{HEADER}")
    table: list[Row] = []
    both = engine.rows(simulations, repeats, options.seed), solving.rows(repeats, options.seed)
    for row in itertools.chain(*both):
        print(row.line(), flush=True)
        table.append(row)
    path = options.output / "effects.csv"
    write_csv(path, [about], [asdict(row) for row in table])
    print(f"written to {path}")
    print("\n" + planning.text(planning.measure()))
    if options.record:
        cost_table(table).write()
        print(f"recorded in {RECORDED}")


if __name__ == "__main__":
    main()
