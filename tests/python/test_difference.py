"""`Motion.difference`, on motions of a solve; the C++ tests have the closed forms."""

from __future__ import annotations

import ifa
import numpy as np
import pytest


def solve(body, seed):
    return ifa.solve(body, ifa.Signature([0.3, 0.41, 0.48], ending="open"), seed=seed, rung=0)


@pytest.fixture(scope="module")
def two():
    body = ifa.bodies.get("d6", surface="wood")
    return [solve(body, seed).motion for seed in (1, 2)]


def rotations(quaternions_wxyz):
    w, x, y, z = quaternions_wxyz.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def test_the_definition_by_brute_force(two):
    a, b = two
    body = ifa.bodies.get("d6", surface="wood")
    times_s = 0.3 + 0.18 * (np.arange(44) + 0.5) / 44  # 240 Hz: 43.2 intervals, so 44
    # a cube's moments are equal: points at +-sqrt(3 l) on any axes, l = I / (2 m)
    second_m2 = body.inertia_kg_m2[0, 0] / (2.0 * body.mass_kg)
    material_m = np.concatenate([np.eye(3), -np.eye(3)]) * np.sqrt(3.0 * second_m2)

    def points(motion):
        positions_m, quaternions = motion.sample(times_s)
        return positions_m[:, None] + material_m @ np.swapaxes(rotations(quaternions), 1, 2)

    pa, pb = points(a), points(b)

    def apart(yaw_rad):
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        away_m = pa - pb @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        away_m[..., :2] -= away_m[..., :2].mean(axis=(0, 1))
        return np.sqrt((away_m**2).sum(axis=-1).mean())

    best = 0.0
    for step in 10.0 ** np.arange(-1, -8, -1):
        best = min(best + step * np.arange(-32, 33), key=apart)
    radius_m = np.linalg.norm(body.vertices_m, axis=1).max() + body.radius_m
    # the least is flat in the turn, so an error of 1e-7 rad counts as 1e-14; the inertia's diagonal
    # is equal to 1e-12
    assert a.difference(b, 0.3, 0.48) == pytest.approx(apart(best) / radius_m, rel=1e-11)


def test_symmetry_and_defaults(two):
    a, b = two
    assert a.difference(a) == 0.0
    first_s, last_s = max(a.start_s, b.start_s), min(a.end_s, b.end_s)
    assert a.difference(b) == a.difference(b, first_s, last_s)
    assert a.difference(b) == pytest.approx(b.difference(a), rel=1e-12)  # rounding of the sums
    assert a.difference(b) > 0.5


def test_bad_arguments(two):
    a, b = two
    with pytest.raises(ifa.IfaValueError, match=r"^other: needs an ifa.Motion$"):
        a.difference(None)
    with pytest.raises(ifa.IfaValueError, match=r"^other: has no time in common"):
        a.difference(b, from_s=100.0)
    with pytest.raises(ifa.IfaValueError, match=r"^to_s: must be finite and after from_s$"):
        a.difference(b, 0.4, 0.3)
    with pytest.raises(ifa.IfaValueError, match=r"^from_s: must be a number"):
        a.difference(b, "0.4")
    with pytest.raises(ifa.IfaValueError, match=r"^from_s: must be finite$"):
        a.difference(b, float("nan"), 1.0)
    with pytest.raises(ifa.IfaValueError, match=r"^other: is a motion of another body$"):
        a.difference(solve(ifa.bodies.get("d8"), 1).motion, 0.3, 0.4)
    softer = ifa.bodies.get("d6", surface="wood").replace(restitution=0.4)
    assert a.difference(solve(softer, 1).motion, 0.3, 0.4) > 0.0
