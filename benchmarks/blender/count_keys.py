"""How many keys motions take, and how far the curves are from them.

IFA_PYTHONPATH=python blender -b --factory-startup --python benchmarks/blender/count_keys.py

Solves a roll of a die, a bounce of a ball and a toss of a coin to marks, makes their keys at 24
frames a second for an origin at the mass centre, and compares what Blender evaluates with the
solver's motion at 64 places a key.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY / "addon"), str(REPOSITORY / "tests" / "blender")]

import ifa_addon  # noqa: E402
from ifa_addon import bake, core, keys  # noqa: E402
from support import evaluate_curves, worst_against  # noqa: E402

FPS = 24.0
SNAPPING_FRAMES = 1.1e-4  # within 1e-4 frames (4 us) of a key Blender shows that key
MARKS_S = {
    "d6": ([0.30, 0.42, 0.48, 0.52], "rest"),
    "ball": ([0.30, 0.65, 0.90, 1.075, 1.20], "open"),
    "coin": ([0.30, 0.50, 0.60, 0.66], "open"),
}
TOLERANCES = {
    "0.05 mm, 0.02 degrees": keys.Tolerance(),
    "0.5 mm, 0.2 degrees": keys.Tolerance(5e-4, float(np.radians(0.2))),
}


def main() -> None:
    ifa = core.load()
    ifa_addon.register()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    timing, place = keys.Timing(FPS, 1.0), keys.Placement(np.zeros(3))
    print("body, tolerance: contacts, keys of location and rotation a second, worst error")
    for name, (marks_s, ending) in MARKS_S.items():
        body = ifa.bodies.get(name, surface="wood")
        marks = ifa.Signature(np.array(marks_s), ending=ending)
        motion = ifa.solve(body, marks, seed=0, time_budget_s=10.0).motion
        length_s = motion.end_s - motion.start_s
        for label, tolerance in TOLERANCES.items():
            made = keys.make_keys(motion, timing, place, tolerance)
            obj = bpy.data.objects.new(name, None)
            scene.collection.objects.link(obj)
            bake.write(scene, [(obj, made)])
            counts = [len(track.frames) for track in (made.location, made.rotation)]
            times = np.linspace(motion.start_s, motion.end_s, 64 * max(counts))
            taken = np.concatenate([made.location.frames, made.rotation.frames])
            near = np.abs(timing.frame(times)[:, None] - taken).min(axis=1) < SNAPPING_FRAMES
            times = times[~near]
            poses = evaluate_curves(obj, timing.frame(times))
            distance, angle_deg = worst_against(motion, place, times, poses)
            print(
                f"{name}, {label}: {len(motion.contact_times_s)} in {length_s:.2f} s, "
                f"{counts[0] / length_s:.1f} and {counts[1] / length_s:.1f} a second, "
                f"{1e3 * distance:.4f} mm and {angle_deg:.4f} degrees",
                flush=True,
            )
    ifa_addon.unregister()


main()
