"""Engine speed: the event engine's instruction sets against ODE at 1 ms, behind the gate.

No speed is shown without the verdict of equivalence.py beside it.
"""

from __future__ import annotations

import argparse
import time

import ifa
import numpy as np

from . import equivalence, report
from .engines import UNTIL_S, available
from .starts import lifted

STEP_S = 1e-3  # the default of both engines
REFERENCE_STEP_S = 0.1 * STEP_S
SAMPLES = 20_000
# The least number of times that ODE's simulations per second are reached.
BARS = {"scalar": 4.0, "avx2": 8.0, "avx512": 20.0}


def batch(body: ifa.Body, states: ifa.State, set_name: str, **options: object) -> ifa.Batch:
    """`ifa.simulate_batch` with an instruction set."""
    return ifa.simulate_batch(
        body,
        states,
        until_s=UNTIL_S,
        instruction_set=set_name,
        **options,  # type: ignore[arg-type]
    )


def sample(body: ifa.Body, states: ifa.State, set_name: str, step_s: float) -> equivalence.Sample:
    """What the gate compares of `states`, on all cores."""
    return equivalence.simulated(
        body, states, lambda some, out: batch(body, some, set_name, step_s=step_s, out=out)
    )


def run(options: argparse.Namespace, header: list[str]) -> bool:
    """The table, speed.csv, and whether every gate and bar is cleared."""
    samples, timed, repeats = (200, 50, 1) if options.quick else (SAMPLES, 2000, 5)
    samples = options.simulations or samples
    ode = next((k for k in available(options.libraries)[0] if k.name == "ode"), None)
    rows: list[report.Row] = []
    cleared = True
    for name in options.bodies:
        body = ifa.bodies.get(name)
        states = lifted(body, samples, options.seed)
        some = states[:timed]
        sets = ifa.instruction_sets()
        exact = sample(body, states, sets[0], REFERENCE_STEP_S)  # scalar comes first
        verdicts = {s: equivalence.compare(sample(body, states, s, STEP_S), exact) for s in sets}
        times_s: dict[str, list[float]] = {s: [] for s in sets}
        ode_s = []
        for _ in range(repeats):
            for s in sets:
                out = ifa.Batch.allocate(len(some))
                begin_s = time.process_time()
                batch(body, some, s, step_s=STEP_S, threads=1, out=out)
                times_s[s].append((time.process_time() - begin_s) / len(some))
            if ode:
                ode_s.append(ode.make(body, STEP_S).time(some) / len(some))
        ode_per_s = 1.0 / float(np.median(ode_s)) if ode else np.nan
        print(f"\n{name}: ODE at {1e3 * STEP_S:g} ms {ode_per_s:.0f} simulations/s")
        for s in sets:
            verdict, per_s = verdicts[s], 1.0 / float(np.median(times_s[s]))
            ratio = per_s / ode_per_s
            bar = BARS.get(s)
            reached = bar is None or not ratio < bar  # nan, without ODE: no judgement
            cleared = cleared and verdict.passed and reached
            against = "" if bar is None else f" (bar {bar:g}: {'' if reached else 'not '}reached)"
            print(f"  {s:8} {per_s:8.0f} simulations/s, {ratio:.1f} times ODE{against}")
            print(f"           {verdict}", flush=True)
            rows.append(
                {
                    "body": name,
                    "instruction_set": s,
                    "simulations_per_s": per_s,
                    "ode_simulations_per_s": ode_per_s,
                    "ratio": ratio,
                    **vars(verdict),
                    "passed": verdict.passed,
                }
            )
    note = (
        f"{samples} simulations for the gate against {sets[0]} at "
        f"{1e3 * REFERENCE_STEP_S:g} ms; {timed} timed, median of {repeats}; one core"
    )
    report.write_csv(options.output / "speed.csv", [*header, note], rows)
    (options.output / "speed.md").write_text(summary(rows), encoding="utf-8")
    print(f"\n{note}\nwritten to {options.output}: speed.csv, speed.md")
    return cleared


def summary(rows: list[report.Row]) -> str:
    """The table in Markdown, for docs/physics.md."""
    lines = [
        "| body | instruction set | simulations/s | times ODE at 1 ms | largest D | p of the faces "
        "| first two audible hits: largest error, share within 1e-6 s | first two impacts | gate |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        largest_d = max(row[key] for key in ("count_d", "interval_d", "impulse_d"))  # type: ignore
        lines.append(
            f"| {row['body']} | {row['instruction_set']} | {row['simulations_per_s']:.0f} "
            f"| {row['ratio']:.1f} | {largest_d:.4f} | {row['face_p']:.3f} "
            f"| {row['first_two_s']:.1e} s, {100.0 * row['first_two_exact']:.3f} % "  # type: ignore
            f"| {row['first_impacts_s']:.1e} s | {'passed' if row['passed'] else 'failed'} |"
        )
    return "\n".join(lines) + "\n"
