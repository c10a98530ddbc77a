"""From the click on Solve to the keys, for rolls of 15 marks.

IFA_PYTHONPATH=python blender -b --factory-startup --python benchmarks/blender/solve_roll.py

Each roll is what is heard of a simulated throw of a 16 mm die that comes to rest after its 15th
event. Prints for each quality the seconds of `bpy.ops.ifa.solve()`, which reads the scene, solves
and keys, beside the error of the motion.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "tests" / "blender")]

import bpy  # noqa: E402
import ifa_addon  # noqa: E402
from ifa_addon import core, scene  # noqa: E402
from support import add_box  # noqa: E402

MARKS, ROLLS, SEED = 15, 8, 0
SIDE_M = 0.016


def rolls(ifa) -> list[tuple[float, ...]]:
    """The marks of the first throws of SEED that are heard MARKS times."""
    body = ifa.Body.box((SIDE_M,) * 3, mass_kg=1200.0 * SIDE_M**3)
    found: list[tuple[float, ...]] = []
    first = 0
    while len(found) < ROLLS:
        states = ifa.sample_states(body, 100, seed=SEED, first=first)
        first += 100
        for row in range(100):
            run = ifa.simulate(body, states[row], until_s=20.0)
            if run.status != "rest" or not (run.hits.approach_speed_m_s >= 0.05).any():
                continue
            marks = ifa.Signature.from_run(run)
            if len(marks) == MARKS and marks.ending == "rest":
                found.append(tuple(float(t) + 0.3 for t in marks.times_s))
    return found[:ROLLS]


def main() -> None:
    ifa = core.load()
    ifa_addon.register()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    obj = add_box("die", (SIDE_M,) * 3)
    print(f"{ROLLS} rolls of {MARKS} marks, Blender {bpy.app.version_string}")
    given = rolls(ifa)
    for accuracy in ("DRAFT", "GOOD", "BEST"):
        obj.ifa.accuracy = accuracy
        took_s, errors, plausible = [], [], 0
        for times_s in given:
            bpy.context.scene.timeline_markers.clear()
            scene.add_marks(bpy.context.scene, times_s)
            began_s = time.perf_counter()
            bpy.ops.ifa.solve()
            took_s.append(time.perf_counter() - began_s)
            errors.append(obj.ifa.error)
            plausible += obj.ifa.plausible
        print(
            f"{accuracy:6} {statistics.median(took_s):6.2f} s ({max(took_s):.2f} s at most), "
            f"error {statistics.median(errors):.3f}, plausible {plausible} of {ROLLS}"
        )
    ifa_addon.unregister()


main()
