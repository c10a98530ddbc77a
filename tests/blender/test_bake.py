"""Keys in Blender against the closed-form motion they were made from."""

import bpy
import numpy as np
from ifa_addon import bake, keys, retime, scene
from mathutils import Euler, Quaternion
from support import (
    FRAME_RATES,
    POSITION_BOUND_M,
    ROTATION_BOUND_DEG,
    BouncingBall,
    SceneTest,
    add_box,
    add_parent,
    evaluate_curves,
    evaluate_world,
    fcurves,
    offset_matrix,
    rotation_deg,
    worst_against,
)

CENTRE = np.array([0.003, -0.002, 0.001])


def curve_bytes(obj):
    """Path, index, keys and handles of each curve, by path and index."""
    out = []
    for curve in sorted(fcurves(obj), key=lambda c: (c.data_path, c.array_index)):
        out += [curve.data_path, curve.array_index]
        for name in ("co", "handle_left", "handle_right"):
            data = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
            curve.keyframe_points.foreach_get(name, data)
            out.append(data.tobytes())
    return out


class BakeTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.motion = BouncingBall(spin_rad_s=45.0)
        self.obj = add_box()
        self.obj.ifa.place = "WORLD"

    def subframes(self, count=500):
        times = np.linspace(self.motion.start_s, self.motion.end_s, count)
        return scene.timing(self.scene).frame(times)

    def check_world(self, obj, centre_m=CENTRE, unit_m=1.0, shift=(0, 0, 0)):
        """Origin and rotation in the world against x - R c and q of the motion."""
        frames = self.subframes(160)
        origins, rotations = evaluate_world(self.scene, obj, frames)
        position, q = self.motion.sample(scene.timing(self.scene).time_s(frames))
        truth = position - keys.rotate(q, centre_m) + np.array(shift)
        self.assertLess(np.abs(origins * unit_m - truth).max(), POSITION_BOUND_M)
        self.assertLess(rotation_deg(rotations, q).max(), ROTATION_BOUND_DEG)

    def test_subframes_at_every_rate(self):
        for numerator, denominator in FRAME_RATES:
            self.set_rate(numerator, denominator)
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
            frames = self.subframes()
            times = scene.timing(self.scene).time_s(frames)
            poses = evaluate_curves(self.obj, frames)
            distance, angle = worst_against(self.motion, keys.Placement(CENTRE), times, poses)
            self.assertLess(distance, POSITION_BOUND_M)
            self.assertLess(angle, ROTATION_BOUND_DEG)

    def test_contacts_are_where_the_evaluated_curve_turns(self):
        """The lowest points of the evaluated height, found by a fine scan: within 1 ms."""
        for numerator, denominator in FRAME_RATES:
            self.set_rate(numerator, denominator)
            bake.bake(self.scene, self.obj, self.motion, np.zeros(3))
            timing = scene.timing(self.scene)
            curve = fcurves(self.obj).find("location", index=2)
            for contact in self.motion.contact_times_s:
                times = contact + np.arange(-0.02, 0.02, 1e-4)
                heights = [curve.evaluate(f) for f in timing.frame(times)]
                self.assertLess(abs(times[np.argmin(heights)] - contact), 1e-3)

    def test_keys_in_the_curves(self):
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        curves = fcurves(self.obj)
        self.assertEqual(len(curves), 7)
        contacts = scene.timing(self.scene).frame(self.motion.contact_times_s)
        for curve in curves:
            frames = np.array([p.co[0] for p in curve.keyframe_points])
            self.assertGreater(np.diff(frames).min(), 0.0)
            for contact in contacts:
                # float32 frame numbers below 128 are 7.6e-6 apart
                self.assertLess(np.abs(frames - contact).min(), 1e-5)
            for point in curve.keyframe_points:
                self.assertEqual(point.handle_left_type, "FREE")
                self.assertEqual(point.handle_right_type, "FREE")
                self.assertEqual(point.interpolation, "BEZIER")
            types = {
                p.type for p in curve.keyframe_points if np.abs(contacts - p.co[0]).min() < 0.001
            }
            self.assertEqual(types, {"EXTREME"})
        self.assertEqual(self.obj.rotation_mode, "QUATERNION")

    def test_world_pose(self):
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.check_world(self.obj)

    def test_parent_and_deltas(self):
        self.obj.parent = add_parent(scale=2.0)
        self.obj.matrix_parent_inverse = offset_matrix()
        self.obj.delta_location = (0.3, -0.4, 0.5)
        self.obj.delta_rotation_quaternion = Quaternion((0, 1, 1), 1.1)
        self.obj.scale = (0.5, 0.5, 0.5)
        bpy.context.view_layer.update()
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.check_world(self.obj)

    def test_scene_units(self):
        for scale in (0.01, 1.0):
            self.scene.unit_settings.scale_length = scale
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
            self.check_world(self.obj, unit_m=self.scene.unit_settings.scale_length)

    def test_delta_euler_goes_on_as_a_quaternion(self):
        """An Euler mode has a delta rotation of its own, which quaternion mode would drop."""
        for mode in ("XYZ", "ZXY"):
            self.obj.rotation_mode = mode
            self.obj.delta_rotation_euler = Euler((0.7, -0.4, 1.3), mode)
            self.obj.delta_scale = (1.5, 1.5, 1.5)
            bpy.context.view_layer.update()
            kept = self.obj.matrix_world.to_quaternion()  # the object's own rotation is none
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
            self.assertLess(rotation_deg(self.obj.delta_rotation_quaternion, kept), 1e-3)  # float32
            self.check_world(self.obj)
            # With the delta taken off, the object turns by its inverse less.
            frame = float(self.subframes(3)[1])
            _, with_delta = evaluate_world(self.scene, self.obj, [frame])
            self.obj.delta_rotation_quaternion = (1, 0, 0, 0)
            _, without = evaluate_world(self.scene, self.obj, [frame])
            turned = keys.multiply(np.array(kept), without[0])
            self.assertLess(rotation_deg(turned, with_delta[0]), 1e-3)  # float32
            bake.clear(self.obj)
            self.assertEqual(self.obj.rotation_mode, mode)
            self.assertEqual(tuple(self.obj.delta_rotation_quaternion), (1, 0, 0, 0))
            np.testing.assert_allclose(self.obj.delta_rotation_euler, (0.7, -0.4, 1.3), rtol=1e-6)

    def test_deltas_in_each_rotation_mode(self):
        for mode in ("QUATERNION", "XYZ", "AXIS_ANGLE"):
            self.obj.rotation_mode = mode
            self.obj.delta_location = (0.3, -0.4, 0.5)
            self.obj.delta_rotation_quaternion = Quaternion((0, 1, 1), 1.1)
            self.obj.delta_rotation_euler = (0.2, 0.3, 0.4)
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
            self.check_world(self.obj)
            bake.clear(self.obj)

    def test_whole_frames_in_blender(self):
        """The evaluated height is least on the frames that the rule names, and only there."""
        for numerator, denominator in FRAME_RATES:
            self.set_rate(numerator, denominator)
            timing = scene.timing(self.scene)
            for name, rule in retime.RULES.items():
                self.obj.ifa.key_times = name
                bake.bake(self.scene, self.obj, self.motion, np.zeros(3))
                curve = fcurves(self.obj).find("location", index=2)
                frames = np.array([p.co[0] for p in curve.keyframe_points])
                np.testing.assert_array_equal(frames, np.round(frames))
                for at in rule(timing.frame(self.motion.contact_times_s), timing.fps):
                    heights = [curve.evaluate(at + d) for d in (-1, -0.1, 0, 0.1, 1)]
                    self.assertEqual(np.argmin(heights), 2)
                    self.assertLess(abs(heights[2]), POSITION_BOUND_M)

    def test_tolerances_of_the_object(self):
        counts = []
        for position_mm, rotation_deg_ in ((0.01, 0.005), (0.05, 0.02), (1.0, 1.0)):
            self.obj.ifa.position_tolerance_mm = position_mm
            self.obj.ifa.rotation_tolerance_deg = rotation_deg_
            made = bake.bake(self.scene, self.obj, self.motion, CENTRE)
            frames = self.subframes(2000)
            times = scene.timing(self.scene).time_s(frames)
            poses = evaluate_curves(self.obj, frames)
            distance, angle = worst_against(self.motion, keys.Placement(CENTRE), times, poses)
            # beside float32: of frames, 4e-6 of them at 4 m/s and 45 rad/s, and of Blender's
            # evaluation, which solves for a place along the segment to about 1e-6 of it
            self.assertLess(1e3 * distance, position_mm + 0.004)
            self.assertLess(angle, rotation_deg_ + 0.003)
            counts.append((len(made.location.frames), len(made.rotation.frames)))
        self.assertEqual(counts, sorted(counts, reverse=True))
        self.assertGreater(counts[0][1], 2 * counts[2][1])

    def test_place_at_the_object(self):
        self.obj.ifa.place = "OBJECT"
        self.obj.location = (3.0, 4.0, 0.5)
        for _ in range(2):  # a rebake lands on the same place
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
            touch, _ = self.motion.sample(self.motion.contact_times_s[:1])
            self.check_world(self.obj, shift=(3.0 - touch[0, 0], 4.0 - touch[0, 1], 0.0))

    def test_sheared_parent_writes_nothing(self):
        self.obj.parent = add_parent()
        self.obj.parent.scale = (1, 2, 1)
        bpy.context.view_layer.update()
        with self.assertRaisesRegex(scene.SceneError, "non-uniform"):
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.assertIsNone(self.obj.animation_data)
        self.assertEqual(self.obj.rotation_mode, "XYZ")

    def test_refused_parents_write_nothing(self):
        armature = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
        self.scene.collection.objects.link(armature)
        bpy.context.view_layer.objects.active = armature
        bpy.ops.object.mode_set(mode="EDIT")
        armature.data.edit_bones.new("bone").tail = (0, 0, 1)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.obj.parent, self.obj.parent_type, self.obj.parent_bone = armature, "BONE", "bone"
        with self.assertRaisesRegex(scene.SceneError, "'die' is parented to a part of 'rig'"):
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.obj.parent_type = "OBJECT"
        armature.scale = (-1, 1, 1)
        bpy.context.view_layer.update()
        with self.assertRaisesRegex(scene.SceneError, "'rig' of 'die' is mirrored"):
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
        armature.scale = (1, 1, 1)
        armature.keyframe_insert("location", frame=1)
        with self.assertRaisesRegex(scene.SceneError, "'rig' of 'die' is animated"):
            bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.assertIsNone(self.obj.animation_data)

    def test_many_at_once_are_as_one_by_one(self):
        """Of about the same lengths, where early versions copy a prepared Action, and others."""
        motions = [BouncingBall(spin_rad_s=s, bounces=b) for s in (40.0, 41.0) for b in (3, 4, 9)]
        single, many = [], []
        for i, motion in enumerate(2 * motions):
            for group in (single, many):
                obj = add_box(f"die {i}")
                obj.ifa.place = "WORLD"
                group.append((obj, bake.make(self.scene, obj, motion, CENTRE)))
        for pair in single:
            bake.write(self.scene, [pair])
        bake.write(self.scene, many)
        self.assertEqual(len(bpy.data.actions), 4 * len(motions))
        for (one, _), (other, _) in zip(single, many, strict=True):
            self.assertEqual(curve_bytes(one), curve_bytes(other))
            for curve in fcurves(other):
                for point in curve.keyframe_points:
                    self.assertEqual(point.handle_left_type, "FREE")
                    self.assertEqual(point.handle_right_type, "FREE")
            bake.clear(one)
            bake.clear(other)
        self.assertEqual(len(bpy.data.actions), 0)

    def test_rebake_uses_the_same_action(self):
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        first = self.obj.animation_data.action.name
        self.motion = BouncingBall(spin_rad_s=10.0, bounces=3)
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.assertEqual([a.name for a in bpy.data.actions], [first])
        self.assertEqual(len(fcurves(self.obj)), 7)
        self.check_world(self.obj)

    def test_same_motion_bakes_the_same_keys(self):
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        first = curve_bytes(self.obj)
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.assertEqual(first, curve_bytes(self.obj))

    def test_clear_restores(self):
        self.obj.rotation_mode = "ZYX"
        self.obj.rotation_euler = (0.1, 0.2, 0.3)
        self.obj.location = (1, 2, 3)
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        bake.clear(self.obj)
        self.assertEqual(self.obj.rotation_mode, "ZYX")
        np.testing.assert_allclose(self.obj.rotation_euler, (0.1, 0.2, 0.3), rtol=1e-6)
        np.testing.assert_allclose(self.obj.location, (1, 2, 3))
        self.assertIsNone(self.obj.animation_data)
        self.assertEqual(len(bpy.data.actions), 0)

    def test_clear_restores_the_earlier_action(self):
        self.obj.keyframe_insert("location", frame=1)
        self.obj.keyframe_insert("hide_render", frame=5)
        earlier = self.obj.animation_data.action
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        baked = self.obj.animation_data.action
        self.assertNotEqual(baked, earlier)
        self.assertIsNotNone(fcurves(self.obj).find("hide_render"))
        bake.clear(self.obj)
        self.assertEqual(self.obj.animation_data.action, earlier)
        self.assertEqual(len(fcurves(self.obj)), 4)
        self.assertEqual(list(bpy.data.actions), [earlier])

    def test_clear_after_loading_the_file(self):
        import tempfile
        from pathlib import Path

        self.obj.location = (1, 2, 3)
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "baked.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        obj = bpy.data.objects["die"]
        bpy.context.view_layer.objects.active = obj
        bpy.ops.ifa.clear()
        np.testing.assert_allclose(obj.location, (1, 2, 3))
        self.assertEqual(len(bpy.data.actions), 0)

    def test_a_duplicate_is_baked_into_its_own_action(self):
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        copy = self.obj.copy()
        self.scene.collection.objects.link(copy)
        bake.bake(self.scene, copy, BouncingBall(spin_rad_s=10.0, bounces=3), CENTRE)
        self.assertNotEqual(copy.animation_data.action, self.obj.animation_data.action)
        self.check_world(self.obj)
