"""Solving with the real core: from markers to keys, without a window."""

import dataclasses
import hashlib
import threading
import time
import wave
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np
from ifa_addon import bake, core, job, keys, scene
from support import (
    FRAME_RATES,
    POSITION_BOUND_M,
    ROTATION_BOUND_DEG,
    SceneTest,
    add_box,
    add_parent,
    add_sound,
    evaluate_curves,
    evaluate_world,
    fcurves,
    offset_matrix,
    worst_against,
)

SIDE_M = 0.016
MARKS_S = [0.30, 0.42, 0.48, 0.52]  # a simulated 16 mm die's, rounded to 10 ms
MARK_FRAMES = [8, 11, 12, 13]  # about the same
# The third gap needs a rebound from 2.4 m after one that came from 1 cm.
IMPOSSIBLE_MARKS_S = [0.30, 0.34, 0.38, 1.78]
TOUCHING_M = 3e-4  # 0.2 mm of the keys, 0.1 mm of the solver


class SolveTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.ifa = core.load()
        self.obj = add_box(size=(SIDE_M, SIDE_M, SIDE_M), centre=(0.002, 0.0, 0.004))
        self.obj.ifa.place = "WORLD"

    def inputs(self):
        graph = bpy.context.evaluated_depsgraph_get()
        return scene.read_inputs(self.scene, self.obj, graph)

    def curves_digest(self):
        state = hashlib.sha256()
        for curve in fcurves(self.obj):
            for name in ("co", "handle_left", "handle_right"):
                data = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
                curve.keyframe_points.foreach_get(name, data)
                state.update(data.tobytes())
        return state.hexdigest()

    def lowest_vertex_m(self, times_s):
        """Height of the lowest vertex in the evaluated scene: shares no code with the solver."""
        frames = scene.timing(self.scene).frame(times_s)
        origins, rotations = evaluate_world(self.scene, self.obj, frames)
        corners = np.array([v.co for v in self.obj.data.vertices])
        turned = keys.rotate(rotations[:, None, :], corners[None])
        return (turned[..., 2] + origins[:, 2:]).min(axis=1)

    def test_markers_become_keys(self):
        scene.add_marks(self.scene, MARKS_S)
        self.assertEqual(bpy.ops.ifa.solve(), {"FINISHED"})
        own = self.obj.ifa
        self.assertTrue(own.succeeded, own.result)
        self.assertGreaterEqual(own.score, 0.3)
        self.assertLess(own.worst_error_ms, 1.0)
        curve = fcurves(self.obj).find("location", index=2)
        frames = np.array([p.co[0] for p in curve.keyframe_points if p.type == "EXTREME"])
        at = scene.timing(self.scene).time_s(frames)
        for mark in MARKS_S:
            self.assertLess(np.abs(at - mark).min(), 1e-3)
        # Seen in the evaluated scene: in the air between marks, never below the ground.
        first = np.linspace(MARKS_S[0], MARKS_S[1], 60)
        self.assertGreater(self.lowest_vertex_m(first).max(), 2e-3)
        whole = np.linspace(0.1, MARKS_S[-1] + 0.5, 400)
        self.assertGreater(self.lowest_vertex_m(whole).min(), -TOUCHING_M)

    def test_picture_first_keeps_the_marks_and_touches_on_its_frames(self):
        """The markers keep their exact times; what is seen moves to the frames of the rule."""
        scene.add_marks(self.scene, MARKS_S)
        self.obj.ifa.key_times = "PICTURE_FIRST"
        self.assertEqual(bpy.ops.ifa.solve(), {"FINISHED"})
        kept = [scene.stored_time_s(marker) for marker in self.scene.timeline_markers]
        self.assertEqual(kept, MARKS_S)
        for curve in fcurves(self.obj):
            frames = np.array([p.co[0] for p in curve.keyframe_points])
            np.testing.assert_array_equal(frames, np.round(frames))
        timing = scene.timing(self.scene)
        whole = np.arange(1, 40)
        # the earliest frame that is not more than 15 ms before the mark
        shown = [whole[np.argmax(timing.time_s(whole) - mark >= -0.015)] for mark in MARKS_S]
        self.assertLess(np.abs(self.lowest_vertex_m(timing.time_s(shown))).max(), TOUCHING_M)

    def test_touching_at_each_mark(self):
        """At most 1 ms from the mark the lowest vertex is on the ground."""
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        for mark in MARKS_S:
            near = self.lowest_vertex_m(mark + np.linspace(-1e-3, 1e-3, 21))
            self.assertLess(near.min(), TOUCHING_M)

    def test_subframes_follow_the_solver(self):
        scene.add_marks(self.scene, MARKS_S)
        inputs = self.inputs()
        outcome = core.solve(self.ifa, inputs, self.ifa.Progress())
        motion = outcome.solution.motion
        for numerator, denominator in FRAME_RATES:
            self.set_rate(numerator, denominator)
            bake.bake(self.scene, self.obj, motion, outcome.centre_of_mass_m)
            times = np.linspace(motion.start_s, motion.end_s, 700)
            poses = evaluate_curves(self.obj, scene.timing(self.scene).frame(times))
            place = keys.Placement(outcome.centre_of_mass_m)
            distance, angle = worst_against(motion, place, times, poses)
            self.assertLess(distance, POSITION_BOUND_M)
            self.assertLess(angle, ROTATION_BOUND_DEG)
            q = poses[:, 3:]
            self.assertGreaterEqual((q[1:] * q[:-1]).sum(axis=1).min(), 0.0)

    def test_the_centre_of_mass_is_that_of_the_mesh(self):
        scene.add_marks(self.scene, MARKS_S)
        self.obj.scale = (2, 2, 2)
        self.obj.ifa.ending = "OPEN"  # quicker, and the centre does not depend on it
        bpy.context.view_layer.update()
        outcome = core.solve(self.ifa, self.inputs(), self.ifa.Progress())
        np.testing.assert_allclose(outcome.centre_of_mass_m, [0.004, 0.0, 0.008], atol=1e-7)

    def test_inside_a_parent(self):
        """On the ground at the marks, whatever the parent's place, turn and uniform scale."""
        scene.add_marks(self.scene, MARKS_S)
        self.obj.parent = add_parent(scale=2.0)
        self.obj.matrix_parent_inverse = offset_matrix()
        self.obj.scale = (0.5, 0.5, 0.5)
        bpy.context.view_layer.update()
        bpy.ops.ifa.solve()
        for mark in MARKS_S:
            near = self.lowest_vertex_m(mark + np.linspace(-1e-3, 1e-3, 21))
            self.assertLess(near.min(), TOUCHING_M)

    def test_the_same_seed_bakes_the_same_bytes(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        first = self.curves_digest()
        bpy.ops.ifa.solve()
        self.assertEqual(first, self.curves_digest())
        self.assertEqual(len(bpy.data.actions), 1)
        self.obj.ifa.seed = 5
        bpy.ops.ifa.solve()
        self.assertNotEqual(first, self.curves_digest())

    def test_hand_placed_markers_and_a_drag(self):
        self.add_markers(MARK_FRAMES)
        self.obj.ifa.ending = "OPEN"
        bpy.ops.ifa.solve()
        timing = scene.timing(self.scene)
        self.assertFalse(any(m.dragged for m in scene.marks(self.scene, "", timing)))
        self.scene.timeline_markers["hit 2"].frame = 10
        dragged = [m.name for m in scene.marks(self.scene, "", timing) if m.dragged]
        self.assertEqual(dragged, ["hit 2"])
        bpy.ops.ifa.use_frames()
        self.assertFalse(any(m.exact for m in scene.marks(self.scene, "", timing)))

    def test_impossible_marks_are_named(self):
        """The last mark comes 1.4 s after a die's hits died down: the best motion misses it."""
        scene.add_marks(self.scene, IMPOSSIBLE_MARKS_S)
        self.obj.ifa.time_budget_s = 0.5
        bpy.ops.ifa.solve()
        self.assertFalse(self.obj.ifa.succeeded)
        self.assertRegex(self.obj.ifa.result, "No acceptable motion: .*'hit 4'")

    def test_a_failed_solve_names_its_marks(self):
        """A real outcome with its events' errors changed: the sentence names their marks."""
        scene.add_marks(self.scene, MARKS_S)
        outcome = core.solve(self.ifa, self.inputs(), self.ifa.Progress())
        self.assertIn("Solved", core.describe(outcome.solution, outcome.mark_names))
        events = list(outcome.solution.events)
        events[1] = dataclasses.replace(events[1], error_retimed_s=0.0123)
        events[3] = dataclasses.replace(events[3], error_retimed_s=float("nan"))
        failed = dataclasses.replace(outcome.solution, events=events, succeeded=False)
        message = core.describe(failed, outcome.mark_names)
        self.assertRegex(message, r"off at 'hit 2' \(\+12.3 ms\), 'hit 4'")
        self.assertNotIn("'hit 1'", message)
        events = [
            dataclasses.replace(e, retime=1.4) if i == 2 else e
            for i, e in enumerate(outcome.solution.events)
        ]
        failed = dataclasses.replace(outcome.solution, events=events, succeeded=False)
        message = core.describe(failed, outcome.mark_names)
        self.assertRegex(message, r"retiming before 'hit 3' \(\+40 %\)")

    def test_two_marks_on_one_frame_write_nothing(self):
        self.add_markers([10, 10, 30])
        with self.assertRaisesRegex(RuntimeError, "'hit 1'.*'hit 2'.*same time"):
            bpy.ops.ifa.solve()
        self.assertIsNone(self.obj.animation_data)
        self.assertIn("'hit 1'", job.failure)

    def test_a_flat_mesh_is_refused_in_a_sentence(self):
        data = bpy.data.meshes.new("sheet")
        data.from_pydata([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [], [(0, 1, 2)])
        self.obj.data = data
        scene.add_marks(self.scene, MARKS_S)
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.ifa.solve()
        self.assertNotIn("Traceback", str(caught.exception))
        self.assertIsNone(self.obj.animation_data)

    def test_a_sound_gives_amplitudes(self):
        """Clicks whose loudness differs: the factors of amplitude can no longer all be 1."""
        rate = 48000
        samples = np.zeros(rate)
        for mark, level in zip(MARKS_S, (0.9, 0.5, 0.25, 0.2), strict=True):
            k = np.arange(600)
            click = level * np.exp(-k / 100.0) * np.sin(0.4 * k)
            samples[round(mark * rate) : round(mark * rate) + 600] += click
        self.obj.ifa.ending = "OPEN"
        with TemporaryDirectory() as folder:
            path = str(Path(folder) / "clicks.wav")
            with wave.open(path, "wb") as out:
                out.setnchannels(1)
                out.setsampwidth(2)
                out.setframerate(rate)
                out.writeframes((32767 * samples).astype("<i2").tobytes())
            self.scene.ifa.sound_source = "STRIP"
            strip = add_sound(self.scene, "clicks", path, 20)
            scene.add_marks(self.scene, MARKS_S)
            self.assertEqual(bpy.ops.ifa.solve(), {"FINISHED"})
            # The strip's start is time 0: the first contact's key lies after it.
            curve = fcurves(self.obj).find("location", index=2)
            frames = np.array([p.co[0] for p in curve.keyframe_points if p.type == "EXTREME"])
            self.assertLess(np.abs(frames - (20 + 24 * MARKS_S[0])).min(), 0.024)
            strip.sound.pack()
            Path(path).unlink()
            first = self.curves_digest()
            self.assertEqual(bpy.ops.ifa.solve(), {"FINISHED"})
            self.assertEqual(first, self.curves_digest())  # packed or not, the same sound

    def test_a_file_that_is_no_sound(self):
        with TemporaryDirectory() as folder:
            path = Path(folder) / "no sound.wav"
            path.write_bytes(b"not a sound")
            self.scene.ifa.sound_source = "FILE"
            self.scene.ifa.sound_file = str(path)
            scene.add_marks(self.scene, MARKS_S)
            with self.assertRaisesRegex(RuntimeError, "no sound.wav"):
                bpy.ops.ifa.solve()
        self.assertIsNone(self.obj.animation_data)

    def test_marks_from_a_file_keep_their_times(self):
        given = [0.3004567, 0.5500123, 0.6611111]
        with TemporaryDirectory() as folder:
            path = Path(folder) / "labels.txt"
            path.write_text("".join(f"{t:.7f}\t{t:.7f}\thit\n" for t in given))
            self.add_markers([3, 5])
            bpy.ops.ifa.load_marks(filepath=str(path))
        found = scene.checked_marks(self.scene, "", scene.timing(self.scene))
        np.testing.assert_allclose([m.time_s for m in found], given, atol=1e-12)
        self.assertTrue(all(m.exact for m in found))

    def test_fitting_the_material(self):
        scene.add_marks(self.scene, MARKS_S)
        self.obj.ifa.material = "FIT"
        self.assertEqual(bpy.ops.ifa.solve(), {"FINISHED"})
        self.assertTrue(self.obj.ifa.succeeded, self.obj.ifa.result)


class JobTest(SceneTest):
    def test_cancel_ends_the_thread_and_gives_no_result(self):
        ifa = core.load()
        obj = add_box(size=(SIDE_M, SIDE_M, SIDE_M))
        # Late gaps that grow past any energy the first leaves: the search climbs until cancelled.
        scene.add_marks(self.scene, [0.30, 0.34, 0.38, 1.9, 3.9, 3.95, 6.5])
        obj.ifa.time_budget_s = 60.0
        inputs = scene.read_inputs(self.scene, obj, bpy.context.evaluated_depsgraph_get())
        progress = ifa.Progress()
        running = job.start(lambda: core.solve(ifa, inputs, progress), progress, "die")
        self.assertIs(job.running(), running)
        time.sleep(0.2)
        self.assertFalse(running.done)
        running.cancel()
        self.assertIsNone(job.running())
        running.join(10.0)
        self.assertTrue(running.done)
        self.assertIsNone(running.result)
        self.assertIsInstance(running.error, ifa.Cancelled)
        self.assertIsNone(obj.animation_data)
        job.clear(running)

    def test_the_main_thread_goes_on_meanwhile(self):
        ifa = core.load()
        obj = add_box(size=(SIDE_M, SIDE_M, SIDE_M))
        scene.add_marks(self.scene, [0.30, 0.34, 0.38, 1.9, 3.9, 3.95, 6.5])
        inputs = scene.read_inputs(self.scene, obj, bpy.context.evaluated_depsgraph_get())
        progress = ifa.Progress()
        running = job.start(lambda: core.solve(ifa, inputs, progress), progress, "die")
        looks = 0
        while not running.done and looks < 20:
            time.sleep(0.01)
            looks += 1
        self.assertGreaterEqual(looks, 5)  # without the GIL released it would be one long wait
        running.cancel()
        running.join(10.0)
        job.clear(running)

    def test_loading_a_file_cancels(self):
        class Waiting:
            fraction = 0.5

            def __init__(self):
                self.event = threading.Event()

            def cancel(self):
                self.event.set()

        waiting = Waiting()
        running = job.start(waiting.event.wait, waiting, "die")
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        running.join(10.0)
        self.assertTrue(running.done)
        self.assertIsNone(job.current)
