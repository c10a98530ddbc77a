# SPDX-License-Identifier: GPL-3.0-or-later
"""From a solved motion to arrays of Bezier keys. Pure numpy, no bpy.

A Bezier segment whose handles lie at a third of its length along the velocities is the cubic
Hermite interpolant: exact for a parabola, of fourth order for rotation. Keys stand on every
frame, on every contact (at its fractional frame, with one velocity on each side), and wherever
the interpolant would otherwise leave the motion by more than the tolerances.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

POSITION_TOLERANCE_M = 5e-5  # a quarter of the 0.2 mm that the evaluated motion is held to
ROTATION_TOLERANCE_RAD = np.radians(0.02)  # a fifth of the 0.1 degree
TURN_PER_KEY_RAD = 0.8  # above pi the rotation aliases; here its Hermite error is 0.01 degree
SHORTEST_STEP_S = 4e-4  # refinement ends here: contact chatter has kinks at every scale
NEAR_CONTACT_FRAMES = 0.02  # a frame key this close to a contact gives way to the contact's key
_PROBES = np.array([0.125, 0.25, 0.5, 0.75, 0.875])  # where a segment is compared with the motion


class Motion(Protocol):
    """The part of ifa.Motion that keys are made from."""

    start_s: float
    end_s: float
    contact_times_s: np.ndarray

    def sample(self, times_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]: ...

    def sample_velocity(
        self, times_s: np.ndarray, side: str = "right"
    ) -> tuple[np.ndarray, np.ndarray]: ...


@dataclass(frozen=True)
class Timing:
    """Frames to seconds: time 0 is at `origin_frame`."""

    fps: float
    origin_frame: float

    def time_s(self, frame):
        return (np.asarray(frame, dtype=np.float64) - self.origin_frame) / self.fps

    def frame(self, time_s):
        return self.origin_frame + np.asarray(time_s, dtype=np.float64) * self.fps


@dataclass(frozen=True)
class Placement:
    """Takes the solver's world (metres) to the object's own channels (Blender units)."""

    centre_of_mass_m: np.ndarray  # (3,), in the object's axes with its world scale
    metres_per_unit: float = 1.0
    shift_m: np.ndarray = field(default_factory=lambda: np.zeros(3))  # added to world positions
    unparent: np.ndarray = field(default_factory=lambda: np.eye(4))  # world to parent space
    unturn_wxyz: np.ndarray = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    delta_location: np.ndarray = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Keys:
    """k keys of seven channels: location x y z, rotation_quaternion w x y z."""

    frames: np.ndarray  # (k,) float32, strictly increasing
    values: np.ndarray  # (k, 7)
    left: np.ndarray  # (k, 7, 2) frame and value of the left handle
    right: np.ndarray  # (k, 7, 2)
    is_contact: np.ndarray  # (k,) bool


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Quaternion product of wxyz arrays (..., 4)."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def rotate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Vectors v (..., 3) turned by unit quaternions q (..., 4)."""
    axis = q[..., 1:]
    twice = 2.0 * np.cross(axis, v)
    return v + q[..., :1] * twice + np.cross(axis, twice)


def poses(motion: Motion, times_s: np.ndarray, place: Placement) -> np.ndarray:
    """Channels (n, 7) at `times_s`, each row's quaternion with the sign the motion gives it."""
    position, q = motion.sample(times_s)
    origin = position - rotate(q, place.centre_of_mass_m) + place.shift_m
    return _to_channels(origin, q, place)


def _to_channels(origin_m: np.ndarray, q: np.ndarray, place: Placement) -> np.ndarray:
    inward = place.unparent[:3, :3]
    location = origin_m / place.metres_per_unit @ inward.T + place.unparent[:3, 3]
    return np.hstack([location - place.delta_location, multiply(place.unturn_wxyz, q)])


