# SPDX-License-Identifier: GPL-3.0-or-later
"""From a solved motion to arrays of Bezier keys. Pure numpy, no bpy.

A Bezier segment whose handles lie at a third of its length along the velocities is the cubic
Hermite interpolant: exact for a parabola, of fourth order for rotation. A key stands on every
contact, with one velocity on each side, and as few others as keep the interpolant within the
tolerances; location and rotation have keys of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from . import retime

LOCATION, ROTATION = slice(0, 3), slice(3, 7)  # among the seven channels
SHORTEST_STEP_S = 4e-4  # refinement ends here: contact chatter has kinks at every scale
_PROBES = 15  # a segment is compared with the motion at this many places at least,
_PROBE_STEP_S = 2e-3  # or this often,
_MARGIN = 0.95  # and held to this share of the tolerance there, for what lies between them
_MANY_PARTS = 8  # as many equal parts of an interval are tried before it is halved as needed


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
    """Frames to seconds: time 0 is at `origin_frame`, where `by_sound` the beginning of a strip."""

    fps: float
    origin_frame: float
    by_sound: bool = False

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
class Tolerance:
    """How far the curves may be from the motion, between keys too."""

    position_m: float = 5e-5  # a quarter of the 0.2 mm that the evaluated motion is held to
    rotation_rad: float = float(np.radians(0.02))  # a fifth of the 0.1 degree


@dataclass(frozen=True)
class Track:
    """k keys of the c channels that share them."""

    frames: np.ndarray  # (k,) float32, strictly increasing
    values: np.ndarray  # (k, c)
    left: np.ndarray  # (k, c, 2) frame and value of the left handle
    right: np.ndarray  # (k, c, 2)
    is_contact: np.ndarray  # (k,) bool


@dataclass(frozen=True)
class Keys:
    location: Track  # x y z
    rotation: Track  # w x y z of rotation_quaternion
    notes: tuple[str, ...] = ()  # sentences for the user


@dataclass(frozen=True)
class Grid:
    """Where keys may stand: float32 frames, as Blender stores them, or whole ones."""

    timing: Timing
    shortest_s: float
    whole: bool = False

    def snap(self, times_s: np.ndarray) -> np.ndarray:
        frames = self.timing.frame(times_s)
        frames = np.round(frames) if self.whole else frames.astype(np.float32)
        return self.timing.time_s(frames)

    def room(self, length_s: np.ndarray) -> np.ndarray:
        """How many segments fit into `length_s`."""
        return np.floor(length_s / self.shortest_s * (1 + 1e-9))


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


def make_keys(
    motion: Motion,
    timing: Timing,
    place: Placement,
    tolerance: Tolerance | None = None,
    key_times: str = "SUBFRAME",
) -> Keys:
    """Keys for the whole motion, as few as keep the curves within `tolerance` (default: its own).

    `key_times` "SUBFRAME" puts each contact on its fractional frame; "FRAME" and "PICTURE_FIRST"
    put all keys on whole frames, the contacts by the rules of retime.py. There the tolerance holds
    on frames always, between them where one frame's motion allows it. Raises ValueError if the
    motion holds a NaN or an infinity.
    """
    tolerance = tolerance or Tolerance()
    notes: tuple[str, ...] = ()
    if key_times == "SUBFRAME":
        spacing_s = _frame_spacing(timing, np.array([motion.start_s, motion.end_s]))
        grid = Grid(timing, max(SHORTEST_STEP_S, 4 * spacing_s))
    else:
        motion = retime.on_frames(motion, timing, key_times)
        notes = motion.notes
        grid = Grid(timing, 1.0 / timing.fps, whole=True)
    fixed, is_contact = _fixed_times(motion, timing)
    tracks = []
    # Blender units, in parent space: a tolerance in metres shrinks with both scales.
    scale = np.abs(np.linalg.det(place.unparent[:3, :3])) ** (1 / 3) / place.metres_per_unit
    for channels, allowed in (
        (LOCATION, tolerance.position_m * scale),
        (ROTATION, tolerance.rotation_rad),
    ):
        error = _Error(motion, place, channels, allowed)
        times = divide(fixed, grid, error.is_beyond)
        contact = np.isin(times, fixed[is_contact])
        tracks.append(_track(error, times, contact, grid))
    return Keys(tracks[0], tracks[1], notes)


def _frame_spacing(timing: Timing, times: np.ndarray) -> float:
    """Seconds between neighbouring float32 frame numbers at the motion's end."""
    return float(np.spacing(np.float32(np.abs(timing.frame(times[[0, -1]])).max()))) / timing.fps


