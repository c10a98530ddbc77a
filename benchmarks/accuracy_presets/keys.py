"""What the tolerances of keys cost: how many keys the add-on makes of solved motions, how fast."""

from __future__ import annotations

import argparse
import importlib
import math
import statistics
import sys
import time
from pathlib import Path
from types import ModuleType

import ifa

from benchmarks.physics.report import Row
from benchmarks.solve.kinds import KINDS

_FPS = 24.0
_ADDON = Path(__file__).resolve().parents[2] / "addon" / "ifa_addon"
_OTHERS = ((1e-3, math.radians(0.5)), (2e-6, math.radians(0.001)))


def rows(options: argparse.Namespace) -> list[Row]:
    """Keys of location and of rotation for each second of motion, and ms to make them: medians."""
    keys = _addon_keys()
    motions = []
    for case in KINDS["simulated"].make(options.shared, options.limit):
        solution = ifa.solve(case.body, case.marks, rung=0, seed=options.seed)
        motions.append((solution.motion, case.body))
    tolerances = {
        (preset.key_position_m, preset.key_angle_rad): name
        for name, preset in ifa.ACCURACIES.items()
    }
    tolerances |= {each: "" for each in _OTHERS if each not in tolerances}
    out: list[Row] = []
    for (position_m, angle_rad), name in sorted(tolerances.items(), reverse=True):
        tolerance = keys.Tolerance(position_m, angle_rad)
        per_s, ms = [], []
        for motion, body in motions:
            place = keys.Placement(centre_of_mass_m=body.centre_of_mass_m)
            begin_s = time.process_time()
            made = keys.make_keys(motion, keys.Timing(_FPS, 1.0), place, tolerance)
            ms.append(1e3 * (time.process_time() - begin_s))
            count = len(made.location.frames) + len(made.rotation.frames)
            per_s.append(count / (motion.end_s - motion.start_s))
        out.append(
            {
                "preset": name,
                "position_mm": 1e3 * position_m,
                "angle_deg": math.degrees(angle_rad),
                "motions": len(motions),
                "keys_per_s": statistics.median(per_s),
                "time_ms": statistics.median(ms),
            }
        )
    return out


def line(row: Row) -> str:
    return (
        f"{row['preset']:6} {row['position_mm']:8.3g} mm {row['angle_deg']:8.3g} degrees: "
        f"{row['keys_per_s']:6.1f} keys/s, {row['time_ms']:6.2f} ms"
    )


def _addon_keys() -> ModuleType:
    """The add-on's maker of keys, which needs no Blender: its package without what that does."""
    package = ModuleType("ifa_addon_keys")
    package.__path__ = [str(_ADDON)]
    sys.modules[package.__name__] = package
    return importlib.import_module(f"{package.__name__}.keys")
