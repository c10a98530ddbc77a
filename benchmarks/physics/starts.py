"""The initial states that every engine gets: the paper's sampling (section 5.1), lifted off.

A state of the paper begins in contact. Here it is then flown backwards, so that the first contact
is one that the engines have to find, too. How long is random: a lead that all steps divide would
put the first contact on a step's end, and flatter every stepped engine.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import ifa

Array = NDArray[np.float64]

CONE_RAD = np.radians(30.0)
SPEED_M_S = (0.5, 4.0)
SPIN_RAD_S = (0.0, 20.0)
LEAD_S = (0.03, 0.07)
LEAD_GRID_S = 1e-3


def in_contact(body: ifa.Body, count: int, seed: int) -> ifa.State:
    """`count` states that touch the ground with their lowest point and move down."""
    random = np.random.Generator(np.random.Philox(seed))
    quaternions = random.normal(size=(count, 4))  # uniform over the rotations once normalised
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    # Cosine-weighted: sin^2 of the angle to the vertical is uniform.
    sine = np.sin(CONE_RAD) * np.sqrt(random.random(count))
    azimuth = 2.0 * np.pi * random.random(count)
    direction = np.column_stack(
        [sine * np.cos(azimuth), sine * np.sin(azimuth), -np.sqrt(1.0 - sine**2)]
    )
    axis = random.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    lowest = (body.vertices_m @ up_in_body_axes(quaternions).T).min(axis=0)
    positions = np.zeros((count, 3))
    positions[:, 2] = body.radius_m - lowest
    return ifa.State(
        positions,
        quaternions,
        direction * random.uniform(*SPEED_M_S, (count, 1)),
        axis * random.uniform(*SPIN_RAD_S, (count, 1)),
    )


def lifted(body: ifa.Body, count: int, seed: int) -> ifa.State:
    """States of `in_contact`, flown back by LEAD_S or to just after an earlier contact.

    A state that is below the ground at once when flown back (it leaves the ground rather than
    reaching it) is passed over for the next one.
    """
    random = np.random.Generator(np.random.Philox([seed, 1]))
    touching = in_contact(body, 2 * count, seed)
    leads_s = random.uniform(*LEAD_S, 2 * count)
    rows: list[ifa.State] = []
    for i in range(2 * count):
        back_s = -np.append(np.arange(LEAD_GRID_S, leads_s[i], LEAD_GRID_S), leads_s[i])
        flown = ifa.fly(body, touching[i], back_s)
        below = np.flatnonzero(clearance(body, flown) <= 0.0)
        last = below[0] - 1 if below.size else len(back_s) - 1
        if last >= 0:
            rows.append(flown[last])
        if len(rows) == count:
            break
    return ifa.State(
        *(
            np.array([getattr(row, field) for row in rows])
            for field in (
                "position_m", "quaternion_wxyz", "velocity_m_s", "angular_velocity_rad_s",
            )
        )
    )  # fmt: skip


def up_in_body_axes(quaternions: Array) -> Array:
    """The ground's normal in the axes of bodies at orientations (n, 4) wxyz: (n, 3)."""
    w, x, y, z = quaternions.T
    return np.column_stack(
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)]
    )


def clearance(body: ifa.Body, states: ifa.State) -> Array:
    """Height (n,) of the lowest hull point above the ground, m."""
    lowest = (body.vertices_m @ up_in_body_axes(states.quaternion_wxyz).T).min(axis=0)
    return states.position_m[:, 2] + lowest - body.radius_m