def _fixed_times(motion: Motion, timing: Timing) -> tuple[np.ndarray, np.ndarray]:
    """Contacts and both ends, at float32-distinct frames; and which are contacts."""
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
    ends = [t for t in (start, end) if not len(contacts) or np.abs(contacts - t).min() > gap]
    times = np.unique(np.concatenate([contacts, ends]))
    return times, np.isin(times, contacts)


def divide(
    fixed: np.ndarray, grid: Grid, is_beyond: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Times (k,) of the keys: the fixed ones and what divides the segments between them.

    `is_beyond(begin, end)` (m,) tells which segments leave the tolerance. Each interval is cut
    into the fewest equal parts of which none does, which suits flights, or where that takes fewer
    in halves as often as needed, which suits contact. Then neighbours that are good as one are
    joined.
    """
    begin, end = fixed[:-1], fixed[1:]
    found = [fixed]

    def cut(parts: int, tried: np.ndarray) -> np.ndarray:
        """Keep the equal parts of those of the intervals `tried` that they suit; the others."""
        given, tried = tried, tried[(grid.room(end - begin)[tried] >= parts) | (parts == 1)]
        knots = begin[tried, None] + np.arange(parts + 1) / parts * (end - begin)[tried, None]
        knots[:, -1] = end[tried]
        knots[:, 1:-1] = grid.snap(knots[:, 1:-1])
        off = is_beyond(knots[:, :-1].ravel(), knots[:, 1:].ravel()).reshape(-1, parts)
        good = ~off.any(axis=1)
        found.append(knots[good, 1:-1].ravel())
        return np.setdiff1d(given, tried[good])

    left_over = np.arange(len(begin))
    for parts in range(1, _MANY_PARTS + 1):
        left_over = cut(parts, left_over)
    halves = np.sort(_halve(begin[left_over], end[left_over], grid, is_beyond))
    counts = np.searchsorted(halves, end) - np.searchsorted(halves, begin) + 1
    while (counts[left_over] > parts).any():
        parts = int(np.ceil(1.2 * parts))
        fewer = counts[left_over] > parts
        left_over = np.union1d(left_over[~fewer], cut(parts, left_over[fewer]))
    halved = np.searchsorted(begin, halves, side="right") - 1
    found.append(halves[np.isin(halved, left_over)])
    return _join(np.unique(np.concatenate(found)), fixed, is_beyond)


def _halve(begin, end, grid: Grid, is_beyond) -> np.ndarray:
    """Times that halve segments until none is beyond or they are as short as keys may be."""
    found = [begin[:0]]
    while len(begin):
        split = is_beyond(begin, end) & (grid.room(end - begin) >= 2)
        begin, end = begin[split], end[split]
        middle = grid.snap((begin + end) / 2)
        found.append(middle)
        begin, end = np.concatenate([begin, middle]), np.concatenate([middle, end])
    return np.concatenate(found)


def _join(times: np.ndarray, fixed: np.ndarray, is_beyond) -> np.ndarray:
    """`times` without those that are not needed: not fixed, and good as one what they divide."""
    is_fixed = np.isin(times, fixed)
    untried = ~is_fixed
    while untried.any():
        # Of neighbouring times only one is tried at once: each try counts on both neighbours.
        tried = np.flatnonzero(untried)
        run = np.cumsum(np.diff(tried, prepend=-2) > 1)
        tried = tried[(np.arange(len(tried)) - np.searchsorted(run, run)) % 2 == 0]
        untried[tried] = False
        gone = tried[~is_beyond(times[tried - 1], times[tried + 1])]
        untried[gone - 1] = ~is_fixed[gone - 1]
        untried[gone + 1] = ~is_fixed[gone + 1]
        times, is_fixed, untried = (np.delete(a, gone) for a in (times, is_fixed, untried))
    return times


class _Error:
    """What the Hermite interpolant of one group of channels makes of the motion."""

    def __init__(self, motion: Motion, place: Placement, channels: slice, allowed: float) -> None:
        self.motion, self.place, self.channels, self.allowed = motion, place, channels, allowed

    def poses(self, times: np.ndarray) -> np.ndarray:
        return poses(self.motion, times, self.place)[:, self.channels]

    def rates(self, times: np.ndarray, side: str) -> np.ndarray:
        return rates(self.motion, times, side, self.place)[:, self.channels]

    def is_beyond(self, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
        """(m,) bool: the segment from begin to end (m,) leaves the tolerance at a probe."""
        if not len(begin):
            return np.zeros(0, dtype=bool)
        step = end - begin
        start, stop = self.poses(begin), self.poses(end)
        slope0, slope1 = self.rates(begin, "right"), self.rates(end, "left")
        if self.channels == ROTATION:
            sign = np.where((start * stop).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
            stop, slope1 = sign * stop, sign * slope1
        slope0, slope1 = slope0 * step[:, None], slope1 * step[:, None]
        count = np.maximum(np.ceil(step / _PROBE_STEP_S), _PROBES).astype(int)
        first = np.cumsum(count) - count
        i = np.repeat(np.arange(len(count)), count)
        share = (np.arange(len(i)) - first[i] + 0.5) / count[i]
        truth = self.poses(begin[i] + share * step[i])
        u = share[:, None]
        curve = (
            (1 + 2 * u) * (1 - u) ** 2 * start[i]
            + u * (1 - u) ** 2 * slope0[i]
            + u**2 * (3 - 2 * u) * stop[i]
            - u**2 * (1 - u) * slope1[i]
        )
        if self.channels == ROTATION:
            off = rotation_between(curve, truth)
        else:
            off = np.linalg.norm(curve - truth, axis=1)
        # A NaN is beyond nothing here; the finished keys are checked for it.
        return np.maximum.reduceat(off, first) > _MARGIN * self.allowed


def rotation_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle in rad between the rotations of quaternions (..., 4), which need not be unit."""
    a = a / np.linalg.norm(a, axis=-1, keepdims=True)
    b = b / np.linalg.norm(b, axis=-1, keepdims=True)
    chord = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return 4.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))


