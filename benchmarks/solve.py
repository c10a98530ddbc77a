"""Solves the recordings and motion-captured tosses of ../shared and prints how well.

    .venv/bin/python benchmarks/solve.py [--only sounds|tosses] [--limit N] [--seed N]
                                         [--time-budget S] [--threads N]

Recordings: every hit of sounds/*.hits.txt is a mark, its loudness comes from the .wav, the
restitution is fitted. Tosses: every hit of tosses/cube_tosses.json is a mark with the measured
impulse, the body and its material are those measured. Every motion is checked by `ifa.verify`.
One case after the other; each solve uses all threads. The same table is written to
build/benchmarks/ as CSV. After a whole run the results stand beside the bars that they have to
clear; the exit code is 1 where one is missed.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import platform
import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from itertools import product
from pathlib import Path

import ifa

ROOT = Path(__file__).resolve().parents[1]
SHARED = ROOT.parent / "shared"

# Bodies of recordings whose name does not say it; these two bounce on after the recording ends.
OTHER_BODIES = {
    "diceapi_roll1": ("d6", "rest"),
    "qabcs_rubber_ball": ("ball", "open"),
    "foobillard_balloutoftable": ("ball", "open"),
}


@dataclass(frozen=True)
class Bar:
    """How many of how many cases have to succeed, with what score at least."""

    succeeded: int
    cases: int
    score: float = 0.0


BARS = {"sounds": Bar(9, 12, score=0.5), "tosses": Bar(160, 179)}


@dataclass(frozen=True)
class Case:
    """One problem."""

    name: str
    body: ifa.Body
    marks: ifa.Signature
    material: str


@dataclass(frozen=True)
class Row:
    """What became of a case. Errors, retiming and excess are those of the worst mark."""

    case: str
    body: str
    marks: int
    succeeded: bool
    plausible: bool
    score: float
    error_ms: float
    retime_percent: float
    excess: float
    restitution: float
    friction: float
    verified: bool
    rung: int
    solve_s: float
    note: str


def sound_cases() -> Iterator[Case]:
    for path in sorted((SHARED / "sounds").glob("*.hits.txt")):
        name = path.name.removesuffix(".hits.txt")
        body, ending = OTHER_BODIES.get(name) or (name.split("_")[1], "rest")
        marks = ifa.Signature.read(path, sound=path.with_name(f"{name}.wav"), ending=ending)
        yield Case(name, ifa.bodies.get(body), marks, "fit")


def toss_cases() -> Iterator[Case]:
    data = json.loads((SHARED / "tosses" / "cube_tosses.json").read_text(encoding="utf-8"))
    cube = data["object"]
    half = 0.5 * cube["side_m"]
    body = ifa.Body.from_vertices(
        [(x, y, z) for x, y, z in product((-half, half), repeat=3)],
        mass_kg=cube["mass_kg"],
        inertia_kg_m2=cube["inertia_kgm2"],
        restitution=cube["restitution"],
        friction=cube["mu"],
        name="cube",
    )
    for toss in data["tosses"]:
        marks = ifa.Signature(
            [hit["t"] for hit in toss["hits"]],
            amplitudes=[hit["amp"] for hit in toss["hits"]],
            ending="rest" if toss["terminal"] else "open",
        )
        yield Case(f"toss_{toss['toss']:03}", body, marks, "given")


def run(case: Case, options: argparse.Namespace) -> Row:
    begin_s = time.perf_counter()
    try:
        solution = ifa.solve(
            case.body,
            case.marks,
            material=case.material,
            seed=options.seed,
            time_budget_s=options.time_budget,
            threads=options.threads,
        )
    except ifa.NoMotionError as error:
        return Row(
            case=case.name, body=case.body.name, marks=len(case.marks), succeeded=False,
            plausible=False, score=0.0, error_ms=float("nan"), retime_percent=float("nan"),
            excess=float("nan"), restitution=case.body.restitution, friction=case.body.friction,
            verified=False, rung=-1, solve_s=time.perf_counter() - begin_s, note=str(error),
        )  # fmt: skip
    events = solution.events
    certificate = ifa.verify(
        solution.motion, solution.body, case.marks, retime=[event.retime for event in events]
    )
    return Row(
        case=case.name,
        body=case.body.name,
        marks=len(case.marks),
        succeeded=solution.succeeded,
        plausible=solution.plausible,
        score=solution.score,
        error_ms=1e3 * solution.max_abs_error_s,
        retime_percent=100.0 * max(event.retiming for event in events),
        excess=max(event.excess for event in events),
        restitution=solution.restitution,
        friction=solution.friction,
        verified=certificate.passed,
        rung=solution.rung,
        solve_s=solution.solve_s,
        note="" if certificate.passed else "; ".join(certificate.failures),
    )


HEADER = (
    f"{'case':26} {'body':5} {'marks':>5} {'succeeded':>9} {'plausible':>9} {'score':>6} "
    f"{'error ms':>8} {'retime %':>8} {'excess':>7} {'e':>5} {'verify':>6} {'rung':>4} {'s':>6}"
)


def line(row: Row) -> str:
    def yes(value: bool) -> str:
        return "yes" if value else "NO"

    text = (
        f"{row.case:26} {row.body:5} {row.marks:5} {yes(row.succeeded):>9} {yes(row.plausible):>9} "
        f"{row.score:6.3f} {row.error_ms:8.3f} {row.retime_percent:8.2f} {row.excess:7.3f} "
        f"{row.restitution:5.2f} {yes(row.verified):>6} {row.rung:4} {row.solve_s:6.2f}"
    )
    return f"{text}\n    {row.note}" if row.note else text


def summary(name: str, rows: list[Row]) -> str:
    solved = [row for row in rows if row.succeeded]
    good = [row for row in rows if row.plausible]
    times_s = [row.solve_s for row in rows]
    text = (
        f"{name}: succeeded {len(solved)} of {len(rows)}, plausible {len(good)}, "
        f"verified {sum(row.verified for row in rows)}; "
        f"solve {statistics.median(times_s):.2f} s median, {max(times_s):.2f} s longest, "
        f"{sum(times_s):.1f} s in all"
    )
    if solved:
        scores = [row.score for row in solved]
        retiming = statistics.median(row.retime_percent for row in solved)
        excess = statistics.median(row.excess for row in solved)
        text += (
            f"; of those that succeeded: score {statistics.median(scores):.3f} median, "
            f"{min(scores):.3f} lowest; median of the worst mark: retiming {retiming:.2f} %, "
            f"excess {excess:.3f}"
        )
    return text


def judged(kind: str, rows: list[Row]) -> tuple[bool, str]:
    """Whether the bar is cleared, and a line that says so."""
    bar = BARS[kind]
    good = sum(row.succeeded and row.score >= bar.score for row in rows)
    unverified = [row.case for row in rows if row.succeeded and not row.verified]
    cleared = good >= bar.succeeded and len(rows) == bar.cases and not unverified
    scored = f" with a score of at least {bar.score:g}" if bar.score else ""
    line = (
        f"bar: {bar.succeeded} of {bar.cases} succeeded{scored}, each of those verified; "
        f"got {good} of {len(rows)}, {len(unverified)} not verified: "
        f"{'cleared' if cleared else 'MISSED'}"
    )
    return cleared, line


def write_csv(path: Path, rows: list[Row]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Row)])
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def main() -> int:
    parser = argparse.ArgumentParser(description="Solve the evaluation data and print a table.")
    parser.add_argument("--only", choices=("sounds", "tosses"))
    parser.add_argument("--limit", type=int, help="cases of each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--time-budget", type=float, default=10.0)
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    if not SHARED.is_dir():
        print(f"no evaluation data at {SHARED}", file=sys.stderr)
        return 2
    print(
        f"ifa {ifa.__version__}, seed {options.seed}, budget {options.time_budget:g} s, "
        f"{options.threads or os.cpu_count()} threads, {platform.machine()}"
    )
    summaries = []
    cleared = True
    for kind, cases in (("sounds", sound_cases), ("tosses", toss_cases)):
        if options.only not in (None, kind):
            continue
        print(f"\n{HEADER}")
        rows = []
        for case in list(cases())[: options.limit]:
            rows.append(run(case, options))
            print(line(rows[-1]), flush=True)
        path = ROOT / "build" / "benchmarks" / f"{kind}.csv"
        write_csv(path, rows)
        summaries.append(f"{summary(kind, rows)}\n    {path.relative_to(ROOT)}")
        if options.limit is None:
            good, text = judged(kind, rows)
            cleared = cleared and good
            summaries.append(f"    {text}")
    print("\n" + "\n".join(summaries))
    return 0 if cleared else 1


if __name__ == "__main__":
    sys.exit(main())
