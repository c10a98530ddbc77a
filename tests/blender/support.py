"""Closed-form motions and scene helpers of the Blender tests."""

from __future__ import annotations

import unittest

import bpy
import numpy as np
from ifa_addon import compat, keys
from mathutils import Matrix, Quaternion

GRAVITY_M_S2 = 9.81
POSITION_BOUND_M = 2e-4  # what a demanding user accepts between keys and motion
ROTATION_BOUND_DEG = 0.1
FRAME_RATES = [(24000, 1001), (24, 1), (30000, 1001), (60, 1)]  # as fps, fps_base = 24, 1.001 ...


class BouncingBall:
    """A spinning ball dropped on z = 0: parabolas and constant spins, in closed form.

    Each bounce keeps `restitution` of the speed and changes the spin. Written from the textbook
    formulas alone, so that keys can be compared with something that shares no code with them.
    """

    def __init__(self, spin_rad_s=25.0, bounces=5, restitution=0.7, start_s=-0.2, fall_s=0.35):
        self.start_s = start_s
        speed = GRAVITY_M_S2 * fall_s
        segments = [(start_s, fall_s, 0.0)]  # begin, length, vertical speed at the beginning
        time = start_s + fall_s
        for _ in range(bounces):
            speed *= restitution
            segments.append((time, 2 * speed / GRAVITY_M_S2, speed))
            time += segments[-1][1]
        self.end_s = time
        self.begin = np.array([s[0] for s in segments])
        self.contact_times_s = self.begin[1:].copy()
        rise = np.array([s[2] for s in segments])
        height = np.zeros(len(segments))
        height[0] = 0.5 * GRAVITY_M_S2 * fall_s**2
        turns = np.random.default_rng(7).normal(size=(len(segments), 3))
        self.spin = spin_rad_s * turns / np.linalg.norm(turns, axis=1, keepdims=True)
        drift = 0.4 * self.restitution_powers(restitution, len(segments))
        self.velocity = np.column_stack([drift, -0.5 * drift, rise])
        self.position = np.zeros((len(segments), 3))
        self.turn = [np.array([1.0, 0.0, 0.0, 0.0])]
        for i, length in enumerate(np.diff(self.begin)):
            self.position[i + 1] = self.position[i] + self.velocity[i] * length
            self.turn.append(keys.multiply(self._turned(self.spin[i], length), self.turn[i]))
        self.position[:, 2] = height

    @staticmethod
    def restitution_powers(restitution, count):
        return restitution ** np.arange(count)

    @staticmethod
    def _turned(spin, length_s):
        speed = np.linalg.norm(spin, axis=-1, keepdims=True)
        axis = spin / np.maximum(speed, 1e-300)
        half = speed * length_s / 2
        return np.concatenate([np.cos(half), np.sin(half) * axis], axis=-1)

    def _segment(self, times, side):
        found = np.searchsorted(self.begin, times, side=side) - 1
        return np.clip(found, 0, len(self.begin) - 1)

    def sample(self, times_s):
        times = np.atleast_1d(np.asarray(times_s, dtype=float))
        times = np.clip(times, self.start_s, self.end_s)
        i = self._segment(times, "right")
        t = (times - self.begin[i])[:, None]
        fall = np.array([0.0, 0.0, 0.5 * GRAVITY_M_S2])
        position = self.position[i] + self.velocity[i] * t - fall * t**2
        return position, keys.multiply(self._turned(self.spin[i], t), np.array(self.turn)[i])

    def sample_velocity(self, times_s, side="right"):
        times = np.atleast_1d(np.asarray(times_s, dtype=float))
        i = self._segment(times, side)
        t = (times - self.begin[i])[:, None]
        return self.velocity[i] - np.array([0.0, 0.0, GRAVITY_M_S2]) * t, self.spin[i]


def worst_against(motion, place, times, poses):
    """Largest distance (Blender units) and angle (degrees) between poses (n, 7) and the motion."""
    truth = keys.poses(motion, times, place)
    distance = np.linalg.norm(poses[:, :3] - truth[:, :3], axis=1).max()
    return distance, np.degrees(keys.rotation_between(poses[:, 3:], truth[:, 3:]).max())


def fcurves(obj):
    return compat.fcurves(obj.animation_data.action, obj)


def evaluate_curves(obj, frames):
    """(n, 7) of the object's own channels, by Blender's evaluation of its F-curves."""
    curves = fcurves(obj)
    paths = [("location", i) for i in range(3)] + [("rotation_quaternion", i) for i in range(4)]
    found = [curves.find(path, index=i) for path, i in paths]
    return np.array([[curve.evaluate(float(f)) for curve in found] for f in frames])


def evaluate_world(scene, obj, frames):
    """Origins (n, 3) and rotations (n, 4) in the world, by setting the scene to each frame."""
    origins, rotations = [], []
    for frame in frames:
        whole = int(np.floor(frame))
        scene.frame_set(whole, subframe=float(frame - whole))
        graph = bpy.context.evaluated_depsgraph_get()
        matrix = obj.evaluated_get(graph).matrix_world
        origins.append(matrix.translation[:])
        rotations.append(matrix.to_quaternion()[:])
    return np.array(origins), np.array(rotations)


def add_box(name="die", size=(0.016, 0.016, 0.016), centre=(0.0, 0.0, 0.0)):
    """A box mesh object, the active one, whose volume's centre is at `centre` from its origin."""
    half = np.array(size) / 2
    corners = [
        np.array(centre) + half * np.array([x, y, z])
        for x in (-1, 1)
        for y in (-1, 1)
        for z in (-1, 1)
    ]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(c) for c in corners], [], faces)
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.context.view_layer.update()
    return obj


def add_sound(scene, name, path, frame):
    """A sound strip that begins at `frame`; the collection was renamed in Blender 4.4."""
    editor = scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    return strips.new_sound(name, path, 1, frame)


def set_first(owner, names, value):
    """Set the first of the properties that `owner` has: some were renamed in Blender 5.1."""
    setattr(owner, next(name for name in names if hasattr(owner, name)), value)


def rotation_deg(a, b):
    return np.degrees(keys.rotation_between(np.asarray(a), np.asarray(b)))


def add_parent(scale=2.0):
    parent = bpy.data.objects.new("parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.location = (0.3, -1.2, 0.7)
    parent.rotation_mode = "QUATERNION"
    parent.rotation_quaternion = Quaternion((1, 2, 3), 0.9)
    parent.scale = (scale, scale, scale)
    bpy.context.view_layer.update()
    return parent


def offset_matrix():
    return Matrix.Translation((0.1, 0.2, -0.3)) @ Quaternion((1, 1, 0), 0.4).to_matrix().to_4x4()


class SceneTest(unittest.TestCase):
    """An empty scene with the add-on enabled."""

    def setUp(self):
        import ifa_addon

        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        ifa_addon.register()
        self.addCleanup(ifa_addon.unregister)
        self.scene = bpy.context.scene
        self.scene.frame_start = 1
        self.scene.render.fps, self.scene.render.fps_base = 24, 1.0

    def set_rate(self, numerator, denominator):
        """24000/1001 is set as fps 24, fps_base 1.001, as Blender's presets do."""
        if denominator == 1001:
            self.scene.render.fps = round(numerator / 1000)
            self.scene.render.fps_base = 1.001
        else:
            self.scene.render.fps, self.scene.render.fps_base = numerator, 1.0

    def add_markers(self, frames, prefix="hit"):
        for i, frame in enumerate(frames, 1):
            self.scene.timeline_markers.new(f"{prefix} {i}", frame=frame)