def _track(error: _Error, times: np.ndarray, is_contact: np.ndarray, grid: Grid) -> Track:
    """The keys at `times` (k,)."""
    frames = grid.timing.frame(times)
    frames = (np.round(frames) if grid.whole else frames).astype(np.float32)
    values = error.poses(times)
    before, after = error.rates(times, "left"), error.rates(times, "right")
    if error.channels == ROTATION:
        turning = 2.0 * np.maximum(
            np.linalg.norm(after[:-1], axis=1), np.linalg.norm(before[1:], axis=1)
        )
        sign = _continuous_signs(values)
        values, before, after = sign * values, sign * before, sign * after
        # Whole frames can be too few to tell which way it turns: the shorter way, evenly.
        step = np.diff(times)
        blind = turning * step > np.pi
        evenly = np.diff(values, axis=0) / step[:, None]
        after[:-1][blind] = evenly[blind]
        before[1:][blind] = evenly[blind]
    before[0] = 0.0  # at rest in the air before the motion begins, and on the ground after it
    after[-1] = 0.0
    left, right = _handles(frames, values, before, after, grid.timing.fps)
    if not all(np.isfinite(array).all() for array in (frames, values, left, right)):
        raise ValueError("The motion holds a number that is not finite; nothing was keyed.")
    return Track(frames, values, left, right, is_contact)


def _continuous_signs(q: np.ndarray) -> np.ndarray:
    """(k, 1) of +-1 that make neighbouring quaternions' dot products >= 0."""
    flips = np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    return np.concatenate([[1.0], np.cumprod(flips)])[:, None]


def _handles(
    frames: np.ndarray, values: np.ndarray, before: np.ndarray, after: np.ndarray, fps: float
) -> tuple[np.ndarray, np.ndarray]:
    """Left and right handles (k, c, 2), a third of the way to the neighbour along the slopes."""
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
