"""Throws of a body, simulated in different ways: when their contacts come, beside a reference."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from statistics import fmean

import numpy as np

from ifa._core import IfaValueError
from ifa.batch import sample_states
from ifa.body import Body
from ifa.marks import Signature
from ifa.simulation import Run, State, simulate
from ifa.tradeoff.curve import Outcome, Scene

UNTIL_S = 1.0  # of measured runs: coins and balls roll on for long
DEFAULT_STEP_S = 1e-3  # of `ifa.simulate`
_AFTER_S = 0.1  # a reference runs on so long after the contact as a plain run has it
_SAME_TIME_S = 1e-12  # roundings of times of up to UNTIL_S
_LIFT = 0.5  # of the farthest vertex' distance
_TRIES = 4  # samples for each throw that is wanted

Simulation = Callable[[State, float], Run]  # from a state, until so many seconds later


@dataclass(frozen=True)
class Throw:
    """A state to start from, and how long a reference must run to have the contact."""

    state: State
    until_s: float


@dataclass(frozen=True)
class Throws:
    """Random throws in sets of `number`, one set for each repeat: by the paper's sampling.

    What is compared is the time of the audible contact `contact`, from 1. Only throws that have one
    are taken; a set has fewer where they are rare.
    """

    scene: Scene
    number: int
    contact: int
    _sets: dict[int, list[Throw]] = field(default_factory=dict)

    def of(self, repeat: int) -> Sequence[Throw]:
        """The throws of a set."""
        if repeat not in self._sets:
            self._sets[repeat] = self._sample(repeat)
        return self._sets[repeat]

    def _sample(self, repeat: int) -> list[Throw]:
        body, room = self.scene.body, _TRIES * self.number
        plain = event_simulation(body, DEFAULT_STEP_S)
        states = sample_states(
            body, room, self.scene.seed, repeat * room, threads=self.scene.threads
        )
        # They touch the ground, so that a body with sharper edges would begin below it.
        lift_m = _LIFT * float(np.linalg.norm(body.outline_m, axis=1).max())
        found: list[Throw] = []
        for row in range(room):
            state = states[row]
            state = replace(state, position_m=state.position_m + np.array([0.0, 0.0, lift_m]))
            time_s = contact_time_s(plain(state, UNTIL_S), self.contact)
            if time_s is not None:
                found.append(Throw(state, time_s + _AFTER_S))
            if len(found) == self.number:
                break
        return found


@dataclass(frozen=True)
class Reference:
    """When the contact of each throw comes, s, by a simulation; None where it has too few."""

    throws: Throws
    simulation: Simulation
    _sets: dict[int, list[float | None]] = field(default_factory=dict)

    def of(self, repeat: int) -> Sequence[float | None]:
        """The times of a set, which are found once."""
        if repeat not in self._sets:
            self._sets[repeat] = [
                contact_time_s(self.simulation(throw.state, throw.until_s), self.throws.contact)
                for throw in self.throws.of(repeat)
            ]
        return self._sets[repeat]


def contact_time_s(run: Run, contact: int) -> float | None:
    """When the audible contact of that number, from 1, comes; None where there are fewer."""
    try:
        times_s = Signature.from_run(run).times_s
    except IfaValueError:  # nothing is heard
        return None
    return float(times_s[contact - 1]) if len(times_s) >= contact else None


def measured(reference: Reference, simulation: Simulation) -> Callable[[int], Outcome]:
    """What a setting runs: a set of throws by `simulation`, their contacts against the reference.

    The error is the mean one, ms, the time the mean of one simulation. Throws that fail or have too
    few contacts, here or in the reference, are losses.
    """

    def run(repeat: int) -> Outcome:
        throws, wanted_s = reference.throws.of(repeat), reference.of(repeat)
        if not throws:
            reason = f"none of the throws has {reference.throws.contact} audible contacts"
            return Outcome(0.0, 0.0, reason)
        began_s = time.perf_counter()
        runs = [simulation(throw.state, UNTIL_S) for throw in throws]
        time_s = (time.perf_counter() - began_s) / len(throws)
        return _outcome(runs, wanted_s, reference.throws.contact, time_s)

    return run


def _outcome(
    runs: Sequence[Run], wanted_s: Sequence[float | None], contact: int, time_s: float
) -> Outcome:
    errors_s = []
    lost = dict.fromkeys(
        (
            "ODE could not go on",
            f"fewer than {contact} audible contacts",
            f"fewer than {contact} audible contacts in the reference",
        ),
        0,
    )
    failed, short, unknown = lost
    for run, wanted in zip(runs, wanted_s, strict=True):
        got = contact_time_s(run, contact)
        if run.status == "failed":
            lost[failed] += 1
        elif wanted is None:
            lost[unknown] += 1
        elif got is None:
            lost[short] += 1
        else:
            error_s = abs(got - wanted)
            errors_s.append(error_s if error_s > _SAME_TIME_S else 0.0)
    losses = tuple(f"{n} of {len(runs)} throws: {why}" for why, n in lost.items() if n)
    if not errors_s:
        return Outcome(time_s, 0.0, "; ".join(losses))
    return Outcome(time_s, 1e3 * fmean(errors_s), losses=losses)


def event_simulation(body: Body, step_s: float) -> Simulation:
    """Of a body by the event engine."""
    return lambda state, until_s: simulate(body, state, step_s=step_s, until_s=until_s)


def ode_simulation(body: Body, step_s: float, flight: str) -> Simulation:
    """Of a body by ODE."""
    return lambda state, until_s: simulate(
        body, state, engine="ode", step_s=step_s, until_s=until_s, flight=flight
    )
