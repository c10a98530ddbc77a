"""What is read from a motion, by one measure for all engines: contacts, energy, penetration, rest.

A *contact* is an event of CONVENTIONS.md: hull points that reach the ground faster than 0.05 m/s,
those less than 10 ms after the one before counted with it; its time is the first one's. Stepped
engines know of it up to a step late: their time is moved to the instant within the step at which
the point crossed the ground.
"""

from __future__ import annotations

from dataclasses import dataclass

import ifa
import numpy as np

from .starts import Array, up_in_body_axes

GRAVITY_M_S2 = 9.81
AUDIBLE_SPEED_M_S = 0.05
MERGE_GAP_S = 10e-3
REST_SPEED_M_S = 0.01
REST_SPAN_S = 0.05
# Bullet bounces a point back that is still a little above the ground, where a step would take it
# through.
EARLY_BOUNCE_M = 3e-4
TOUCH_SHARE = 1e-7  # of the body's size: points this near to the ground touch it
CONTACTS = 4


@dataclass(frozen=True)
class Trace:
    """A motion: world axes, quaternions wxyz. `rests`: it ended at rest, `failed`: in an error."""

    times_s: Array
    positions_m: Array
    quaternions_wxyz: Array
    velocities_m_s: Array
    spins_rad_s: Array
    rests: bool
    failed: bool = False


@dataclass(frozen=True)
class Outcome:
    """A simulation's figures. contacts_s: the first CONTACTS contacts, inf where there are fewer.

    energy_gain: the largest rise of the energy from a flight or approach to a later one, over the
    energy at the start. penetration_m: of the deepest hull point.
    """

    contacts_s: Array
    energy_gain: float
    penetration_m: float
    rests: bool
    failed: bool


def of_steps(body: ifa.Body, trace: Trace) -> Outcome:
    """The outcome of a motion of which every step is known.

    A point strikes within a step if it crosses the ground, at the instant that its heights at the
    step's ends give by linear interpolation, or if it is thrown back from just above the ground, at
    the instant at which it would have got there.
    """
    gaps, rates = _gaps_and_rates(body, trace)
    before, after = gaps[:-1], gaps[1:]
    step_s = np.diff(trace.times_s)[:, None]
    falls = (before > 0.0) & (after <= 0.0) & (before - after > AUDIBLE_SPEED_M_S * step_s)
    thrown = (
        (before > 0.0) & (before < EARLY_BOUNCE_M) & (after > 0.0)
        & (rates[:-1] < -AUDIBLE_SPEED_M_S) & (rates[1:] >= 0.0)
    )  # fmt: skip
    strikes = []
    for struck, speed in ((falls, (before - after) / step_s), (thrown, -rates[:-1])):
        rows, points = np.nonzero(struck)
        strikes.append(trace.times_s[rows] + before[rows, points] / speed[rows, points])
    lowest = gaps.min(axis=1)
    return _outcome(body, trace, np.concatenate(strikes), lowest, lowest > 0.0)


def of_nodes(body: ifa.Body, trace: Trace) -> Outcome:
    """The outcome of a motion that holds both sides of each impact, at equal times.

    Before an impact a point that has crossed the ground did so its depth over its speed ago.
    """
    gaps, rates = _gaps_and_rates(body, trace)
    impacts = np.append(np.diff(trace.times_s) == 0.0, False)
    size_m = float(np.linalg.norm(body.vertices_m, axis=1).max()) + body.radius_m
    strikes = impacts[:, None] & (gaps <= TOUCH_SHARE * size_m) & (rates < -AUDIBLE_SPEED_M_S)
    rows, points = np.nonzero(strikes)
    since_s = np.minimum(gaps[rows, points], 0.0) / rates[rows, points]
    lowest = gaps.min(axis=1)
    return _outcome(body, trace, trace.times_s[rows] - since_s, lowest, (lowest > 0.0) | impacts)


def first_contacts(strikes_s: Array) -> Array:
    """(CONTACTS,) from the instants of single strikes."""
    strikes_s = np.sort(strikes_s)
    begins = np.ones(len(strikes_s), dtype=bool)
    begins[1:] = np.diff(strikes_s) >= MERGE_GAP_S
    contacts = np.full(CONTACTS, np.inf)
    found = strikes_s[begins][:CONTACTS]
    contacts[: len(found)] = found
    return contacts


def energies(body: ifa.Body, trace: Trace) -> Array:
    """Kinetic and potential energy (n,), J."""
    spins = _in_body_axes(trace.quaternions_wxyz, trace.spins_rad_s)
    kinetic = 0.5 * body.mass_kg * (trace.velocities_m_s**2).sum(axis=1)
    turning = 0.5 * np.einsum("ni,ij,nj->n", spins, body.inertia_kg_m2, spins)
    return kinetic + turning + body.mass_kg * GRAVITY_M_S2 * trace.positions_m[:, 2]


def _outcome(
    body: ifa.Body, trace: Trace, strikes_s: Array, lowest_m: Array, unloaded: np.ndarray
) -> Outcome:
    """The energy is compared at the rows `unloaded` only.

    In the air, or just before an impact: a soft contact is lent energy and gives it back, and a
    step that is pushed out of the ground has lost more in the impact that took it there.
    """
    energy_j = energies(body, trace)
    rise_j = energy_j[unloaded] - np.minimum.accumulate(energy_j[unloaded])
    return Outcome(
        contacts_s=first_contacts(strikes_s),
        energy_gain=float(rise_j.max() / energy_j[0]),
        penetration_m=float(max(0.0, -lowest_m.min())),
        rests=trace.rests,
        failed=trace.failed,
    )


def _gaps_and_rates(body: ifa.Body, trace: Trace) -> tuple[Array, Array]:
    """Heights of the hull's points above the ground, m, and their rates, m/s: (n, vertices)."""
    up = up_in_body_axes(trace.quaternions_wxyz)
    gaps = trace.positions_m[:, 2:] + up @ body.vertices_m.T - body.radius_m
    # up . (w x r) = r . (up x w), all in body axes
    turning = np.cross(up, _in_body_axes(trace.quaternions_wxyz, trace.spins_rad_s))
    return gaps, trace.velocities_m_s[:, 2:] + turning @ body.vertices_m.T


def _in_body_axes(quaternions: Array, vectors: Array) -> Array:
    """World vectors (n, 3) in the axes of bodies at orientations (n, 4) wxyz."""
    w, axis = quaternions[:, :1], -quaternions[:, 1:]
    twice = 2.0 * np.cross(axis, vectors)
    return vectors + w * twice + np.cross(axis, twice)
