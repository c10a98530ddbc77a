"""Measures candidates for the presets of accuracy, records the choice, or judges predictions.

    .venv/bin/python -m benchmarks.accuracy_presets [--predict | --keys] [--record] [--limit N]
        [--seed N] [--clock wall|cpu] [--threads N] [--processes N] [--shared DIR] [--output DIR]

Without more, each rung is run on each case, and candidates are compared over the climbs that these
make up: a table, `presets.csv` and `climbs.csv`. With --predict, seconds and error of recordings
of the evaluation data (which the climbs have nothing of) are predicted for all three stops, then
solved: `predictions_CLOCK.csv`. --record also writes python/ifa/data/accuracy.json, on which
predictions rest; with --predict the shares of right ones in it, with --keys what the presets'
tolerances cost in keys. --clock cpu counts the seconds that one thread works: what a machine that
is busy otherwise gives again.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import ifa

from benchmarks.physics.report import machine, write_csv
from benchmarks.solve.kinds import KINDS

from . import keys, predictions
from .candidates import candidates, mark_front, point
from .climbs import CLOCKS, Measured, measured

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "python" / "ifa" / "data" / "accuracy.json"
DIGITS = 4  # of what is recorded


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.accuracy_presets",
        description="Measure presets of accuracy, or judge predictions.",
    )
    parser.add_argument("--record", action="store_true", help=f"write {DATA.name}")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--predict", action="store_true", help="judge predictions on recordings")
    what.add_argument("--keys", action="store_true", help="count keys by their tolerances")
    parser.add_argument("--limit", type=int, default=40, help="throws, solved twice (default 40)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--clock", choices=CLOCKS, default="wall")
    parser.add_argument("--threads", type=int, help="default: all; with --clock cpu 1")
    parser.add_argument(
        "--processes", type=int, default=1, help="with --clock cpu: so many cases at once"
    )
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument(
        "--output", type=Path, default=ROOT / "build" / "benchmarks" / "accuracy_presets"
    )
    options = parser.parse_args(arguments)
    if options.limit < 1:
        parser.error("--limit: must be 1 or more")
    if options.processes != 1 and (options.clock != "cpu" or options.processes < 1):
        parser.error("--processes: cases side by side need --clock cpu")
    if options.clock == "cpu" and options.threads is None:
        options.threads = 1
    header = machine(
        [
            f"ifa {ifa.__version__}, seed {options.seed}, {options.clock} seconds, "
            f"{options.threads or 'all'} threads, {time.strftime('%Y-%m-%d')}"
        ]
    )
    print("\n".join(header))
    if options.keys:
        return _keys(options, header)
    return (_predict if options.predict else _measure)(options, header)


def _machine_now(options: argparse.Namespace, header: list[str]) -> dict[str, object]:
    return {
        "machine": header,
        "date": time.strftime("%Y-%m-%d"),
        "version": ifa.__version__,
        "clock": options.clock,
        "threads": options.threads,
    }


def _measure(options: argparse.Namespace, header: list[str]) -> int:
    climbs: list[Measured] = []
    for climb in measured(options):
        climbs.append(climb)
        print(_climb_line(climb), flush=True)
    rows = [row for preset in candidates() if (row := point(preset, climbs))]
    mark_front(rows)
    print(
        f"\n{'preset':28} {'s: median':>9} {'mean':>7} {'p90':>7} {'error: median':>13} "
        f"{'mean':>6} {'p90':>6} {'succeeded':>9} {'plausible':>9}  of {len(climbs)}"
    )
    for row in rows:
        print(
            f"{row['preset']:28} {row['time_median_s']:9.3f} {row['time_mean_s']:7.3f} "
            f"{row['time_p90_s']:7.3f} {row['error_median']:13.4f} {row['error_mean']:6.3f} "
            f"{row['error_p90']:6.3f} {row['succeeded']:9} {row['plausible']:9}"
            f"{'  on the front' if row['on_front'] else ''}"
        )
    write_csv(options.output / "presets.csv", header, rows)
    write_csv(
        options.output / "climbs.csv",
        header,
        [
            {"case": climb.case, "kind": climb.kind, "marks": climb.marks, **vars(rung)}
            for climb in climbs
            for rung in climb.rungs
        ],
    )
    print(f"written to {options.output}")
    if options.record:
        _record(options, header, climbs, rows)
    return 0


def _record(
    options: argparse.Namespace,
    header: list[str],
    climbs: Sequence[Measured],
    rows: Sequence[dict[str, object]],
) -> None:
    kinds = {climb.kind for climb in climbs}
    content = {
        "measured": {
            **_machine_now(options, header),
            "cases": {kind: sum(climb.kind == kind for climb in climbs) for kind in sorted(kinds)},
        },
        "error": "1 - Score",
        "points": rows,
        "climbs": [
            {
                "marks": climb.marks,
                "rungs": [
                    [r.beam, r.time_s, r.succeeded, r.plausible, r.error] for r in climb.rungs
                ],
            }
            for climb in climbs
        ],
    }
    DATA.write_text(_json(_rounded(content)) + "\n", encoding="utf-8")
    print(f"recorded in {DATA}")


def _json(content: dict[str, object]) -> str:
    """One line for each point and climb, so that a change of it can be read."""
    parts = []
    for key, value in content.items():
        if isinstance(value, list):
            lines = ",\n".join(f"    {json.dumps(each)}" for each in value)
            parts.append(f'  "{key}": [\n{lines}\n  ]')
        else:
            parts.append(f'  "{key}": {json.dumps(value)}')
    return "{\n" + ",\n".join(parts) + "\n}"


def _rounded(value):
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_rounded(each) for each in value]
    return value


def _climb_line(climb: Measured) -> str:
    def short(rung) -> str:
        verdict = "plausible" if rung.plausible else "succeeded" if rung.succeeded else "no"
        return f"{rung.beam}: {rung.time_s:.2f} s {verdict} {rung.error:.3f}"

    return f"{climb.kind} {climb.case}: " + "; ".join(map(short, climb.rungs))


def _predict(options: argparse.Namespace, header: list[str]) -> int:
    kind = KINDS["sounds"]
    if missing := kind.missing(options.shared):
        print(missing)
        return 2
    rows = []
    print(predictions.HEADER)
    with ProcessPoolExecutor(options.processes) as pool:
        for own in pool.map(
            partial(predictions.judge, options), kind.make(options.shared, options.limit)
        ):
            rows += own
            print("\n".join(map(predictions.line, own)), flush=True)
    shares = predictions.shares(rows)
    print(predictions.shares_text(shares))
    write_csv(options.output / f"predictions_{options.clock}.csv", header, rows)
    print(f"written to {options.output}")
    if options.record:
        _amend({"judged": {**_machine_now(options, header), "stops": shares}})
    return 0


def _keys(options: argparse.Namespace, header: list[str]) -> int:
    rows = keys.rows(options)
    print("\n".join(map(keys.line, rows)))
    write_csv(options.output / "keys.csv", header, rows)
    if options.record:
        _amend({"keys": rows})
    return 0


def _amend(parts: dict[str, object]) -> None:
    """Replace parts of what was recorded."""
    content = json.loads(DATA.read_text(encoding="utf-8")) | parts
    DATA.write_text(_json(_rounded(content)) + "\n", encoding="utf-8")
    print(f"recorded in {DATA}")


if __name__ == "__main__":
    sys.exit(main())
