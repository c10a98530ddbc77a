"""The engines that are compared, behind one interface, and which of them are at hand."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import ifa

from . import native
from .measure import Outcome, Trace, of_nodes

UNTIL_S = 5.0  # what does not rest by then does not rest


class Engine(Protocol):
    """An engine set up for one body and one step."""

    def time(self, states: ifa.State) -> float:
        """CPU seconds for all `states`, each run to rest, on one core, nothing recorded."""
        ...

    def outcome(self, state: ifa.State) -> Outcome:
        """The figures of the motion from one state."""
        ...


@dataclass(frozen=True)
class Kind:
    """How to make an engine of one kind: `make(body, step_s)`."""

    name: str
    version: str
    make: Callable[[ifa.Body, float], Engine]


class Event:
    """The project's engine="event"; its step is that of sustained contact only."""

    def __init__(self, body: ifa.Body, step_s: float, until_s: float = UNTIL_S) -> None:
        self._body, self._step_s, self._until_s = body, step_s, until_s

    def time(self, states: ifa.State) -> float:
        """CPU seconds for all `states`."""
        out = ifa.Batch.allocate(len(states))
        begin_s = time.process_time()
        ifa.simulate_batch(
            self._body, states, step_s=self._step_s, until_s=self._until_s, threads=1, out=out
        )
        return time.process_time() - begin_s

    def outcome(self, state: ifa.State) -> Outcome:
        """The figures of the motion from one state."""
        run = ifa.simulate(self._body, state, step_s=self._step_s, until_s=self._until_s)
        trace = Trace(
            run.times_s, run.states.position_m, run.states.quaternion_wxyz,
            run.states.velocity_m_s, run.states.angular_velocity_rad_s, run.status == "rest",
        )  # fmt: skip
        return of_nodes(self._body, trace)


def available(libraries: Path) -> tuple[list[Kind], dict[str, str]]:
    """The engines at hand, and of each other one why it is not; `libraries` holds those in C++."""
    kinds = [Kind("event", f"ifa {ifa.__version__}", Event)]
    missing: dict[str, str] = {}
    try:
        ode = native.load(libraries / "ode_peer.so")
    except OSError as error:
        missing["ode"] = missing["ode_flight"] = f"not built ({error})"
    else:
        version = native.version(ode)
        kinds += [
            Kind("ode", version, lambda b, s: native.Native(ode, b, s, UNTIL_S, False)),
            Kind("ode_flight", f"{version}, flight in closed form",
                 lambda b, s: native.Native(ode, b, s, UNTIL_S, False, skip_flight=True)),
        ]  # fmt: skip
    try:
        bullet = native.load(libraries / "bullet_peer.so")
    except OSError as error:
        missing["bullet"] = f"not built ({error})"
    else:
        kinds.append(
            Kind("bullet", native.version(bullet),
                 lambda b, s: native.Native(bullet, b, s, UNTIL_S, True))
        )  # fmt: skip
    try:
        from . import mujoco_peer
    except ImportError as error:
        missing["mujoco"] = f"not installed ({error})"
    else:
        kinds.append(
            Kind("mujoco", mujoco_peer.VERSION, lambda b, s: mujoco_peer.MuJoCo(b, s, UNTIL_S))
        )
    return kinds, missing