def rates(motion: Motion, times_s: np.ndarray, side: str, place: Placement) -> np.ndarray:
    """Time derivatives (n, 7) of the channels, 1/s, before or after each instant."""
    _, q = motion.sample(times_s)
    velocity, omega = motion.sample_velocity(times_s, side=side)
    velocity = velocity - np.cross(omega, rotate(q, place.centre_of_mass_m))
    location = velocity / place.metres_per_unit @ place.unparent[:3, :3].T
    spin = np.hstack([np.zeros((len(omega), 1)), omega])
    return np.hstack([location, multiply(place.unturn_wxyz, 0.5 * multiply(spin, q))])


def make_keys(motion: Motion, timing: Timing, place: Placement) -> Keys:
    """Keys for the whole motion. Raises ValueError if the motion holds a NaN or an infinity."""
    times, is_contact = _base_times(motion, timing)
    times, is_contact = _limit_turn(motion, timing, times, is_contact)
    while True:
        bad = _segments_off(motion, times, place)
        bad &= np.diff(times) > max(2 * SHORTEST_STEP_S, 4 * _frame_spacing(timing, times))
        if not bad.any():
            break
        times, is_contact = _split(timing, times, is_contact, np.where(bad, 2, 1))

    frames = timing.frame(times).astype(np.float32)
    values = poses(motion, times, place)
    sign = _continuous_signs(values[:, 3:])
    values[:, 3:] *= sign
    before, after = rates(motion, times, "left", place), rates(motion, times, "right", place)
    before[:, 3:] *= sign
    after[:, 3:] *= sign
    before[0] = 0.0  # at rest in the air before the motion begins, and on the ground after it
    after[-1] = 0.0
    left, right = _handles(frames, values, before, after, timing.fps)
    if not all(np.isfinite(array).all() for array in (frames, values, left, right)):
        raise ValueError("The motion holds a number that is not finite; nothing was keyed.")
    return Keys(frames, values, left, right, is_contact)


def _frame_spacing(timing: Timing, times: np.ndarray) -> float:
    """Seconds between neighbouring float32 frame numbers at the motion's end."""
    return float(np.spacing(np.float32(np.abs(timing.frame(times[[0, -1]])).max()))) / timing.fps


def _on_frames(timing: Timing, times: np.ndarray) -> np.ndarray:
    """Times of the float32 frame numbers that Blender will store."""
    return timing.time_s(timing.frame(times).astype(np.float32))


def _base_times(motion: Motion, timing: Timing) -> tuple[np.ndarray, np.ndarray]:
    """Contacts, whole frames and both ends, at float32-distinct frames."""
    start, end = float(motion.start_s), float(motion.end_s)
    contacts = np.unique(np.asarray(motion.contact_times_s, dtype=np.float64))
    contacts = contacts[(contacts >= start) & (contacts <= end)]
    # Contacts that Blender could not tell apart become one key.
    gap = 4 * _frame_spacing(timing, np.array([start, end]))
    kept: list[float] = []
    for time in contacts:
        if not kept or time - kept[-1] > gap:
            kept.append(time)
    contacts = np.array(kept)

    near = NEAR_CONTACT_FRAMES / timing.fps
    ends = [t for t in (start, end) if not len(contacts) or np.abs(contacts - t).min() > gap]
    first, last = np.ceil(timing.frame(start)), np.floor(timing.frame(end))
    grid = timing.time_s(np.arange(first, last + 1))
    fixed = np.sort(np.concatenate([contacts, ends]))
    nearest = np.clip(np.searchsorted(fixed, grid), 1, max(len(fixed) - 1, 1))
    distance = np.minimum(np.abs(grid - fixed[nearest - 1]), np.abs(grid - fixed[nearest]))
    times = np.concatenate([fixed, grid[distance > near]])
    order = np.argsort(times, kind="stable")
    return times[order], np.isin(times, contacts)[order]


