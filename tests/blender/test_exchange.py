"""What leaves Blender: a glTF file keeps the motion, a video has sound and picture together."""

import shutil
import subprocess
import unittest
import wave
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np
from ifa_addon import compat, keys, scene
from support import POSITION_BOUND_M, ROTATION_BOUND_DEG, SceneTest, add_box, evaluate_world

MARKS_S = [0.30, 0.42, 0.48, 0.52]  # a simulated 16 mm die's, rounded to 10 ms
SIDE_M = 0.016
SAMPLE_RATE_HZ = 48_000


class GltfTest(SceneTest):
    def test_export_and_import_keep_the_motion(self):
        if not hasattr(bpy.ops.export_scene, "gltf"):
            self.skipTest("this Blender has no glTF exporter")
        scene.add_marks(self.scene, MARKS_S)
        obj = add_box("die", (SIDE_M, SIDE_M, SIDE_M))
        bpy.ops.ifa.solve()
        self.scene.frame_end = 24
        frames = np.arange(1, 25)
        before = evaluate_world(self.scene, obj, frames)
        with TemporaryDirectory() as folder:
            path = str(Path(folder) / "die.glb")
            bpy.ops.export_scene.gltf(filepath=path, export_animations=True)
            bpy.data.objects.remove(obj)
            if not hasattr(np, "bool"):  # 3.4's importer needs it, newer numpy lacks it
                np.bool = bool
                self.addCleanup(delattr, np, "bool")
            bpy.ops.import_scene.gltf(filepath=path)
        back = next(o for o in bpy.data.objects if o.type == "MESH")
        after = evaluate_world(self.scene, back, frames)
        # On the frames, which the exporter samples.
        self.assertLess(np.linalg.norm(before[0] - after[0], axis=1).max(), POSITION_BOUND_M)
        turned = np.degrees(keys.rotation_between(before[1], after[1])).max()
        self.assertLess(turned, ROTATION_BOUND_DEG)


@unittest.skipUnless(shutil.which("ffmpeg"), "needs ffmpeg")
class VideoTest(SceneTest):
    """One click, one mark, one rendered video: read again by a program of its own."""

    FRAMES_PER_S, SIZE, FRAMES = 30, (160, 120), 24
    MARK_FRAME = 12  # the strip begins on frame 1: the contact is seen on frame 12

    def test_onset_and_first_contact_agree(self):
        self.set_rate(self.FRAMES_PER_S, 1)
        mark_s = (self.MARK_FRAME - 1) / self.FRAMES_PER_S
        with TemporaryDirectory() as name:
            folder = Path(name)
            self.write_click(folder / "click.wav", mark_s)
            self.scene.ifa.sound_source = "STRIP"
            editor = self.scene.sequence_editor_create()
            compat.strips_of(editor).new_sound("click", str(folder / "click.wav"), 1, 1)
            scene.add_marks(self.scene, [mark_s])
            obj = add_box("die", (SIDE_M, SIDE_M, SIDE_M))
            obj.ifa.ending = "OPEN"
            bpy.ops.ifa.solve()
            self.assertTrue(obj.ifa.succeeded, obj.ifa.result)
            self.watch_from_the_side(obj)
            video = folder / "out.mp4"
            self.render(video)
            onset_frame = 1 + self.onset_s(video) * self.FRAMES_PER_S
            shown_frame = 1 + self.lowest(video)
        self.assertLess(abs(onset_frame - shown_frame), 0.5)
        self.assertEqual(shown_frame, self.MARK_FRAME)

    def write_click(self, path, at_s):
        samples = np.zeros(SAMPLE_RATE_HZ)
        k = np.arange(800)
        at = round(at_s * SAMPLE_RATE_HZ)
        samples[at : at + 800] = 0.9 * np.exp(-k / 100.0) * np.sin(0.4 * k + 0.5)
        with wave.open(str(path), "wb") as out:
            out.setnchannels(1)
            out.setsampwidth(2)
            out.setframerate(SAMPLE_RATE_HZ)
            out.writeframes((32767 * samples).astype("<i2").tobytes())

    def watch_from_the_side(self, obj):
        """An orthographic camera level with the ground, wide enough for the whole motion."""
        frames = np.arange(1, self.FRAMES + 1)
        places, _ = evaluate_world(self.scene, obj, frames)
        low, high = places.min(axis=0), places.max(axis=0)
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.data.type = "ORTHO"
        camera.data.ortho_scale = float(1.4 * max(np.ptp(places, axis=0).max(), 4 * SIDE_M))
        camera.data.clip_start = 0.001
        camera.location = (*(0.5 * (low + high))[:1], low[1] - 10.0, 0.5 * (low[2] + high[2]))
        camera.rotation_euler = (np.pi / 2, 0.0, 0.0)
        self.scene.collection.objects.link(camera)
        self.scene.camera = camera

    def render(self, path):
        render = self.scene.render
        render.engine = "BLENDER_WORKBENCH"
        shading = self.scene.display.shading
        shading.light, shading.color_type = "FLAT", "SINGLE"
        shading.single_color = (1.0, 1.0, 1.0)
        shading.background_type = "VIEWPORT"
        shading.background_color = (0.0, 0.0, 0.0)
        render.film_transparent = False
        render.resolution_x, render.resolution_y = self.SIZE
        render.resolution_percentage = 100
        self.scene.frame_start, self.scene.frame_end = 1, self.FRAMES
        compat.write_mp4(render, str(path))
        bpy.ops.render.render(animation=True)

    def decode(self, path, *words):
        command = ["ffmpeg", "-v", "error", "-i", str(path), *words, "-"]
        return subprocess.run(command, capture_output=True, check=True, timeout=60).stdout

    def onset_s(self, video):
        """Of the first sample above a tenth of the loudest."""
        raw = self.decode(video, "-f", "s16le", "-ac", "1", "-ar", str(SAMPLE_RATE_HZ))
        loud = np.abs(np.frombuffer(raw, dtype="<i2").astype(float))
        return float(np.argmax(loud > 0.1 * loud.max())) / SAMPLE_RATE_HZ

    def lowest(self, video):
        """The index of the first picture from which the die rises after it came down."""
        width, height = self.SIZE
        raw = self.decode(video, "-f", "rawvideo", "-pix_fmt", "gray")
        pictures = np.frombuffer(raw, dtype=np.uint8).reshape(-1, height, width)
        self.assertEqual(len(pictures), self.FRAMES)
        rows = [np.flatnonzero((p > 128).any(axis=1)).max(initial=-1) for p in pictures]
        steps = np.sign(np.diff(rows))  # rows count downwards
        turns = np.flatnonzero((steps[:-1] > 0) & (steps[1:] < 0))
        self.assertTrue(len(turns), rows)
        return int(turns[0]) + 1
