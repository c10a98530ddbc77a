"""The comparison: every engine at every step on the same states, timed in turns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import ifa
import numpy as np

from .engines import Event, Kind
from .measure import CONTACTS, Outcome
from .starts import Array, lifted

BODIES = ("d6", "eraser", "card", "d20")
STEPS_PER_S = (240, 500, 1000, 2000, 4000, 8000, 16000)
# The reference: exact instants of impact, and sustained contact in steps a tenth of the finest.
REFERENCE_STEP_S = 0.1 / STEPS_PER_S[-1]
REFERENCE_UNTIL_S = 1.5  # the fourth contact of nearly all comes before
NOTABLE_GAIN = 0.01


def body_for(name: str, friction: float | None = None) -> ifa.Body:
    """A body of the library without rolling and spinning friction, which not all engines have."""
    body = ifa.bodies.get(name).replace(rolling_friction_m=0.0, spin_friction_m=0.0)
    return body if friction is None else body.replace(friction=friction)


@dataclass(frozen=True)
class Case:
    """An engine at one step on one body. simulation_s: CPU time of one, one value a repeat."""

    body: str
    engine: str
    steps_per_s: int
    outcomes: list[Outcome]
    simulation_s: list[float] = field(default_factory=list)

    @property
    def contacts_s(self) -> Array:
        """(simulations, CONTACTS)."""
        return np.array([outcome.contacts_s for outcome in self.outcomes])


def run(
    body: ifa.Body,
    kinds: Sequence[Kind],
    steps_per_s: Sequence[int],
    count: int,
    timed: int,
    repeats: int,
    seed: int,
    say: Callable[[str], None],
) -> tuple[list[Case], Array]:
    """All cases of one body, and the reference's contacts (count, CONTACTS)."""
    name = body.name
    states = lifted(body, count, seed)
    exact = Event(body, REFERENCE_STEP_S, REFERENCE_UNTIL_S)
    reference = np.array([exact.outcome(states[i]).contacts_s for i in range(count)])
    engines, cases = [], []
    for kind in kinds:
        say(f"{name}: {kind.name}")
        for steps in steps_per_s:
            engine = kind.make(body, 1.0 / steps)
            engines.append(engine)
            outcomes = [engine.outcome(states[i]) for i in range(count)]
            cases.append(Case(name, kind.name, steps, outcomes))
    some = states[: min(timed, count)]
    for repeat in range(repeats):  # in turns, so that a busy spell of the machine is shared
        say(f"{name}: timing, {repeat + 1} of {repeats}")
        for engine, case in zip(engines, cases, strict=True):
            case.simulation_s.append(engine.time(some) / len(some))
    return cases, reference


def errors(contacts_s: Array, reference_s: Array) -> list[Array]:
    """For each contact the errors, s, of the simulations whose reference has it (inf: missed)."""
    rows = []
    for k in range(CONTACTS):
        known = np.isfinite(reference_s[:, k])
        rows.append(np.abs(contacts_s[known, k] - reference_s[known, k]))
    return rows


def quantile(values: Array, share: float) -> float:
    """An order statistic, so that missed contacts (inf) do no harm below it; nan of nothing."""
    return float(np.quantile(values, share, method="inverted_cdf")) if len(values) else np.nan


def figures(case: Case, reference_s: Array, finest_s: Array) -> dict[str, object]:
    """The row of a case in the CSV. finest_s: the engine's own contacts at its finest step."""
    row: dict[str, object] = {
        "body": case.body,
        "engine": case.engine,
        "steps_per_s": case.steps_per_s,
        "simulations": len(case.outcomes),
        "simulations_per_s": 1.0 / float(np.median(case.simulation_s)),
        "simulation_ms": 1e3 * float(np.median(case.simulation_s)),
        "simulation_ms_least": 1e3 * min(case.simulation_s),
        "simulation_ms_most": 1e3 * max(case.simulation_s),
    }
    for label, against in (("", reference_s), ("own_", finest_s)):
        for k, error in enumerate(errors(case.contacts_s, against), start=1):
            row[f"{label}contact_{k}_median_ms"] = 1e3 * quantile(error, 0.5)
            row[f"{label}contact_{k}_p90_ms"] = 1e3 * quantile(error, 0.9)
            if not label:
                row[f"contact_{k}_count"] = len(error)
                row[f"contact_{k}_missed"] = int(np.isinf(error).sum())
    gains = np.array([outcome.energy_gain for outcome in case.outcomes])
    depths = np.array([outcome.penetration_m for outcome in case.outcomes])
    row |= {
        "energy_gain_largest": float(gains.max()),
        "energy_gain_notable_share": float((gains > NOTABLE_GAIN).mean()),
        "penetration_largest_mm": 1e3 * float(depths.max()),
        "penetration_median_mm": 1e3 * float(np.median(depths)),
        "rest_share": float(np.mean([outcome.rests for outcome in case.outcomes])),
        "failed": sum(outcome.failed for outcome in case.outcomes),
    }
    return row
