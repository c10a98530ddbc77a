"""States, free flight and simulation of one rigid body above the ground z = 0."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ifa import _core, arguments
from ifa._core import IfaValueError
from ifa.body import Body

GRAVITY_M_S2 = 9.81
_UNIT_ROUNDING = 1e-15  # dividing by the length leaves a few roundings of 1.1e-16


@dataclass(frozen=True, eq=False)
class State:
    """Where a body is and how it moves, in world axes; one state or n of them.

    position_m: (3,) or (n, 3), of the centre of mass. quaternion_wxyz: (4,) or (n, 4), from body to
    world axes; normalised here. velocity_m_s: (3,) or (n, 3), of the centre of mass.
    angular_velocity_rad_s: (3,) or (n, 3), world axes. Raises IfaValueError naming the field.
    """

    position_m: np.ndarray
    quaternion_wxyz: np.ndarray
    velocity_m_s: np.ndarray
    angular_velocity_rad_s: np.ndarray

    def __init__(
        self,
        position_m: ArrayLike,
        quaternion_wxyz: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity_m_s: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity_rad_s: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        rows: tuple[int | None, ...] = (
            () if np.ndim(position_m) < 2 else (len(np.asarray(position_m)),)
        )
        for field, value, width in (
            ("position_m", position_m, 3),
            ("quaternion_wxyz", quaternion_wxyz, 4),
            ("velocity_m_s", velocity_m_s, 3),
            ("angular_velocity_rad_s", angular_velocity_rad_s, 3),
        ):
            checked = arguments.array(value, field, (*rows, width))
            if not np.isfinite(checked).all():
                raise IfaValueError(f"{field}: must be finite")
            if field == "quaternion_wxyz":
                length = np.linalg.norm(checked, axis=-1, keepdims=True)
                if (length == 0.0).any():
                    raise IfaValueError("quaternion_wxyz: must not be zero")
                # A unit one is kept, so that a state's own parts make the same state again.
                unit = np.abs(length - 1.0) <= _UNIT_ROUNDING
                checked = np.where(unit, checked, checked / length)
            checked.flags.writeable = False
            object.__setattr__(self, field, checked)

    def __len__(self) -> int:
        """The number of states; a single state has none (TypeError)."""
        if self.position_m.ndim == 1:
            raise TypeError("a single State has no length")
        return len(self.position_m)

    def __getitem__(self, index: Any) -> State:
        """States `index` of n."""
        if self.position_m.ndim == 1:
            raise TypeError("a single State has no rows")
        return State(
            self.position_m[index],
            self.quaternion_wxyz[index],
            self.velocity_m_s[index],
            self.angular_velocity_rad_s[index],
        )


@dataclass(frozen=True)
class Hits:
    """Impacts, one row for each impact instant, audible or not.

    time_s (n,); impulse_n_s (n, 3), on the body, summed over the touching points, world axes;
    approach_speed_m_s (n,), the largest over the touching points; position_m (n, 3), the centre of
    the normal impulses.
    """

    time_s: np.ndarray
    impulse_n_s: np.ndarray
    approach_speed_m_s: np.ndarray
    position_m: np.ndarray

    def __len__(self) -> int:
        """The number of impact instants."""
        return len(self.time_s)


@dataclass(frozen=True)
class Run:
    """What a simulation yields.

    status: "rest", "time_limit", "impact_limit", or "failed" where ODE could not go on (the rest
    of the run is what it had until then). times_s (n,): the start, both sides of each impact, each
    step of sustained contact and the end. states: n rows. hits: every impact; with engine="ode"
    every one that bounces, those above 0.01 m/s. rest_s: when rest began, or None.
    """

    status: str
    times_s: np.ndarray
    states: State
    hits: Hits
    rest_s: float | None


def gravity_vector(gravity_m_s2: ArrayLike) -> np.ndarray:
    """Gravity as a vector (3,), from a vector or its size (downwards)."""
    if np.ndim(gravity_m_s2) == 0:
        return np.array([0.0, 0.0, -arguments.positive(gravity_m_s2, "gravity_m_s2")])
    vector = arguments.array(gravity_m_s2, "gravity_m_s2", (3,))
    if not np.isfinite(vector).all():
        raise IfaValueError("gravity_m_s2: must be finite")
    return vector


def time_limit(until_s: float | None, gravity_m_s2: np.ndarray) -> float:
    """`until_s`, or infinity where None asks for a run to rest under gravity (3,), not zero."""
    if not gravity_m_s2.any():
        raise IfaValueError("gravity_m_s2: must not be zero")
    if until_s is None:
        if gravity_m_s2[2] >= 0.0:
            raise IfaValueError("gravity_m_s2: must point down, or until_s be given")
        return np.inf
    limit = arguments.number(until_s, "until_s")
    if not 0.0 <= limit < np.inf:
        raise IfaValueError(f"until_s: must be finite and 0 or more, got {limit:g}")
    return limit


def state_arrays(state: State) -> tuple[np.ndarray, ...]:
    """The four arrays of a state, as the core takes them."""
    return (
        state.position_m,
        state.quaternion_wxyz,
        state.velocity_m_s,
        state.angular_velocity_rad_s,
    )


def fly(
    body: Body,
    state: State,
    times_s: ArrayLike,
    gravity_m_s2: ArrayLike = GRAVITY_M_S2,
) -> State:
    """Torque-free flight of a body from one state, exact, as if there were no ground.

    times_s: (n,), s from the state, of any sign. gravity_m_s2: its size, downwards, or a vector
    (3,). Returns a State with n rows. The position is a parabola; the rotation solves Euler's
    equations, by a constant spin for an isotropic body and a Taylor series to rounding otherwise.
    """
    _single(state)
    times = arguments.array(times_s, "times_s", (None,))
    if not np.isfinite(times).all():
        raise IfaValueError("times_s: must be finite")
    gravity = (
        np.zeros(3)
        if np.ndim(gravity_m_s2) == 0 and gravity_m_s2 == 0
        else gravity_vector(gravity_m_s2)
    )
    return State(*_core.fly(body._core, *state_arrays(state), times, gravity))


def simulate(
    body: Body,
    state: State,
    engine: str = "event",
    step_s: float = 1e-3,
    until_s: float | None = None,
    gravity_m_s2: ArrayLike = GRAVITY_M_S2,
    progress: _core.Progress | None = None,
    flight: str = "exact",
) -> Run:
    """A body's motion from one state above the ground z = 0, to rest or to `until_s`.

    engine="event": flight in closed form, impacts at their exact instants over all touching points
    (Newton restitution, Coulomb cone, energy never grows), steps of `step_s` in sustained contact
    only. engine="ode": the paper's velocity-level contact problem, solved by the Open Dynamics
    Engine, to compare with; flight="exact" flies in closed form to the exact instant of each
    contact, flight="stepped" leaves all to ODE in steps of `step_s`, errors included. Its friction
    is a box aligned with the slip, bounded by the frictionless normal force (dContactApprox1).
    until_s: s from the state; None runs to rest, which takes gravity that points down.
    gravity_m_s2: its size, downwards, or a vector (3,), not zero. Raises IfaValueError naming the
    argument, ifa.Cancelled.
    """
    _single(state)
    if engine not in ("event", "ode"):
        raise IfaValueError(f'engine: must be "event" or "ode", got {engine!r}')
    if flight not in ("exact", "stepped"):
        raise IfaValueError(f'flight: must be "exact" or "stepped", got {flight!r}')
    if engine == "event" and flight != "exact":
        raise IfaValueError('flight: engine="event" flies exactly, only engine="ode" can step')
    gravity = gravity_vector(gravity_m_s2)
    limit = time_limit(until_s, gravity)
    arguments.check_progress(progress)
    options = {
        "step_s": arguments.positive(step_s, "step_s"),
        "until_s": limit,
        "gravity_m_s2": gravity,
        "progress": progress,
    }
    if engine == "event":
        run = _core.simulate(body._core, *state_arrays(state), **options)
    else:
        run = _core.simulate_ode(
            body._core, *state_arrays(state), skip_flight=flight == "exact", **options
        )
    status, rest_s, times, states, hits = run
    return Run(status, times, State(*states), Hits(*hits), rest_s if status == "rest" else None)


def _single(state: State) -> None:
    if not isinstance(state, State) or state.position_m.ndim != 1:
        raise IfaValueError("state: needs one ifa.State, with position_m of shape (3,)")
