"""MuJoCo as a peer, set up as its documentation advises for small, freely tumbling bodies.

- Shape: a sphere of the rounding radius at every hull vertex. The lowest point of a rounded hull
  above a plane always lies on one of them, so against the plane this is the rounded hull exactly.
- Restitution: MuJoCo has none; a contact is a damped spring. Its stiffness follows the rule that
  `solref`'s time constant be at least twice the step: natural frequency 1 / (2 step). Its damping
  is found by dropping a ball in MuJoCo itself until it rebounds with e. So the restitution is only
  approximate: it varies with where within a step the contact falls, and a point that touches while
  another is still down meets a different spring.
- Friction: elliptic cones, as advised against slip; `impratio` 10.
- Integrator `implicit`, advised for its gyroscopic stability; the rest is default (Newton solver).
"""

from __future__ import annotations

import functools
import time

import ifa
import mujoco
import numpy as np

from .measure import GRAVITY_M_S2, REST_SPAN_S, REST_SPEED_M_S, Outcome, Trace, of_steps
from .starts import Array

VERSION = f"MuJoCo {mujoco.__version__}"


def _xml(geoms: str, inertial: str, step_s: float, gravity: float, friction: float) -> str:
    return f"""<mujoco>
  <option timestep="{step_s!r}" gravity="0 0 {-gravity!r}" integrator="implicit" cone="elliptic"
          impratio="10"/>
  <default><geom condim="3" friction="{friction!r} 0 0"/></default>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <body><freejoint/>{inertial}{geoms}</body>
  </worldbody>
</mujoco>"""


def _set_spring(model: mujoco.MjModel, step_s: float, damping_ratio: float) -> None:
    frequency = 0.5 / step_s
    model.geom_solref[:] = (-(frequency**2), -2.0 * damping_ratio * frequency)


def rebound(step_s: float, damping_ratio: float) -> Array:
    """Restitution of a ball dropped at 1 m/s, its contact at eight places within a step."""
    model = mujoco.MjModel.from_xml_string(
        _xml('<geom type="sphere" size="0.01" mass="0.01"/>', "", step_s, 0.0, 0.0)
    )
    _set_spring(model, step_s, damping_ratio)
    data = mujoco.MjData(model)
    speeds = []
    for share in (np.arange(8) + 0.5) / 8.0:
        mujoco.mj_resetData(model, data)
        data.qpos[2] = 0.01 + share * step_s
        data.qvel[2] = -1.0
        mujoco.mj_step(model, data, nstep=40)
        speeds.append(float(data.qvel[2]))
    return np.array(speeds)


@functools.cache
def damping_for(restitution: float, step_s: float) -> float:
    """The damping ratio with which a dropped ball rebounds with `restitution` on average."""
    low, high = 0.0, 1.0  # beyond, a step turns the velocity around by itself
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if rebound(step_s, middle).mean() > restitution else (low, middle)
        )
    return 0.5 * (low + high)


class MuJoCo:
    """MuJoCo, for one body and step."""

    def __init__(self, body: ifa.Body, step_s: float, until_s: float) -> None:
        moments = body.inertia_kg_m2
        entries = (*np.diag(moments), moments[0, 1], moments[0, 2], moments[1, 2])
        inertial = (
            f'<inertial pos="0 0 0" mass="{body.mass_kg!r}" '
            f'fullinertia="{" ".join(repr(float(m)) for m in entries)}"/>'
        )
        geoms = "".join(
            f'<geom type="sphere" size="{body.radius_m!r}" '
            f'pos="{" ".join(repr(float(c)) for c in vertex)}"/>'
            for vertex in body.vertices_m
        )
        self._model = mujoco.MjModel.from_xml_string(
            _xml(geoms, inertial, step_s, GRAVITY_M_S2, body.friction)
        )
        _set_spring(self._model, step_s, damping_for(body.restitution, step_s))
        self._data = mujoco.MjData(self._model)
        self._body, self._step_s, self._until_s = body, step_s, until_s
        self._reach_m = float(np.linalg.norm(body.vertices_m, axis=1).max()) + body.radius_m

    def _start(self, state: ifa.State) -> None:
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[:3], self._data.qpos[3:] = state.position_m, state.quaternion_wxyz
        self._data.qvel[:3] = state.velocity_m_s
        # a free joint's angular velocity is in body axes
        inverse = state.quaternion_wxyz * (1.0, -1.0, -1.0, -1.0)
        spin = np.empty(3)
        mujoco.mju_rotVecQuat(spin, state.angular_velocity_rad_s, inverse)
        self._data.qvel[3:] = spin

    def _slow(self) -> bool:
        v = self._data.qvel
        fastest = np.sqrt(v[:3] @ v[:3]) + self._reach_m * np.sqrt(v[3:] @ v[3:])
        return bool(fastest <= REST_SPEED_M_S)

    def time(self, states: ifa.State) -> float:
        """CPU seconds for all `states`, each run to rest.

        Steps within a span of rest are one call, so that Python adds little: two ends in a row
        that are slow are taken for rest.
        """
        chunk = max(1, round(REST_SPAN_S / self._step_s))
        limit = self._until_s / self._step_s
        begin_s = time.process_time()
        for i in range(len(states)):
            self._start(states[i])
            steps, slow = 0, False
            while steps < limit:
                mujoco.mj_step(self._model, self._data, nstep=chunk)
                steps += chunk
                before, slow = slow, self._slow()
                if before and slow:
                    break
        return time.process_time() - begin_s

    def trace(self, state: ifa.State) -> Trace:
        """The motion from one state, to rest."""
        self._start(state)
        data, rows = self._data, []
        slow_steps, rest_steps = 0, REST_SPAN_S / self._step_s
        for _ in range(int(self._until_s / self._step_s) + 1):
            rows.append(np.concatenate([data.qpos, data.qvel]))
            slow_steps = slow_steps + 1 if self._slow() else 0
            if slow_steps > rest_steps:
                break
            mujoco.mj_step(self._model, data)
        table = np.array(rows)
        w, axis = table[:, 3:4], table[:, 4:7]
        twice = 2.0 * np.cross(axis, table[:, 10:])
        return Trace(
            times_s=self._step_s * np.arange(len(table)),
            positions_m=table[:, :3],
            quaternions_wxyz=table[:, 3:7],
            velocities_m_s=table[:, 7:10],
            spins_rad_s=table[:, 10:] + w * twice + np.cross(axis, twice),
            rests=slow_steps > rest_steps,
        )

    def outcome(self, state: ifa.State) -> Outcome:
        """The figures of the motion from one state."""
        return of_steps(self._body, self.trace(state))
