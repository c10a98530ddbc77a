"""How long keys of many objects take: blender -b --factory-startup --python THIS [-- OBJECTS].

Writes the keys of 500 objects (or OBJECTS) over 240 frames at 24 a second, of 25 motions: as few as
the add-on makes, and one on every frame of every channel. Prints the best of five, by the clock and
of the processor (which other work on the machine does not lengthen as much).
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import bpy
import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY / "addon"), str(REPOSITORY / "tests" / "blender")]

import ifa_addon  # noqa: E402
from ifa_addon import bake, keys, scene  # noqa: E402
from support import BouncingBall, fcurves  # noqa: E402

FRAMES, FPS, ROUNDS, MOTIONS = 240, 24, 5, 25
CENTRE_M = np.array([0.001, 0.0, 0.0])


def motion(number: int) -> BouncingBall:
    """A ball let fall again and again for 10 s, of a spin of its own."""
    ball = BouncingBall(spin_rad_s=20.0 + 0.4 * number, bounces=40, restitution=0.93, start_s=0.0)
    ball.end_s = min(ball.end_s, FRAMES / FPS)
    ball.contact_times_s = ball.contact_times_s[ball.contact_times_s <= ball.end_s]
    return ball


def every_frame(track: keys.Track) -> keys.Track:
    """As many keys as frames: values as they come, which is all the same to the writing."""
    frames = np.arange(1, FRAMES + 1, dtype=np.float32)
    pick = np.linspace(0, len(track.frames) - 1, FRAMES).astype(int)
    values = track.values[pick]
    handle = np.stack([np.broadcast_to(frames[:, None], values.shape), values], axis=-1)
    third = np.array([1 / 3, 0.0])
    return keys.Track(frames, values, handle - third, handle + third, track.is_contact[pick])


def measure(label: str, made: list[keys.Keys]) -> None:
    took = []
    for _ in range(ROUNDS):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        objects = [bpy.data.objects.new(f"body {i}", None) for i in range(len(made))]
        for obj in objects:
            bpy.context.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        begin = time.perf_counter(), time.process_time()
        bake.write(bpy.context.scene, list(zip(objects, made, strict=True)))
        took.append((time.perf_counter() - begin[0], time.process_time() - begin[1]))
    points = sum(len(c.keyframe_points) for obj in objects for c in fcurves(obj))
    actions = len(bpy.data.actions)
    assert actions == len(made), f"{actions} Actions for {len(made)} objects"
    print(
        f"{label}: {len(made)} objects, {points} keyframe points written in "
        f"{min(took)[0]:.2f} s ({min(cpu for _, cpu in took):.2f} s of processor)",
        flush=True,
    )


def main() -> None:
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    count = int(given[0]) if given else 500
    ifa_addon.register()
    target = bpy.context.scene
    target.frame_start, target.render.fps, target.render.fps_base = 1, FPS, 1.0
    place = keys.Placement(CENTRE_M)
    begin = time.perf_counter()
    different = [keys.make_keys(motion(i), scene.timing(target), place) for i in range(MOTIONS)]
    print(f"Blender {bpy.app.version_string}")
    print(f"keys of {MOTIONS} motions made in {time.perf_counter() - begin:.1f} s", flush=True)
    sparse = [different[i % MOTIONS] for i in range(count)]
    measure("as few as needed", sparse)
    dense = [keys.Keys(every_frame(k.location), every_frame(k.rotation)) for k in sparse]
    measure("on every frame", dense)
    ifa_addon.unregister()


main()
