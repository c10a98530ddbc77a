"""Makes Tables 1 and 2 and Figure 16 of the paper again, with three searches side by side.

    .venv/bin/python -m benchmarks.paper {table1,table2,figure16} [--small | --full | --paper-size]
                                         [--rows BODY[:SURFACE] ...] [--simulations N]
                                         [--signatures N] [--method NAME ...] [--budget-per-row S]
                                         [--time-budget S] [--threads N] [--output DIR] [--keep]

A run that is stopped goes on where it was: each solve is a row of a CSV file at once, and an
unfinished database is completed. The table is also written as Markdown. Databases are deleted when
their row is done, unless --keep. The exit code is 2 where nothing could be run.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import ifa

from benchmarks.physics.report import machine

from . import figure16, table1, table2
from .attempt import METHODS
from .published import FIGURE_16, TABLE_1
from .records import Records

ROOT = Path(__file__).resolve().parents[2]
SIMULATED = (
    "The paper solved recordings. Here signatures are simulated, from other seeds than the "
    "database, with a restitution 10 % off that of the solver's body."
)
TOSSED = (
    "The paper filmed its own objects. Here positions are those of motion-captured cube tosses."
)


@dataclass(frozen=True)
class Size:
    """How large a run is. rows: bodies of Table 1 (None: all). tosses: of Table 2 (None: all)."""

    simulations: int
    signatures: int
    tosses: int | None
    growing: tuple[int, ...]
    rows: tuple[str, ...] | None = None


SIZES = {
    "small": Size(300, 2, 2, (100, 300), ("d6", "eraser")),
    "full": Size(100_000, 5, 24, (1000, 3000, 10_000, 30_000, 100_000)),
    "paper-size": Size(
        400_000, 5, None, (1000, 4000, 16_000, 64_000, 400_000), ("d6", "eraser", "card")
    ),
}


def main(arguments: Sequence[str] | None = None) -> int:
    options = _options(arguments)
    header = machine(
        [f"ifa {ifa.__version__}, {options.threads or 'all'} threads, {time.strftime('%Y-%m-%d')}"]
    )
    about = TOSSED if options.what == "table2" else SIMULATED
    print("\n".join([*header, about, options.settings, ""]))
    try:
        return {"table1": _table1, "table2": _table2, "figure16": _figure16}[options.what](
            options, [*header, about]
        )
    except ifa.IfaValueError as error:
        print(error, file=sys.stderr)
        return 2


def _table1(options: argparse.Namespace, header: list[str]) -> int:
    keys = _keys(options.rows, list(TABLE_1))
    path = options.output / "table1.csv"
    records = Records(path, table1.Row, options.settings, header)
    print(table1.HEADER)
    table1.run(keys, records, options)
    return _write(path, table1.markdown(records.rows), options.markdown)


def _table2(options: argparse.Namespace, header: list[str]) -> int:
    if not (options.shared / table2.FILE).exists():
        print(f"table2: skipped, there is no evaluation data at {options.shared / table2.FILE}")
        return 2
    path = options.output / "table2.csv"
    records = Records(path, table2.Row, options.settings, header)
    print(table2.HEADER)
    table2.run(records, options)
    return _write(path, table2.markdown(records.rows), options.markdown)


def _figure16(options: argparse.Namespace, header: list[str]) -> int:
    keys = _keys(options.rows, [(name, figure16.SURFACE) for name in FIGURE_16])
    path = options.output / "figure16.csv"
    records = Records(path, figure16.Row, options.settings, header)
    print(figure16.HEADER)
    figure16.run([name for name, _ in keys], options.growing, records, options)
    figure16.draw(records.rows, path.with_suffix(".png"))
    return _write(path, figure16.markdown(records.rows), options.markdown)


def _write(path: Path, table: str, printed: bool) -> int:
    path.with_suffix(".md").write_text(table, encoding="utf-8")
    print(f"\n{table}" if printed else "", path, sep="\n")
    return 0


def _keys(wanted: Sequence[str] | None, known: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Bodies and surfaces, in the order of the paper; a body alone is all of its surfaces."""
    if wanted is None:
        return known
    for name in wanted:
        if not any(name in (body, f"{body}:{surface}") for body, surface in known):
            raise ifa.IfaValueError(f"rows: no {name!r} here")
    return [key for key in known if key[0] in wanted or ":".join(key) in wanted]


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.paper", description="Make the paper's tables again."
    )
    parser.add_argument("what", choices=("table1", "table2", "figure16"))
    sizes = parser.add_mutually_exclusive_group()
    for name in SIZES:
        sizes.add_argument(f"--{name}", dest="size", action="store_const", const=name)
    parser.set_defaults(size="small")
    parser.add_argument("--rows", nargs="+", metavar="BODY[:SURFACE]", help="these alone")
    parser.add_argument("--simulations", type=int, help="of a database (figure16: the largest)")
    parser.add_argument("--signatures", type=int, help="of a row (table2: tosses)")
    parser.add_argument("--method", action="append", choices=METHODS, help="may be given again")
    parser.add_argument(
        "--budget-per-row", type=float, metavar="S", help="a smaller database where it takes longer"
    )
    parser.add_argument("--time-budget", type=float, default=10.0, help="s for each solve")
    parser.add_argument("--threads", type=int)
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--output", type=Path, help="build/benchmarks/paper/SIZE")
    parser.add_argument("--keep", action="store_true", help="the databases")
    parser.add_argument("--markdown", action="store_true", help="print that table, too")
    options = parser.parse_args(arguments)
    for name in ("simulations", "signatures"):
        if (value := getattr(options, name)) is not None and value < 1:
            parser.error(f"--{name}: must be 1 or more")
    size = SIZES[options.size]
    options.growing = size.growing
    if options.simulations:
        smaller = [n for n in size.growing if n < options.simulations]
        options.growing = (*smaller, options.simulations)
    if options.rows is None and options.what == "table1" and size.rows:
        options.rows = size.rows
    options.simulations = options.simulations or size.simulations
    if options.signatures is None:
        options.signatures = size.tosses if options.what == "table2" else size.signatures
    if options.method is None:
        # branch and bound knows no constraints: there is one path, and nothing to choose from
        options.method = [m for m in METHODS if options.what != "table2" or m != "branch_and_bound"]
    options.output = options.output or ROOT / "build" / "benchmarks" / "paper" / options.size
    options.settings = (
        f"{options.simulations} simulations, {options.budget_per_row or 'no'} s for them, "
        f"{options.time_budget:g} s a solve"
    )
    return options


if __name__ == "__main__":
    sys.exit(main())
