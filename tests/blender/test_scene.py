"""What is read from the scene: timing, marks, sound, body, parent space."""

import wave
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np
from ifa_addon import scene
from support import (
    FRAME_RATES,
    SceneTest,
    add_box,
    add_parent,
    add_sound,
    offset_matrix,
    set_first,
)


class MarksTest(SceneTest):
    def times(self, pattern=""):
        found = scene.checked_marks(self.scene, pattern, scene.timing(self.scene))
        return [mark.time_s for mark in found]

    def test_frames_become_seconds_at_every_rate(self):
        self.scene.frame_start = 11
        self.add_markers([11, 35, 83])
        for numerator, denominator in FRAME_RATES:
            self.set_rate(numerator, denominator)
            exact = [frames * denominator / numerator for frames in (0, 24, 72)]
            # fps_base is a float32
            np.testing.assert_allclose(self.times(), exact, rtol=1e-6)

    def test_filter(self):
        self.add_markers([10, 20], "die")
        self.add_markers([15, 25, 35], "note")
        self.assertEqual(len(self.times("die")), 2)
        self.assertEqual(len(self.times("*2")), 2)
        self.assertEqual(len(self.times()), 5)
        with self.assertRaisesRegex(scene.SceneError, "No timeline markers.*'coin'"):
            self.times("coin")

    def test_camera_markers_do_not_count(self):
        self.add_markers([10, 20])
        data = bpy.data.cameras.new("camera")
        camera = bpy.data.objects.new("camera", data)
        self.scene.timeline_markers.new("cut", frame=15).camera = camera
        self.assertEqual(len(self.times()), 2)

    def test_exact_times_survive_until_the_marker_is_dragged(self):
        given = [0.1234567891, 0.4000001, 1.7320508]
        scene.add_marks(self.scene, given)
        self.assertEqual(self.times(), given)
        marker = self.scene.timeline_markers[1]
        marker.frame += 3
        timing = scene.timing(self.scene)
        found = scene.marks(self.scene, "", timing)
        self.assertEqual([m.dragged for m in found], [False, True, False])
        self.assertEqual(found[1].time_s, float(timing.time_s(marker.frame)))
        marker.frame -= 3
        self.assertEqual(self.times(), given)

    def test_exact_times_survive_another_rate(self):
        given = [0.1234567891, 0.4000001]
        scene.add_marks(self.scene, given)
        self.set_rate(60, 1)
        self.assertEqual(self.times(), given)

    def test_exact_times_survive_a_file(self):
        given = [0.1234567891, 0.4000001]
        scene.add_marks(self.scene, given)
        with TemporaryDirectory() as folder:
            path = str(Path(folder) / "märks.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            self.scene = bpy.context.scene
            self.assertEqual(self.times(), given)

    def test_two_on_one_frame_are_named(self):
        self.scene.timeline_markers.new("left", frame=20)
        self.scene.timeline_markers.new("right", frame=20)
        with self.assertRaisesRegex(scene.SceneError, "'left'.*'right'.*same time"):
            self.times()

    def test_closer_than_the_merge_gap_are_named(self):
        scene.add_marks(self.scene, [0.5, 0.508])
        with self.assertRaisesRegex(scene.SceneError, "'hit 1'.*'hit 2'.*8.0 ms"):
            self.times()

    def test_no_markers(self):
        with self.assertRaisesRegex(scene.SceneError, "No timeline markers"):
            self.times()

    def test_before_the_start(self):
        self.scene.frame_start = 30
        self.add_markers([20, 40])
        with self.assertRaisesRegex(scene.SceneError, "'hit 1'.*before the scene's start"):
            self.times()

    def test_time_remapping_is_refused(self):
        self.scene.render.frame_map_new = 200
        with self.assertRaisesRegex(scene.SceneError, "remapping"):
            scene.timing(self.scene)


class SoundTest(SceneTest):
    def setUp(self):
        super().setUp()
        folder = TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = str(Path(folder.name) / "two seconds.wav")
        with wave.open(self.path, "wb") as out:
            out.setnchannels(1)
            out.setsampwidth(2)
            out.setframerate(48000)
            out.writeframes(b"\0\0" * 96000)

    def add_strip(self, frame):
        self.scene.ifa.sound_source = "STRIP"
        return add_sound(self.scene, "roll", self.path, frame)

    def test_times_run_from_the_strip(self):
        self.add_strip(50)
        self.assertEqual(scene.timing(self.scene).origin_frame, 50.0)
        self.assertEqual(scene.sound(self.scene), (self.path, b""))

    def test_trimming_keeps_the_origin_and_moving_takes_it_along(self):
        strip = self.add_strip(50)
        set_first(strip, ("left_handle_offset", "frame_offset_start"), 7)
        seen = strip.left_handle if hasattr(strip, "left_handle") else strip.frame_final_start
        self.assertEqual(seen, 57)
        self.assertEqual(scene.timing(self.scene).origin_frame, 50.0)
        set_first(strip, ("content_start", "frame_start"), 62)
        self.assertEqual(scene.timing(self.scene).origin_frame, 62.0)

    def test_packed_sound(self):
        strip = self.add_strip(1)
        strip.sound.pack()
        _, data = scene.sound(self.scene)
        self.assertEqual(data, Path(self.path).read_bytes())

    def test_no_strip(self):
        self.scene.ifa.sound_source = "STRIP"
        with self.assertRaisesRegex(scene.SceneError, "no sound strip"):
            scene.timing(self.scene)

    def test_named_strip_is_missing(self):
        self.add_strip(1)
        self.scene.ifa.sound_strip = "other"
        with self.assertRaisesRegex(scene.SceneError, "'other'"):
            scene.timing(self.scene)

    def test_another_speed_is_refused(self):
        strip = self.add_strip(1)
        if hasattr(strip, "speed_factor"):
            strip.speed_factor = 2.0
        elif hasattr(strip, "content_start"):
            strip.retiming_keys.add(timeline_frame=30)
            strip.retiming_keys[1].timeline_frame = 20
        else:
            self.skipTest("retiming_keys.add crashes the bpy 4.5 module")
        with self.assertRaisesRegex(scene.SceneError, "'roll' plays at another speed"):
            scene.timing(self.scene)

    def test_files(self):
        self.scene.ifa.sound_source = "FILE"
        with self.assertRaisesRegex(scene.SceneError, "No sound file is chosen"):
            scene.sound(self.scene)
        self.scene.ifa.sound_file = "//roll.wav"
        with self.assertRaisesRegex(scene.SceneError, "not saved"):
            scene.sound(self.scene)
        self.scene.ifa.sound_file = "/nowhere/roll.wav"
        with self.assertRaisesRegex(scene.SceneError, "'/nowhere/roll.wav' does not exist"):
            scene.sound(self.scene)
        self.scene.ifa.sound_file = self.path
        self.assertEqual(scene.sound(self.scene)[0], self.path)

    def test_marker_before_the_sound(self):
        self.add_strip(50)
        self.add_markers([40, 60])
        with self.assertRaisesRegex(scene.SceneError, "'hit 1'.*before the sound's start"):
            scene.checked_marks(self.scene, "", scene.timing(self.scene))


def volume_and_centre(vertices, triangles):
    """By tetrahedra from the origin."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    return parts.sum(), ((a + b + c) / 4 * parts[:, None]).sum(axis=0) / parts.sum()


class BodyTest(SceneTest):
    def read(self, obj):
        graph = bpy.context.evaluated_depsgraph_get()
        return scene.mesh(obj, graph, scene.metres_per_unit(self.scene))

    def test_scale_and_offset_origin(self):
        obj = add_box(size=(1, 2, 3), centre=(0.5, 0.0, 1.0))
        obj.scale = (2, 3, 0.5)
        obj.delta_scale = (1, 1, 2)
        obj.rotation_euler = (0.3, 0.4, 0.5)
        bpy.context.view_layer.update()
        volume, centre = volume_and_centre(*self.read(obj))
        self.assertAlmostEqual(volume, 6 * 2 * 3 * 1, places=5)
        np.testing.assert_allclose(centre, [1.0, 0.0, 1.0], atol=1e-6)

    def test_scene_units(self):
        obj = add_box(size=(16, 16, 16))
        self.scene.unit_settings.scale_length = 1e-3
        vertices, _ = self.read(obj)
        np.testing.assert_allclose(np.abs(vertices), 0.008, rtol=1e-6)
        self.scene.unit_settings.system = "NONE"
        vertices, _ = self.read(obj)
        np.testing.assert_allclose(np.abs(vertices), 8.0, rtol=1e-6)

    def test_modifiers_count(self):
        obj = add_box(size=(1, 1, 1), centre=(0.5, 0, 0))
        modifier = obj.modifiers.new("array", "ARRAY")
        modifier.count = 3
        bpy.context.view_layer.update()
        volume, centre = volume_and_centre(*self.read(obj))
        self.assertAlmostEqual(volume, 3.0, places=5)
        np.testing.assert_allclose(centre, [1.5, 0, 0], atol=1e-6)

    def test_mirroring_scale_keeps_the_outside_out(self):
        obj = add_box(size=(1, 2, 3))
        volume, _ = volume_and_centre(*self.read(obj))
        obj.scale = (-1, 1, 1)
        mirrored, _ = volume_and_centre(*self.read(obj))
        self.assertAlmostEqual(volume, mirrored, places=5)
        self.assertAlmostEqual(abs(volume), 6.0, places=5)

    def test_parent_scale(self):
        obj = add_box(size=(1, 1, 1))
        obj.parent = add_parent(scale=2.0)
        obj.matrix_parent_inverse = offset_matrix()
        bpy.context.view_layer.update()
        volume, _ = volume_and_centre(*self.read(obj))
        self.assertAlmostEqual(volume, 8.0, places=4)

    def test_refusals(self):
        obj = add_box()
        parent = add_parent()
        obj.parent = parent
        parent.scale = (1, 1, 2)
        bpy.context.view_layer.update()
        with self.assertRaisesRegex(scene.SceneError, "'parent'.*non-uniform scale"):
            scene.parent_space(obj)
        parent.scale = (-1, -1, -1)
        bpy.context.view_layer.update()
        with self.assertRaisesRegex(scene.SceneError, "'parent'.*mirrored"):
            scene.parent_space(obj)
        parent.scale = (1, 1, 1)
        parent.keyframe_insert("location", frame=1)
        with self.assertRaisesRegex(scene.SceneError, "'parent'.*animated"):
            scene.parent_space(obj)
        obj.parent = None
        obj.constraints.new("LIMIT_LOCATION").name = "fence"
        with self.assertRaisesRegex(scene.SceneError, "'fence' of 'die'"):
            scene.checked_object(obj)
        with self.assertRaisesRegex(scene.SceneError, "no mesh"):
            scene.checked_object(parent)

    def test_a_mesh_without_faces(self):
        data = bpy.data.meshes.new("points")
        data.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
        obj = bpy.data.objects.new("points", data)
        self.scene.collection.objects.link(obj)
        with self.assertRaisesRegex(scene.SceneError, "'points' has no faces"):
            self.read(obj)


class SettingsTest(SceneTest):
    def test_surface_presets(self):
        own = add_box().ifa
        own.surface = "CARPET"
        self.assertAlmostEqual(own.restitution, 0.15, places=6)
        self.assertEqual(own.surface, "CARPET")
        own.friction = 0.9
        self.assertEqual(own.surface, "CUSTOM")
        self.assertAlmostEqual(own.restitution, 0.15, places=6)

    def test_digest_follows_the_scene(self):
        obj = add_box()
        self.add_markers([10, 30])

        def digest():
            graph = bpy.context.evaluated_depsgraph_get()
            return scene.read_inputs(self.scene, obj, graph).digest()

        first = digest()
        self.assertEqual(first, digest())
        changes = [
            lambda: setattr(self.scene.timeline_markers[0], "frame", 11),
            lambda: setattr(obj.data.vertices[0], "co", (-0.01, -0.01, -0.01)),
            lambda: setattr(obj.ifa, "seed", 3),
            lambda: setattr(obj.ifa, "friction", 0.31),
        ]
        for change in changes:
            change()
            bpy.context.view_layer.update()
            self.assertNotEqual(digest(), first)
            first = digest()
