"""Compares rigid-body engines: contact times, energy, penetration and rest beside the time taken.

    .venv/bin/python -m benchmarks.physics [--quick] [--only peers|speed] [--bodies d6 ...]
                                           [--engines event ...] [--seed N] [--output DIR]

`make bench-physics` installs and builds the peers first; engines that are not there are named with
the reason, and left out. docs/physics.md says what is compared and how.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from . import compare, picture, report, speed
from .engines import UNTIL_S, Kind, available

ROOT = Path(__file__).resolve().parents[2]


def peers(options: argparse.Namespace, kinds: list[Kind], header: list[str]) -> None:
    """The comparison of the engines: table, CSV, picture, and a summary at one step for docs/."""
    steps = compare.STEPS_PER_S[::3] if options.quick else compare.STEPS_PER_S
    count, timed, repeats = (8, 4, 1) if options.quick else (200, 40, 5)
    count, known = options.simulations or count, len(header)
    header = [
        *header,
        f"{count} simulations a case, {min(timed, count)} of them timed {repeats} times in turns, "
        f"the median; at most {UNTIL_S:g} s each; CPU time on one core",
        *([] if options.friction is None else [f"friction {options.friction:g}"]),
    ]
    print("\n".join(header[known:]))
    rows = []
    for name in options.bodies:
        cases, reference = compare.run(
            compare.body_for(name, options.friction),
            kinds,
            steps,
            count,
            timed,
            repeats,
            options.seed,
            progress,
        )
        finest = {case.engine: case.contacts_s for case in cases if case.steps_per_s == steps[-1]}
        print(f"\n{report.COMPARISON_HEADER}")
        for case in cases:
            rows.append(compare.figures(case, reference, finest[case.engine]))
            print(report.comparison_line(rows[-1]), flush=True)
    report.write_csv(options.output / "comparison.csv", header, rows)
    picture.work_precision(rows, options.output / "work_precision.png")
    summary = report.summary(rows, steps[len(steps) // 3])  # 1/1000, or the middle of --quick
    (options.output / "summary.md").write_text(summary, encoding="utf-8")
    print(f"\nwritten to {options.output}: comparison.csv, work_precision.png, summary.md")


def progress(text: str) -> None:
    if sys.stderr.isatty():
        print(f"\033[2K{text}", end="\r", file=sys.stderr, flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.physics", description="Compare rigid-body engines."
    )
    parser.add_argument("--quick", action="store_true", help="a few simulations, to see it work")
    parser.add_argument("--only", choices=("peers", "speed"))
    parser.add_argument("--bodies", nargs="+", choices=compare.BODIES, default=compare.BODIES)
    parser.add_argument("--engines", nargs="+", help="of the comparison; all that are there")
    parser.add_argument("--simulations", type=int, help="of each case")
    parser.add_argument(
        "--friction", type=float,
        help="of all bodies in the comparison; 0 compares impacts without the laws of friction",
    )  # fmt: skip
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "benchmarks" / "physics")
    parser.add_argument(
        "--libraries", type=Path, default=ROOT / "build" / "bench" / "benchmarks" / "physics",
        help="where the peers in C++ are built",
    )  # fmt: skip
    options = parser.parse_args(arguments)

    kinds, missing = available(options.libraries)
    if options.engines:
        unknown = set(options.engines) - {kind.name for kind in kinds} - set(missing)
        if unknown:
            parser.error(f"--engines: no {', '.join(sorted(unknown))}")
        kinds = [kind for kind in kinds if kind.name in options.engines]
        missing = {name: why for name, why in missing.items() if name in options.engines}
    header = report.machine(
        [
            *(f"{kind.name}: {kind.version}" for kind in kinds),
            f"seed {options.seed}, {time.strftime('%Y-%m-%d')}",
        ]
    )
    print("\n".join(header))
    for name, why in missing.items():
        print(f"without {name}: {why}")
    cleared = True
    if options.only != "speed" and kinds:
        peers(options, kinds, header)
    if options.only != "peers":
        cleared = speed.run(options, header)
    return 0 if cleared else 1


if __name__ == "__main__":
    sys.exit(main())
