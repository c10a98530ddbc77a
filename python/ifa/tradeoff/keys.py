"""What is exported of a motion: how many keys a second, and how many bits a number."""

from __future__ import annotations

import json
import math
import tempfile
import time
from collections.abc import Callable

import numpy as np

from ifa.solution import Motion
from ifa.tradeoff.curve import Outcome, Scene, Setting, Study

Poses = tuple[np.ndarray, np.ndarray]

_RATES_HZ = (24, 30, 60, 120, 240, 480, 960)
_QUICK_RATES_HZ = (24, 60, 240)
_EXPORT_HZ = 1000.0
_WIDTHS = ("float16", "float32", "float64")
_SAME_POSE_MM = 1e-9  # what making a quaternion unit again may round
_KEY_NUMBERS = 8  # a time, a position and a quaternion


def key_density_position(scene: Scene, *, quick: bool) -> Study:
    """Largest error of the position between keys."""
    return _key_density(scene, "position", "position error between keys, mm", quick)


def key_density_angle(scene: Scene, *, quick: bool) -> Study:
    """Largest error of the orientation between keys."""
    return _key_density(scene, "angle", "angle error between keys, degrees", quick)


def _key_density(scene: Scene, what: str, error_name: str, quick: bool) -> Study:
    motion = scene.solution.motion
    exact_s = _fine_times(motion)

    def setting(rate_hz: float, contacts: bool) -> Callable[[int], Outcome]:
        def run(repeat: int) -> Outcome:
            began_s = time.perf_counter()
            times_s = key_times(motion, rate_hz, contacts=contacts)
            positions_m, quaternions = motion.sample(times_s)
            _write(times_s, positions_m, quaternions)
            time_s = time.perf_counter() - began_s
            middles_s = 0.5 * (times_s[1:] + times_s[:-1])
            probes_s = np.union1d(exact_s, middles_s)
            wrong_mm, wrong_deg = pose_errors(
                between_keys(times_s, (positions_m, quaternions), probes_s), motion.sample(probes_s)
            )
            return Outcome(time_s, float((wrong_mm if what == "position" else wrong_deg).max()))

        return run

    return Study(
        f"key_density_{what}",
        f"Key density: {what}",
        error_name,
        tuple(
            Setting(f"{rate_hz}/s", setting(rate_hz, contacts), series)
            for rate_hz in (_QUICK_RATES_HZ if quick else _RATES_HZ)
            for contacts, series in ((False, "even keys"), (True, "also a key at each contact"))
        ),
        "The largest error of the scene's solved motion, positions and quaternions taken linearly "
        "between keys, at every contact, every half way between keys and a thousand times a "
        "second. The time is that of sampling the motion and writing the keys as JSON.",
    )


def float_width(scene: Scene, *, quick: bool) -> Study:
    """Pose error of the exported motion in double, single and half precision."""
    motion, body = scene.solution.motion, scene.body
    reach_m = body.radius_m + float(np.linalg.norm(body.outline_m, axis=1).max())
    times_s = key_times(motion, _EXPORT_HZ, contacts=True)
    exact = motion.sample(times_s)

    def setting(width: str) -> Callable[[int], Outcome]:
        def run(repeat: int) -> Outcome:
            began_s = time.perf_counter()
            positions_m, quaternions = (part.astype(width) for part in motion.sample(times_s))
            with tempfile.TemporaryFile() as file:
                for part in (times_s.astype(width), positions_m, quaternions):
                    file.write(part.tobytes())
            time_s = time.perf_counter() - began_s
            kept = positions_m.astype(float), _unit(quaternions.astype(float))
            wrong_mm, wrong_deg = pose_errors(kept, exact)
            chord_mm = 2e3 * reach_m * np.sin(0.5 * np.radians(wrong_deg))
            error_mm = float((wrong_mm + chord_mm).max())
            return Outcome(time_s, error_mm if error_mm > _SAME_POSE_MM else 0.0)

        return run

    sizes = ", ".join(f"{width} {_KEY_NUMBERS * np.dtype(width).itemsize}" for width in _WIDTHS)
    return Study(
        "float_width",
        "Float width",
        "pose error, mm",
        tuple(Setting(width, setting(width)) for width in _WIDTHS),
        "How far a point of the body can be from where it should be, at most, at a thousand keys a "
        "second and the contacts. The time is that of sampling the motion and writing the keys as "
        f"bytes; bytes of a key: {sizes}; {len(times_s)} keys.",
    )


def key_times(motion: Motion, rate_hz: float, *, contacts: bool) -> np.ndarray:
    """Times (n,) of even keys from the motion's start to its end, with the contacts if asked for.

    The end has a key even where it lies between two.
    """
    count = math.floor((motion.end_s - motion.start_s) * rate_hz)
    even_s = motion.start_s + np.arange(count + 1) / rate_hz
    extra_s = [motion.end_s]
    if contacts:
        hits_s = motion.contact_times_s
        extra_s = [*hits_s[(hits_s > motion.start_s) & (hits_s < motion.end_s)], motion.end_s]
    return np.union1d(even_s, extra_s)


def between_keys(keys_s: np.ndarray, keys: Poses, times_s: np.ndarray) -> Poses:
    """Poses at times (n,) between keys, as linear curves of positions and quaternions give them."""
    columns = [np.interp(times_s, keys_s, column) for part in keys for column in part.T]
    values = np.stack(columns, axis=1)
    return values[:, :3], _unit(values[:, 3:])


def pose_errors(got: Poses, wanted: Poses) -> tuple[np.ndarray, np.ndarray]:
    """Distances (n,) in mm and angles (n,) in degrees between poses; quaternions must be unit."""
    distances_mm = 1e3 * np.linalg.norm(got[0] - wanted[0], axis=1)
    # By the distance of the quaternions, which an arc cosine of their product would round away.
    apart = np.minimum(
        np.linalg.norm(got[1] - wanted[1], axis=1), np.linalg.norm(got[1] + wanted[1], axis=1)
    )
    return distances_mm, np.degrees(4.0 * np.arcsin(np.minimum(0.5 * apart, 1.0)))


def _fine_times(motion: Motion) -> np.ndarray:
    times_s = motion.times_s
    return times_s[(times_s >= motion.start_s) & (times_s <= motion.end_s)]


def _unit(quaternions: np.ndarray) -> np.ndarray:
    return quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)


def _write(times_s: np.ndarray, positions_m: np.ndarray, quaternions: np.ndarray) -> None:
    """As `Solution.write` does, without the rest of the file."""
    content = {
        "times_s": times_s.tolist(),
        "positions_m": positions_m.tolist(),
        "quaternions_wxyz": quaternions.tolist(),
    }
    with tempfile.TemporaryFile("w", encoding="utf-8") as file:
        file.write(json.dumps(content))
