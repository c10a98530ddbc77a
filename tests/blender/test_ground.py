"""The ground object: where the motion is placed, and which grounds are refused."""

import bpy
import numpy as np
from ifa_addon import bake, keys, scene
from support import (
    POSITION_BOUND_M,
    ROTATION_BOUND_DEG,
    BouncingBall,
    SceneTest,
    add_box,
    add_parent,
    evaluate_world,
    rotation_deg,
)

CENTRE = np.array([0.003, -0.002, 0.001])


class GroundTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.obj = add_box()
        self.obj.ifa.place = "WORLD"
        corners = [(-1, -1, 0.25), (1, -1, 0.25), (1, 1, 0.25), (-1, 1, 0.25)]
        self.ground = self.add_mesh("table", corners, [(0, 1, 2, 3)])
        self.scene.ifa.ground = self.ground

    def add_mesh(self, name, vertices, faces):
        data = bpy.data.meshes.new(name)
        data.from_pydata(vertices, [], faces)
        obj = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        return obj

    def height(self):
        bpy.context.view_layer.update()
        return scene.ground_height(self.scene, self.obj)

    def refused(self, sentence):
        bpy.context.view_layer.update()
        motion = BouncingBall()
        with self.assertRaisesRegex(scene.SceneError, sentence):
            bake.bake(self.scene, self.obj, motion, CENTRE)
        self.assertIsNone(self.obj.animation_data)

    def test_height_counts_scale_place_and_parent(self):
        self.assertAlmostEqual(self.height(), 0.25, places=6)
        self.ground.location = (3, 4, 0.5)
        self.ground.scale = (7, 2, 3)
        self.assertAlmostEqual(self.height(), 0.5 + 3 * 0.25, places=6)
        self.ground.rotation_euler = (0, 0, 1.1)  # about the vertical: still level
        self.assertAlmostEqual(self.height(), 1.25, places=6)
        self.ground.rotation_euler = (np.pi, 0, 0)  # face down: its height alone counts
        self.assertAlmostEqual(self.height(), 0.5 - 0.75, places=5)

    def test_none_is_zero(self):
        self.scene.ifa.ground = None
        self.assertEqual(self.height(), 0.0)

    def test_the_motion_is_placed_on_it(self):
        """x - R c of the closed form, raised by the ground's height in metres; in any units."""
        motion = BouncingBall(spin_rad_s=30.0)
        parent = add_parent(scale=2.0)
        for scale_length in (0.01, 1.0):
            for inside in (None, parent):
                self.scene.unit_settings.scale_length = scale_length
                self.obj.parent = inside
                self.ground.location.z = -1.75  # so the ground is at -1.5
                bpy.context.view_layer.update()
                bake.bake(self.scene, self.obj, motion, CENTRE)
                times = np.linspace(motion.start_s, motion.end_s, 150)
                frames = scene.timing(self.scene).frame(times)
                origins, rotations = evaluate_world(self.scene, self.obj, frames)
                position, q = motion.sample(times)
                unit_m = self.scene.unit_settings.scale_length
                truth = position - keys.rotate(q, CENTRE) - [0, 0, 1.5 * unit_m]
                self.assertLess(np.abs(origins * unit_m - truth).max(), POSITION_BOUND_M)
                self.assertLess(rotation_deg(rotations, q).max(), ROTATION_BOUND_DEG)

    def test_tilt(self):
        self.ground.rotation_euler = (np.radians(0.09), 0, 0)
        self.assertAlmostEqual(self.height(), 0.25, places=4)
        self.ground.rotation_euler = (0, np.radians(0.11), 0)
        self.refused("Ground 'table' is tilted by 0.11 degrees")
        self.ground.rotation_euler = (np.radians(90), 0, 0)
        self.refused("Ground 'table' is tilted by 90 degrees")

    def test_tilt_by_a_parent(self):
        self.ground.parent = add_parent()
        self.refused("Ground 'table' is tilted")

    def test_animated(self):
        self.ground.keyframe_insert("location", frame=1)
        self.refused("Ground 'table' is animated")

    def test_animated_parent(self):
        parent = bpy.data.objects.new("cart", None)
        self.scene.collection.objects.link(parent)
        parent.keyframe_insert("location", frame=1)
        self.ground.parent = parent
        self.refused("Ground 'table' is animated")

    def test_constrained(self):
        self.ground.constraints.new("COPY_LOCATION")
        self.refused("Ground 'table' is animated")

    def test_shape(self):
        self.scene.ifa.ground = add_box("block")
        self.refused("Ground 'block' is not flat")
        self.scene.ifa.ground = self.add_mesh("edge", [(0, 0, 0), (1, 0, 0), (2, 0, 0)], [])
        self.refused("Ground 'edge' has no area")
        self.scene.ifa.ground = self.add_mesh("nothing", [], [])
        self.refused("Ground 'nothing' has no area")

    def test_the_body_itself(self):
        self.scene.ifa.ground = self.obj
        self.refused("Ground 'die' is 'die' or moves with it")
        self.scene.ifa.ground = self.ground
        self.ground.parent = self.obj
        self.refused("Ground 'table' is 'die' or moves with it")

    def test_not_in_the_scene(self):
        self.scene.collection.objects.unlink(self.ground)
        self.refused("Ground 'table' is not in scene")

    def test_refused_before_the_solve(self):
        self.add_markers([10, 20])
        self.ground.rotation_euler = (0.3, 0, 0)
        bpy.context.view_layer.update()
        graph = bpy.context.evaluated_depsgraph_get()
        with self.assertRaisesRegex(scene.SceneError, "tilted by 17 degrees"):
            scene.read_inputs(self.scene, self.obj, graph)
