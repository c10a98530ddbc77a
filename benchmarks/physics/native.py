"""Engines in libraries with the interface of peer.hpp: Bullet, and the project's own ODE."""

from __future__ import annotations

import ctypes
import time
from pathlib import Path

import ifa
import numpy as np

from .measure import GRAVITY_M_S2, REST_SPAN_S, REST_SPEED_M_S, Outcome, Trace, of_nodes, of_steps
from .starts import Array

MICRO_SPEED_M_S = 0.01  # of the event engine: slower impacts do not bounce
_AT_REST, _FAILED = 1, 2


class _Body(ctypes.Structure):
    _fields_ = (
        ("vertices_m", ctypes.c_void_p),
        ("vertex_count", ctypes.c_int64),
        ("radius_m", ctypes.c_double),
        ("mass_kg", ctypes.c_double),
        ("inertia_kg_m2", ctypes.c_double * 3),
        ("restitution", ctypes.c_double),
        ("friction", ctypes.c_double),
    )


class _Options(ctypes.Structure):
    _fields_ = (
        ("step_s", ctypes.c_double),
        ("until_s", ctypes.c_double),
        ("gravity_m_s2", ctypes.c_double),
        ("micro_speed_m_s", ctypes.c_double),
        ("rest_speed_m_s", ctypes.c_double),
        ("rest_span_s", ctypes.c_double),
        ("skip_flight", ctypes.c_int64),
    )


def load(path: Path) -> ctypes.CDLL:
    """The library of an engine; OSError where it is not built."""
    library = ctypes.CDLL(str(path))
    library.peer_version.restype = ctypes.c_char_p
    library.peer_run.restype = ctypes.c_int64
    return library


def version(library: ctypes.CDLL) -> str:
    return library.peer_version().decode()


class Native:
    """An engine in a library, for one body and step."""

    def __init__(
        self,
        library: ctypes.CDLL,
        body: ifa.Body,
        step_s: float,
        until_s: float,
        keeps_steps: bool,
        skip_flight: bool = False,
    ) -> None:
        moments, axes = np.linalg.eigh(body.inertia_kg_m2)
        axes[:, 0] *= np.sign(np.linalg.det(axes))  # a rotation, not a reflection
        self._library, self._given, self._keeps_steps = library, body, keeps_steps
        self._vertices = np.ascontiguousarray(body.vertices_m @ axes)
        self._body = _Body(
            self._vertices.ctypes.data, len(self._vertices), body.radius_m, body.mass_kg,
            (ctypes.c_double * 3)(*moments), body.restitution, body.friction,
        )  # fmt: skip
        self._options = _Options(
            step_s, until_s, GRAVITY_M_S2, MICRO_SPEED_M_S, REST_SPEED_M_S, REST_SPAN_S, skip_flight
        )
        self._principal = quaternion_of(axes)

    def _run(self, states: ifa.State, trace: Array | None) -> tuple[int, np.ndarray]:
        rows = np.column_stack(
            [
                np.atleast_2d(states.position_m),
                product(np.atleast_2d(states.quaternion_wxyz), self._principal),
                np.atleast_2d(states.velocity_m_s),
                np.atleast_2d(states.angular_velocity_rad_s),
            ]
        )
        ends = np.zeros(len(rows), dtype=np.int8)
        count = self._library.peer_run(
            ctypes.byref(self._body), ctypes.byref(self._options), ctypes.c_int64(len(rows)),
            ctypes.c_void_p(rows.ctypes.data), ctypes.c_void_p(ends.ctypes.data),
            ctypes.c_void_p(None if trace is None else trace.ctypes.data),
            ctypes.c_int64(0 if trace is None else len(trace)),
        )  # fmt: skip
        if count < 0:
            raise RuntimeError(f"the engine refuses the body {self._given.name}")
        return count, ends

    def time(self, states: ifa.State) -> float:
        """CPU seconds for all `states`, each run to rest."""
        begin_s = time.process_time()
        self._run(states, None)
        return time.process_time() - begin_s

    def trace(self, state: ifa.State) -> Trace:
        """The motion from one state, to rest."""
        room = np.empty((2 * int(self._options.until_s / self._options.step_s) + 1000, 14))
        count, ends = self._run(state, room)
        if count > len(room):
            raise RuntimeError(f"a motion of {count} rows, expected at most {len(room)}")
        rows = room[:count]
        return Trace(
            times_s=rows[:, 0],
            positions_m=rows[:, 1:4],
            quaternions_wxyz=product(rows[:, 4:8], self._principal * (1.0, -1.0, -1.0, -1.0)),
            velocities_m_s=rows[:, 8:11],
            spins_rad_s=rows[:, 11:],
            rests=bool(ends[0] == _AT_REST),
            failed=bool(ends[0] == _FAILED),
        )

    def outcome(self, state: ifa.State) -> Outcome:
        """The figures of the motion from one state."""
        measure = of_steps if self._keeps_steps else of_nodes
        return measure(self._given, self.trace(state))


def quaternion_of(rotation: Array) -> Array:
    """The unit quaternion (4,) wxyz of a rotation matrix: an eigenvector (Bar-Itzhack, 2000)."""
    r = rotation
    k = np.array(
        [
            [r[0, 0] + r[1, 1] + r[2, 2], 0, 0, 0],
            [r[2, 1] - r[1, 2], r[0, 0] - r[1, 1] - r[2, 2], 0, 0],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], 0],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    return np.linalg.eigh(k, UPLO="L")[1][:, -1]


def product(p: Array, q: Array) -> Array:
    """Quaternions p (n, 4) times q (4,), Hamilton, wxyz."""
    w, x, y, z = q
    return p @ np.array([[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])
