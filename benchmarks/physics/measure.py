"""What is read from a motion, by one measure for all engines: contacts, energy, penetration, rest.

A *contact* is an event of CONVENTIONS.md: hull points that reach the ground faster than 0.05 m/s,
those less than 10 ms after the one before counted with it; its time is the first one's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import ifa

from .starts import Array, up_in_body_axes

GRAVITY_M_S2 = 9.81
AUDIBLE_SPEED_M_S = 0.05
MERGE_GAP_S = 10e-3
REST_SPEED_M_S = 0.01
REST_SPAN_S = 0.05
# Some engines bounce a point back that is still this far above the ground, since it would pass
# through within the step, or to keep a margin.
EARLY_BOUNCE_M = 3e-4
CONTACTS = 4


@dataclass(frozen=True)
class Trace:
    """A motion, one row a step: world axes, quaternions wxyz. `rests`: whether it ended at rest."""

    times_s: Array
    positions_m: Array
    quaternions_wxyz: Array
    velocities_m_s: Array
    spins_rad_s: Array
    rests: bool


@dataclass(frozen=True)
class Outcome:
    """A simulation's figures. contacts_s: the first CONTACTS contacts, inf where there are fewer.

    energy_gain: the largest rise of the energy over its least value before, over the energy at the
    start. penetration_m: of the deepest hull point.
    """

    contacts_s: Array
    energy_gain: float
    penetration_m: float
    rests: bool


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
    w, axis = trace.quaternions_wxyz[:, :1], -trace.quaternions_wxyz[:, 1:]
    twice = 2.0 * np.cross(axis, trace.spins_rad_s)
    spins = trace.spins_rad_s + w * twice + np.cross(axis, twice)  # body axes
    kinetic = 0.5 * body.mass_kg * (trace.velocities_m_s**2).sum(axis=1)
    turning = 0.5 * np.einsum("ni,ij,nj->n", spins, body.inertia_kg_m2, spins)
    return kinetic + turning + body.mass_kg * GRAVITY_M_S2 * trace.positions_m[:, 2]


def energy_gain(energy_j: Array, free: Array) -> float:
    """The largest rise over the least value before, over the first value, of the rows `free`.

    A body in a soft contact has lent energy to it and gets it back: only its energy in the air
    counts.
    """
    kept = energy_j[free]
    if len(kept) == 0:
        return 0.0
    return float((kept - np.minimum.accumulate(kept)).max() / energy_j[0])


def of_stepped(body: ifa.Body, trace: Trace) -> Outcome:
    """The outcome of a motion in fixed steps.

    A point strikes within a step if it crosses the ground, at the instant that its heights at the
    step's ends give by linear interpolation, or if it is thrown back from just above the ground, at
    the instant that it would have got there.
    """
    up = up_in_body_axes(trace.quaternions_wxyz)
    gaps = trace.positions_m[:, 2:] + up @ body.vertices_m.T - body.radius_m
    # of the height of R r, in body axes: (R r)' . up = r . (up x spin)
    w, axis = trace.quaternions_wxyz[:, :1], -trace.quaternions_wxyz[:, 1:]
    twice = 2.0 * np.cross(axis, trace.spins_rad_s)
    spins = trace.spins_rad_s + w * twice + np.cross(axis, twice)
    rates = trace.velocities_m_s[:, 2:] + np.cross(up, spins) @ body.vertices_m.T

    before, after = gaps[:-1], gaps[1:]
    crosses = (before > 0.0) & (after <= 0.0) & (before - after > AUDIBLE_SPEED_M_S * _steps(trace))
    thrown = (
        (before > 0.0) & (before < EARLY_BOUNCE_M) & (after > 0.0)
        & (rates[:-1] < -AUDIBLE_SPEED_M_S) & (rates[1:] >= 0.0)
    )  # fmt: skip
    rows, points = np.nonzero(crosses | thrown)
    hit = crosses[rows, points]
    share = np.where(
        hit,
        before[rows, points]
        / np.where(hit, before[rows, points] - after[rows, points], 1.0)
        * _steps(trace)[rows, 0],
        before[rows, points] / np.maximum(-rates[rows, points], 1e-12),
    )
    lowest = gaps.min(axis=1)
    return Outcome(
        first_contacts(trace.times_s[rows] + share),
        energy_gain(energies(body, trace), lowest > 0.0),
        float(max(0.0, -lowest.min())),
        trace.rests,
    )


def of_run(body: ifa.Body, run: ifa.Run) -> Outcome:
    """The outcome of the event engine, which gives its hits itself."""
    states = run.states
    trace = Trace(
        run.times_s, states.position_m, states.quaternion_wxyz, states.velocity_m_s,
        states.angular_velocity_rad_s, run.status == "rest",
    )  # fmt: skip
    lowest = (
        states.position_m[:, 2]
        + (up_in_body_axes(states.quaternion_wxyz) @ body.vertices_m.T).min(axis=1)
        - body.radius_m
    )
    return Outcome(
        first_contacts(run.hits.time_s[run.hits.approach_speed_m_s > AUDIBLE_SPEED_M_S]),
        energy_gain(energies(body, trace), np.ones(len(lowest), dtype=bool)),
        float(max(0.0, -lowest.min())),
        trace.rests,
    )


def _steps(trace: Trace) -> Array:
    return np.diff(trace.times_s)[:, None]
