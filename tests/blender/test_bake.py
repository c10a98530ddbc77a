"""Keys in Blender against the closed-form motion they were made from."""

import bpy
import numpy as np
from ifa_addon import bake, keys, scene
from mathutils import Quaternion
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
        self.scene.unit_settings.scale_length = 0.01
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.check_world(self.obj, unit_m=self.scene.unit_settings.scale_length)

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

    def test_rebake_uses_the_same_action(self):
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        first = self.obj.animation_data.action.name
        self.motion = BouncingBall(spin_rad_s=10.0, bounces=3)
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.assertEqual([a.name for a in bpy.data.actions], [first])
        self.assertEqual(len(fcurves(self.obj)), 7)
        self.check_world(self.obj)

    def test_same_motion_bakes_the_same_keys(self):
        def raw():
            out = []
            for curve in fcurves(self.obj):
                for name in ("co", "handle_left", "handle_right"):
                    data = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
                    curve.keyframe_points.foreach_get(name, data)
                    out.append(data.tobytes())
            return out

        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        first = raw()
        bake.bake(self.scene, self.obj, self.motion, CENTRE)
        self.assertEqual(first, raw())

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