def _split(
    timing: Timing, times: np.ndarray, is_contact: np.ndarray, parts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Divide segment i into parts[i] equal ones (as nearly as float32 frames allow)."""
    index = np.repeat(np.arange(len(parts)), parts)
    within = np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)
    new = times[index] + within / parts[index] * np.diff(times)[index]
    new = np.where(within > 0, _on_frames(timing, new), new)
    return np.append(new, times[-1]), np.append((within == 0) & is_contact[index], is_contact[-1])


def _limit_turn(
    motion: Motion, timing: Timing, times: np.ndarray, is_contact: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """No segment turns by more than TURN_PER_KEY_RAD (nor is shorter than float32 frames allow)."""
    after = np.linalg.norm(motion.sample_velocity(times[:-1], side="right")[1], axis=1)
    before = np.linalg.norm(motion.sample_velocity(times[1:], side="left")[1], axis=1)
    step = np.diff(times)
    parts = np.ceil(step * np.maximum(after, before) / TURN_PER_KEY_RAD - 1e-9)
    most = np.floor(step / (4 * _frame_spacing(timing, times)))
    return _split(timing, times, is_contact, np.maximum(np.minimum(parts, most), 1).astype(int))


def _segments_off(motion: Motion, times: np.ndarray, place: Placement) -> np.ndarray:
    """(k - 1,) bool: the Hermite interpolant of the segment leaves the tolerances at a probe."""
    step = np.diff(times)[:, None, None]
    u = _PROBES[None, :, None]
    start, end = poses(motion, times[:-1], place), poses(motion, times[1:], place)
    slope0 = rates(motion, times[:-1], "right", place)
    slope1 = rates(motion, times[1:], "left", place)
    sign = np.where((start[:, 3:] * end[:, 3:]).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    end[:, 3:] *= sign
    slope1[:, 3:] *= sign
    start, end, slope0, slope1 = (a[:, None, :] for a in (start, end, slope0, slope1))
    curve = (
        (1 + 2 * u) * (1 - u) ** 2 * start
        + u * (1 - u) ** 2 * step * slope0
        + u**2 * (3 - 2 * u) * end
        - u**2 * (1 - u) * step * slope1
    )
    probes = (times[:-1, None] + _PROBES * np.diff(times)[:, None]).ravel()
    truth = poses(motion, probes, place).reshape(curve.shape)
    # Blender units, in parent space: a tolerance in metres shrinks with both scales.
    scale = np.abs(np.linalg.det(place.unparent[:3, :3])) ** (1 / 3) / place.metres_per_unit
    moved = np.linalg.norm(curve[..., :3] - truth[..., :3], axis=-1)
    turned = rotation_between(curve[..., 3:], truth[..., 3:])
    off = (moved > POSITION_TOLERANCE_M * scale) | (turned > ROTATION_TOLERANCE_RAD)
    return off.any(axis=1)


def rotation_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle in rad between the rotations of quaternions (..., 4), which need not be unit."""
    a = a / np.linalg.norm(a, axis=-1, keepdims=True)
    b = b / np.linalg.norm(b, axis=-1, keepdims=True)
    chord = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return 4.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))


def _continuous_signs(q: np.ndarray) -> np.ndarray:
    """(k, 1) of +-1 that make neighbouring quaternions' dot products >= 0."""
    flips = np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    return np.concatenate([[1.0], np.cumprod(flips)])[:, None]


def _handles(
    frames: np.ndarray, values: np.ndarray, before: np.ndarray, after: np.ndarray, fps: float
) -> tuple[np.ndarray, np.ndarray]:
    """Left and right handles (k, 7, 2), a third of the way to the neighbour along the slopes."""
    x = frames.astype(np.float64)
    third = np.diff(x) / 3.0 if len(x) > 1 else np.array([1.0])
    # Slopes are taken at the handle's float32 position, or rounding would tilt them.
    left_x = (x - np.concatenate([third[:1], third])[: len(x)]).astype(np.float32)
    right_x = (x + np.concatenate([third, third[-1:]])[: len(x)]).astype(np.float32)
    left = np.empty((*values.shape, 2))
    right = np.empty((*values.shape, 2))
    left[..., 0] = left_x[:, None]
    right[..., 0] = right_x[:, None]
    left[..., 1] = values + before * ((left_x - x) / fps)[:, None]
    right[..., 1] = values + after * ((right_x - x) / fps)[:, None]
    return left, right
