"""The initial states that every engine gets: the paper's sampling (section 5.1), lifted off.

A state of the paper begins in contact. Here it is then flown backwards, so that the first contact
is one that the engines have to find, too. For how long is random: a lead that all steps divide
would put the first contact on the end of a step, which flatters every stepped engine.
"""

from __future__ import annotations

import ifa
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAD_S = (0.03, 0.07)
GRID_S = 1e-3


def lifted(body: ifa.Body, count: int, seed: int) -> ifa.State:
    """`count` states in the air: those of `ifa.sample_states`, flown back by LEAD_S.

    Where that would meet an earlier contact, to just after it. A state that is below the ground at
    once when flown back, since its spin takes the touching point up, is passed over for the next.
    """
    random = np.random.Generator(np.random.Philox(seed))
    rows: list[ifa.State] = []
    first = 0
    while len(rows) < count:
        touching = ifa.sample_states(body, count, seed, first)
        first += count
        for i, lead_s in enumerate(random.uniform(*LEAD_S, count)):
            back_s = -np.append(np.arange(GRID_S, lead_s, GRID_S), lead_s)
            flown = ifa.fly(body, touching[i], back_s)
            below = np.flatnonzero(clearance(body, flown) <= 0.0)
            last = int(below[0]) - 1 if below.size else len(back_s) - 1
            if last >= 0:
                rows.append(flown[last])
    del rows[count:]
    return ifa.State(
        np.array([row.position_m for row in rows]),
        np.array([row.quaternion_wxyz for row in rows]),
        np.array([row.velocity_m_s for row in rows]),
        np.array([row.angular_velocity_rad_s for row in rows]),
    )


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
