# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender for first_light.py: the motion, its sound and its marks as a .blend.

    blender -b --python examples/first_light_blend.py -- FOLDER

Reads motion.json and roll.wav in FOLDER and writes first_light.blend beside them, with the add-on's
own code for markers and keys.
"""

from __future__ import annotations

import json
import sys
from math import ceil, cos, pi, sin
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "addon"))

import bpy
import ifa_addon
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from ifa_addon import compat, core, results, scene, writing
from mathutils import Vector

FRAMES_PER_S = 60
EDGE = 0.1  # of the picture, that the die's centre stays clear of
# The pips of a die by the face's outward axis; opposite faces add up to seven.
PIPS = {
    (0, 0, 1): 1, (0, 0, -1): 6, (1, 0, 0): 2, (-1, 0, 0): 5, (0, 1, 0): 3, (0, -1, 0): 4,
}  # fmt: skip
PLACES = {
    1: [(0, 0)],
    2: [(-1, -1), (1, 1)],
    3: [(-1, -1), (0, 0), (1, 1)],
    4: [(-1, -1), (-1, 1), (1, -1), (1, 1)],
    5: [(-1, -1), (-1, 1), (0, 0), (1, -1), (1, 1)],
    6: [(-1, -1), (-1, 0), (-1, 1), (1, -1), (1, 0), (1, 1)],
}


def material(name: str, colour: tuple[float, float, float]) -> bpy.types.Material:
    made = bpy.data.materials.new(name)
    made.diffuse_color = (*colour, 1.0)
    made.use_nodes = True
    made.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*colour, 1.0)
    return made


def add_mesh(name, corners, faces, colour, parent=None):
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    data.materials.append(material(name, colour))
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    made.parent = parent
    return made


def add_die(body) -> bpy.types.Object:
    """A cube with the body's rounding, and pips that go with it."""
    half = float(body.vertices_m.max()) + body.radius_m
    signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    die = add_mesh("die", [tuple(half * s for s in c) for c in signs], faces, (0.8, 0.75, 0.62))
    bevel = die.modifiers.new("rounding", "BEVEL")
    bevel.width, bevel.segments = body.radius_m, 3
    corners, rings = [], []
    for axis, count in PIPS.items():
        normal = Vector(axis)
        u = normal.orthogonal().normalized()
        v = normal.cross(u)
        for a, b in PLACES[count]:
            centre = 1.005 * half * normal + 0.5 * half * (a * u + b * v)
            angles = [2 * pi * k / 20 for k in range(20)]
            rings.append(range(len(corners), len(corners) + len(angles)))
            corners += [centre + 0.16 * half * (cos(t) * u + sin(t) * v) for t in angles]
    add_mesh("pips", corners, [tuple(ring) for ring in rings], (0.02, 0.02, 0.03), parent=die)
    return die


def in_view(camera, places: np.ndarray) -> bool:
    """Whether all places (n, 3) lie in the picture, clear of its edges."""
    for place in places:
        x, y, z = world_to_camera_view(bpy.context.scene, camera, Vector(place))
        if not (z > 0.0 and EDGE < x < 1.0 - EDGE and EDGE < y < 1.0 - EDGE):
            return False
    return True


def add_stage(travel: np.ndarray) -> None:
    """Table, light, and a camera that sees the whole travel (n, 3)."""
    low, high = travel.min(axis=0), travel.max(axis=0)
    middle, reach = Vector(0.5 * (low + high)), float(np.ptp(travel, axis=0).max()) + 0.05
    wide = 20.0 * reach
    table = [(x, y, 0.0) for x, y in ((-wide, -wide), (wide, -wide), (wide, wide), (-wide, wide))]
    add_mesh("table", table, [(0, 1, 2, 3)], (0.32, 0.19, 0.1))
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3.0, (0.7, 0.2, 0.5)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.clip_start, camera.data.lens = 0.001, 50.0
    for made in (sun, camera):
        bpy.context.scene.collection.objects.link(made)
    bpy.context.scene.camera = camera
    direction = Vector((0.12, -0.95, 0.3))
    camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
    away = 0.5 * reach
    while not in_view(camera, travel):  # from far enough to see it all the way
        away *= 1.05
        camera.location = middle + away * direction
        bpy.context.view_layer.update()
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    space.clip_start = 0.001
                    space.region_3d.view_perspective = "CAMERA"


def main() -> None:
    folder = Path(sys.argv[sys.argv.index("--") + 1]).resolve()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    ifa_addon.register()
    ifa = core.load()
    written = json.loads((folder / "motion.json").read_text(encoding="utf-8"))
    body = ifa.Body.from_dict(written["body"])
    marks = ifa.Signature.from_dict(written["marks"])
    # seed and rung reproduce the motion exactly
    solution = ifa.solve(body, marks, seed=written["seed"], rung=written["rung"])
    motion = solution.motion

    target = bpy.context.scene
    target.render.fps, target.render.fps_base = FRAMES_PER_S, 1.0
    sound_frame = 1 + ceil(max(0.0, -motion.start_s) * FRAMES_PER_S)
    target.frame_start = 1
    target.frame_end = sound_frame + ceil(motion.end_s * FRAMES_PER_S)
    target.sync_mode = "AUDIO_SYNC"
    editor = target.sequence_editor_create()
    compat.strips_of(editor).new_sound("roll", str(folder / "roll.wav"), 1, sound_frame)
    target.ifa.sound_source = "STRIP"

    die = add_die(body)
    bpy.context.view_layer.objects.active = die
    die.select_set(True)
    die.ifa.seed, die.ifa.restitution = solution.seed, body.restitution
    die.ifa.friction = body.friction
    bpy.context.view_layer.update()
    scene.add_marks(target, [float(t) for t in marks.times_s])
    inputs = scene.read_inputs(target, die, bpy.context.evaluated_depsgraph_get())
    outcome = core.Outcome(solution, np.zeros(3), inputs.mark_names)
    writing.write(bpy.context, die, results.Kept(inputs, outcome))

    frames = range(target.frame_start, target.frame_end + 1)
    travel = []
    for frame in frames:
        target.frame_set(frame)
        travel.append(tuple(die.matrix_world.translation))
    add_stage(np.array(travel))
    target.frame_set(target.frame_start)
    path = folder / "first_light.blend"
    bpy.context.preferences.filepaths.save_version = 0  # no .blend1 beside it
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    bpy.ops.file.make_paths_relative()
    bpy.ops.wm.save_mainfile()


main()
