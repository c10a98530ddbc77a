"""How long planning takes, by the core alone and by `ifa.plan`: it shall be below 1 ms."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import ifa
import numpy as np
from ifa import _core

REPEATS = 2000


@dataclass(frozen=True)
class PlanTime:
    """Of one scene: medians of the core, called from Python, and of `ifa.plan`."""

    scene: str
    core_us: float
    python_us: float
    late_us: float  # 99 of 100 calls of ifa.plan are faster


def scenes() -> Iterator[tuple[str, ifa.Body, ifa.Signature]]:
    """From the least that can be asked to the most marks, with a constraint at each tenth."""
    yield "ball, 1 mark", ifa.bodies.get("ball"), ifa.Signature([0.3], ending="open")
    random = np.random.default_rng(0)
    for body, marks in (("d6", 15), ("coin", 15), ("d20", 200)):
        times_s = 0.3 + np.cumsum(random.uniform(0.05, 0.3, marks))
        signature = ifa.Signature(
            times_s,
            np.full(marks, 0.02),
            random.uniform(0.1, 1.0, marks),
            constraints=[ifa.Position(k, (0.01 * k, 0.0)) for k in range(0, marks, 10)],
        )
        yield f"{body}, {marks} marks, all asked", ifa.bodies.get(body), signature


def measure(repeats: int = REPEATS) -> list[PlanTime]:
    rows = []
    for scene, body, marks in scenes():
        core_us = _times_us(
            lambda body=body, marks=marks: _core.plan(
                body._core,
                marks._marks,
                contact=False,
                fit_material=False,
                lead_in_s=0.5,
                method_graph=False,
                forced={},
            ),
            repeats,
        )
        python_us = _times_us(lambda body=body, marks=marks: ifa.plan(body, marks), repeats)
        rows.append(
            PlanTime(
                scene,
                float(np.median(core_us)),
                float(np.median(python_us)),
                float(np.percentile(python_us, 99)),
            )
        )
    return rows


def text(rows: list[PlanTime]) -> str:
    lines = [f"{'plan':28} {'core us':>8} {'ifa.plan us':>12} {'99 % below':>11}"]
    lines += [
        f"{row.scene:28} {row.core_us:8.1f} {row.python_us:12.1f} {row.late_us:11.1f}"
        for row in rows
    ]
    return "\n".join(lines)


def _times_us(run: Callable[[], object], repeats: int) -> np.ndarray:
    run()  # what is read or computed once
    times_ns = np.empty(repeats)
    for k in range(repeats):
        began_ns = time.perf_counter_ns()
        run()
        times_ns[k] = time.perf_counter_ns() - began_ns
    return times_ns / 1e3


if __name__ == "__main__":
    print(text(measure()))
