"""Bullet as a peer, through the library that bullet_peer.cpp makes; see there how it is set up."""

from __future__ import annotations

import ctypes
import time
from pathlib import Path

import numpy as np

import ifa

from .measure import REST_SPAN_S, REST_SPEED_M_S, Trace
from .starts import Array

MICRO_SPEED_M_S = 0.01  # ifa::SimulationOptions


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
    _fields_ = tuple(
        (name, ctypes.c_double)
        for name in (
            "step_s", "until_s", "gravity_m_s2", "micro_speed_m_s", "rest_speed_m_s", "rest_span_s",
        )
    )  # fmt: skip


def load(path: Path) -> ctypes.CDLL:
    """The library; OSError where it is not built."""
    library = ctypes.CDLL(str(path))
    library.bullet_run.restype = ctypes.c_int64
    return library


def version(library: ctypes.CDLL) -> str:
    number = library.bullet_version()
    return f"Bullet {number // 100}.{number % 100}, double precision"


class Bullet:
    """Engine `bullet`."""

    name = "bullet"

    def __init__(
        self, library: ctypes.CDLL, body: ifa.Body, step_s: float, until_s: float, gravity: float
    ) -> None:
        moments, self._axes = np.linalg.eigh(body.inertia_kg_m2)
        self._axes[:, 0] *= np.sign(np.linalg.det(self._axes))  # a rotation, not a reflection
        self._library = library
        self._vertices = np.ascontiguousarray(body.vertices_m @ self._axes)
        self._body = _Body(
            self._vertices.ctypes.data, len(self._vertices), body.radius_m, body.mass_kg,
            (ctypes.c_double * 3)(*moments), body.restitution, body.friction,
        )  # fmt: skip
        self._options = _Options(
            step_s, until_s, gravity, MICRO_SPEED_M_S, REST_SPEED_M_S, REST_SPAN_S
        )
        self._principal = _quaternion(self._axes)

    def _run(self, states: ifa.State, trace: Array | None) -> tuple[int, Array]:
        rows = np.column_stack(
            [
                np.atleast_2d(states.position_m),
                _product(np.atleast_2d(states.quaternion_wxyz), self._principal),
                np.atleast_2d(states.velocity_m_s),
                np.atleast_2d(states.angular_velocity_rad_s),
            ]
        )
        rests = np.zeros(len(rows), dtype=bool)
        steps = self._library.bullet_run(
            ctypes.byref(self._body), ctypes.byref(self._options), ctypes.c_int64(len(rows)),
            ctypes.c_void_p(rows.ctypes.data), ctypes.c_void_p(rests.ctypes.data),
            ctypes.c_void_p(None if trace is None else trace.ctypes.data),
            ctypes.c_int64(0 if trace is None else len(trace)),
        )  # fmt: skip
        return steps, rests

    def time(self, states: ifa.State) -> float:
        """CPU seconds for all `states`, each run to rest."""
        begin_s = time.process_time()
        self._run(states, None)
        return time.process_time() - begin_s

    def trace(self, state: ifa.State) -> Trace:
        """The motion from one state, to rest."""
        step_s = self._options.step_s
        room = np.empty((int(self._options.until_s / step_s) + 1, 13))
        steps, rests = self._run(state, room)
        rows = room[: steps + 1]
        back = self._principal * (1.0, -1.0, -1.0, -1.0)
        return Trace(
            times_s=step_s * np.arange(len(rows)),
            positions_m=rows[:, :3],
            quaternions_wxyz=_product(rows[:, 3:7], back),
            velocities_m_s=rows[:, 7:10],
            spins_rad_s=rows[:, 10:],
            rests=bool(rests[0]),
        )


def _quaternion(rotation: Array) -> Array:
    """The unit quaternion (4,) wxyz of a rotation matrix, by the eigenvector of Bar-Itzhack."""
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


def _product(p: Array, q: Array) -> Array:
    """Quaternions p (n, 4) times q (4,), Hamilton, wxyz."""
    w, x, y, z = q
    right = np.array([[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])
    return p @ right
