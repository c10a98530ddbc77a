"""The workflow around a solve: several bodies, takes, lights, repairs, marks that are dragged."""

import time
from pathlib import Path

import bpy
import numpy as np
from ifa_addon import compat, core, job, live, overlay, results, scene, writing
from support import SceneTest, add_box

MARKS_S = [0.30, 0.42, 0.48, 0.52]  # a simulated 16 mm die's, rounded to 10 ms
ABRUPT_S = [0.3, 0.5]  # two hits, then rest: with this body's restitution nothing rests so
SIDE_M = 0.016
LIVE_LIMIT_S = 20.0


def key_heights(obj):
    curves = compat.fcurves(obj.animation_data.action, obj)
    return np.array([p.co[:] for p in curves.find("location", index=2).keyframe_points])


class WorkflowTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.obj = add_box("die", (SIDE_M, SIDE_M, SIDE_M))
        self.addCleanup(results.forget)

    def add_second(self, prefix="b"):
        other = add_box("other", (SIDE_M, SIDE_M, SIDE_M))
        other.ifa.marker_filter = prefix
        other.ifa.is_body = True
        return other


class SeveralBodiesTest(WorkflowTest):
    def test_each_with_its_own_marks(self):
        self.obj.ifa.marker_filter = "a"
        other = self.add_second()
        other.ifa.seed = 7
        scene.add_marks(self.scene, MARKS_S, "a")
        later = [t + 0.5 for t in MARKS_S]
        scene.add_marks(self.scene, later, "b")
        self.obj.select_set(True)
        bpy.context.view_layer.objects.active = self.obj
        self.assertEqual(bpy.ops.ifa.solve(), {"FINISHED"})
        for obj, marks in ((self.obj, MARKS_S), (other, later)):
            self.assertTrue(obj.ifa.succeeded, obj.ifa.result)
            at = scene.timing(self.scene).time_s(key_heights(obj)[:, 0])
            for mark in marks:
                self.assertLess(np.abs(at - mark).min(), 1e-3)

    def test_bad_marks_of_one_leave_the_other_solved(self):
        """A flat body fails in the core, by name; the other is keyed all the same."""
        data = bpy.data.meshes.new("line")
        data.from_pydata([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [], [(0, 1, 2)])
        other = self.add_second(prefix="")
        other.data = data
        scene.add_marks(self.scene, MARKS_S)
        bpy.context.view_layer.objects.active = self.obj
        self.assertEqual(bpy.ops.ifa.solve(), {"FINISHED"})
        self.assertTrue(self.obj.ifa.succeeded)
        self.assertIsNone(other.animation_data)
        self.assertIn("other:", job.failure)

    def test_all_takes_bodies_that_are_not_selected(self):
        other = self.add_second(prefix="")
        scene.add_marks(self.scene, MARKS_S)
        bpy.context.view_layer.objects.active = self.obj
        other.select_set(False)
        bpy.ops.ifa.solve(bodies_from="ACTIVE")
        self.assertIsNone(other.animation_data)
        bpy.ops.ifa.solve(bodies_from="ALL")
        self.assertIsNotNone(other.animation_data)


class TakesTest(WorkflowTest):
    def test_stepping_there_and_back_gives_the_same_keys(self):
        self.obj.ifa.takes = 3
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        own = self.obj.ifa
        self.assertEqual((own.take, own.takes_found), (1, 3))
        first = key_heights(self.obj)
        bpy.ops.ifa.take(step=1)
        self.assertEqual(own.take, 2)
        second = key_heights(self.obj)
        self.assertFalse(first.shape == second.shape and np.allclose(first, second))
        bpy.ops.ifa.take(step=-1)
        np.testing.assert_array_equal(key_heights(self.obj), first)
        bpy.ops.ifa.take(step=-1)
        self.assertEqual(own.take, 3)
        own.take = 1  # as an undo of the step leaves it
        bpy.ops.ifa.take(step=1)
        self.assertEqual(own.take, 2)
        self.assertEqual(len(bpy.data.actions), 1)

    def test_bake_again_follows_the_frame_rate(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        own = self.obj.ifa
        self.assertEqual(own.keyed_as, writing.key_state(self.scene, self.obj))
        self.set_rate(60, 1)
        self.assertNotEqual(own.keyed_as, writing.key_state(self.scene, self.obj))
        bpy.ops.ifa.bake()
        self.assertEqual(own.keyed_as, writing.key_state(self.scene, self.obj))
        at = scene.timing(self.scene).time_s(key_heights(self.obj)[:, 0])
        for mark in MARKS_S:
            self.assertLess(np.abs(at - mark).min(), 1e-3)

    def test_a_changed_scene_is_not_keyed_with_an_old_take(self):
        self.obj.ifa.takes = 2
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        self.scene.timeline_markers[-1].frame += 3
        with self.assertRaisesRegex(RuntimeError, "changed since the solve"):
            bpy.ops.ifa.take(step=1)


class ReportTest(WorkflowTest):
    def test_lights_of_a_success(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        reports = self.obj.ifa.mark_reports
        self.assertEqual([r.name for r in reports], [f"hit {k}" for k in (1, 2, 3, 4)])
        self.assertEqual({r.light for r in reports}, {"MET"})
        self.assertLess(max(abs(r.error_ms) for r in reports), 1.0)

    def test_lights_in_the_timeline_follow_the_markers(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        rows = overlay.placed(bpy.context)
        frames = scene.timing(self.scene).frame(MARKS_S)
        np.testing.assert_allclose([row[0] for row in rows], frames, atol=1e-3)
        self.scene.timeline_markers["hit 2"].frame += 1
        lights = [row[1] for row in overlay.placed(bpy.context)]
        self.assertEqual(lights.count("MOVED"), 1)

    def test_a_missed_mark_is_red(self):
        scene.add_marks(self.scene, [0.30, 0.34, 0.38, 1.78])  # rebounds from 2.4 m after 1 cm
        self.obj.ifa.time_budget_s = 0.5
        bpy.ops.ifa.solve()
        self.assertEqual(self.obj.ifa.mark_reports[-1].light, "MISSED")

    def test_clear_forgets(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        bpy.ops.ifa.clear()
        self.assertEqual(len(self.obj.ifa.mark_reports), 0)
        self.assertIsNone(results.of("die"))
        self.assertEqual(overlay.placed(bpy.context), [])

    def test_marks_of_one_name_have_a_light_each(self):
        scene.add_marks(self.scene, MARKS_S)
        for marker in self.scene.timeline_markers:
            marker.name = "hit"
        bpy.ops.ifa.solve()
        rows = overlay.placed(bpy.context)
        self.assertEqual({row[1] for row in rows}, {"MET"})
        frames = scene.timing(self.scene).frame(MARKS_S)
        np.testing.assert_allclose([row[0] for row in rows], frames, atol=1e-3)


class OriginTest(WorkflowTest):
    def test_another_start_frame_does_not_move_marks(self):
        self.add_markers([8, 11, 12, 13])
        self.obj.ifa.ending = "OPEN"
        bpy.ops.ifa.solve()
        self.scene.frame_start = 5
        found = scene.marks(self.scene, "", scene.timing(self.scene))
        np.testing.assert_allclose(
            scene.timing(self.scene).frame([m.time_s for m in found]), [8, 11, 12, 13], atol=1e-6
        )
        self.assertFalse(any(m.dragged for m in found))


class ActionTest(WorkflowTest):
    def test_a_deleted_action_is_made_again_and_clear_still_restores(self):
        self.obj.location = (1.0, 2.0, 3.0)
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        bpy.data.actions.remove(self.obj.ifa.action)
        bpy.ops.ifa.solve()
        bpy.ops.ifa.clear()
        np.testing.assert_allclose(self.obj.location, (1.0, 2.0, 3.0))
        self.assertEqual(len(bpy.data.actions), 0)

    def test_clear_restores_after_its_action_was_deleted(self):
        self.obj.location = (1.0, 2.0, 3.0)
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        bpy.data.actions.remove(self.obj.ifa.action)
        self.assertEqual(bpy.ops.ifa.clear(), {"FINISHED"})
        np.testing.assert_allclose(self.obj.location, (1.0, 2.0, 3.0))

    def test_clear_leaves_an_action_that_was_assigned_since(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        other = bpy.data.actions.new("hand made")
        compat.assign_action(self.obj.animation_data, other)
        bpy.ops.ifa.clear()
        self.assertEqual(self.obj.animation_data.action, other)

    def test_a_driver_of_the_location_is_refused(self):
        scene.add_marks(self.scene, MARKS_S)
        self.obj.driver_add("location", 2)
        with self.assertRaisesRegex(RuntimeError, "driver"):
            bpy.ops.ifa.solve()


class RepairTest(WorkflowTest):
    def repair(self, kind):
        own = self.obj.ifa
        found = [i for i, r in enumerate(own.repairs) if r.kind == kind]
        self.assertTrue(found, [r.kind for r in own.repairs])
        plausible = own.repairs[found[0]].plausible
        self.assertEqual(bpy.ops.ifa.repair(index=found[0]), {"FINISHED"})
        self.assertTrue(own.succeeded, own.result)
        self.assertTrue(own.plausible or not plausible)

    def test_each_offered_repair_works(self):
        own = self.obj.ifa
        own.time_budget_s = 4.0
        scene.add_marks(self.scene, ABRUPT_S)
        bpy.ops.ifa.explain()
        kinds = {r.kind for r in own.repairs}
        self.assertTrue(kinds)
        for kind in sorted(kinds):
            self.scene.timeline_markers.clear()
            scene.add_marks(self.scene, ABRUPT_S)
            own.ending, own.restitution, own.friction, own.energy_gain_j = "REST", 0.5, 0.3, 0.0
            bpy.ops.ifa.explain()
            self.repair(kind)

    def test_a_marker_that_is_gone(self):
        scene.add_marks(self.scene, ABRUPT_S)
        item = self.obj.ifa.repairs.add()
        item.kind, item.mark, item.mark_time_s = "drop", "hit 9", 0.5
        with self.assertRaisesRegex(RuntimeError, "'hit 9'"):
            bpy.ops.ifa.repair(index=0)


class QualityTest(WorkflowTest):
    def test_stops_are_those_of_the_core(self):
        ifa = core.load()
        own = self.obj.ifa
        for name, preset in ifa.ACCURACIES.items():
            own.accuracy = name.upper()
            self.assertAlmostEqual(own.position_tolerance_mm, 1e3 * preset.key_position_m, 6)
            self.assertAlmostEqual(np.radians(own.rotation_tolerance_deg), preset.key_angle_rad, 6)

    def test_predictions_are_for_these_marks(self):
        scene.add_marks(self.scene, MARKS_S)
        self.obj.ifa.ending = "OPEN"
        self.assertEqual(bpy.ops.ifa.predict(), {"FINISHED"})

        def predictions():
            found = scene.marks(self.scene, "", scene.timing(self.scene))
            return results.predictions_for("die", scene.asked(self.obj, found))

        self.assertEqual(set(predictions()), {"draft", "good", "best"})
        self.assertLessEqual(predictions()["draft"].time_s, predictions()["best"].time_s)
        self.obj.ifa.restitution = 0.4
        self.assertEqual(predictions(), {})
        self.obj.ifa.restitution = 0.5
        self.assertTrue(predictions())
        self.scene.timeline_markers.remove(self.scene.timeline_markers[-1])
        self.assertEqual(predictions(), {})

    def test_what_came_true_is_kept_beside(self):
        scene.add_marks(self.scene, MARKS_S)
        self.obj.ifa.ending = "OPEN"
        self.obj.ifa.accuracy = "DRAFT"
        bpy.ops.ifa.solve()
        own, solution = self.obj.ifa, results.of("die").solution
        self.assertEqual(solution.accuracy, "draft")
        self.assertAlmostEqual(own.error, solution.error, 6)
        self.assertGreater(own.solve_s, 0.0)

    def test_the_effects_line_says_what_was_left_out(self):
        scene.add_marks(self.scene, MARKS_S)
        self.obj.ifa.ending = "OPEN"
        bpy.ops.ifa.solve()
        on, off = self.obj.ifa.effects.split("; off: ")
        self.assertIn("friction", on)
        self.assertIn("settling to rest (the ending is open)", off)


class LiveTest(WorkflowTest):
    def run_live(self, until):
        """The timer's looks, by hand: a background Blender has no event loop."""
        began = time.monotonic()
        while not until() and time.monotonic() - began < LIVE_LIMIT_S:
            live.look()
            time.sleep(0.02)

    def test_the_motion_follows_a_mark(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        bpy.context.window_manager.ifa_live = True
        self.addCleanup(live.stop)
        self.assertTrue(bpy.app.timers.is_registered(live.look))
        moved = self.scene.timeline_markers["hit 2"]
        scene.move_mark(self.scene, moved, MARKS_S[1] + 0.006)
        self.run_live(lambda: abs(self.obj.ifa.mark_reports[1].time_s - MARKS_S[1]) > 0.005)
        at = scene.timing(self.scene).time_s(key_heights(self.obj)[:, 0])
        self.assertLess(np.abs(at - MARKS_S[1] - 0.006).min(), 1e-3)
        self.assertTrue(self.obj.ifa.succeeded, self.obj.ifa.result)
        bpy.context.window_manager.ifa_live = False
        self.assertFalse(bpy.app.timers.is_registered(live.look))
        self.assertNotIn(live._after_undo, bpy.app.handlers.undo_post)

    def test_a_cancelled_follow_is_not_begun_again(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        before = key_heights(self.obj)
        bpy.context.window_manager.ifa_live = True
        self.addCleanup(live.stop)
        scene.move_mark(self.scene, self.scene.timeline_markers["hit 2"], MARKS_S[1] + 0.006)
        self.run_live(lambda: job.running() is not None)
        job.running().cancel()
        for _ in range(20):
            live.look()
            self.assertIsNone(job.running())
            time.sleep(0.02)
        np.testing.assert_array_equal(key_heights(self.obj), before)

    def test_a_state_that_was_undone_to_is_not_solved(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        bpy.context.window_manager.ifa_live = True
        self.addCleanup(live.stop)
        scene.move_mark(self.scene, self.scene.timeline_markers["hit 2"], MARKS_S[1] + 0.006)
        live._after_undo()
        for _ in range(20):
            live.look()
            self.assertIsNone(job.running())
            time.sleep(0.02)

    def test_two_marks_on_one_frame_are_waited_for(self):
        scene.add_marks(self.scene, MARKS_S)
        bpy.ops.ifa.solve()
        before = key_heights(self.obj)
        bpy.context.window_manager.ifa_live = True
        self.addCleanup(live.stop)
        scene.move_mark(self.scene, self.scene.timeline_markers["hit 2"], MARKS_S[2])
        for _ in range(20):
            live.look()
            time.sleep(0.02)
        np.testing.assert_array_equal(key_heights(self.obj), before)


class PresetTest(WorkflowTest):
    def test_a_stored_body_comes_back(self):
        own = self.obj.ifa
        own.mass_from, own.mass_kg, own.restitution, own.friction = "MASS", 0.25, 0.31, 0.62
        self.assertEqual(bpy.ops.ifa.body_preset(name="heavy"), {"FINISHED"})
        folder = bpy.utils.user_resource("SCRIPTS", path="presets/ifa/body")
        stored = Path(folder) / "heavy.py"
        self.addCleanup(stored.unlink, missing_ok=True)
        own.mass_from, own.mass_kg, own.restitution, own.friction = "DENSITY", 1.0, 0.5, 0.3
        bpy.ops.script.execute_preset(filepath=str(stored), menu_idname="IFA_PT_body_presets")
        self.assertEqual(own.mass_from, "MASS")
        np.testing.assert_allclose(
            (own.mass_kg, own.restitution, own.friction), (0.25, 0.31, 0.62), rtol=1e-6
        )


class TooltipTest(SceneTest):
    def test_everything_a_user_sees_says_what_it_does(self):
        import ifa_addon

        silent = []
        for module in ifa_addon._MODULES:
            for cls in getattr(module, "CLASSES", ()):
                rna = getattr(cls, "bl_rna", None)
                if issubclass(cls, bpy.types.Operator):  # its properties are those of its call
                    rna = getattr(bpy.ops.ifa, cls.bl_idname.split(".")[1]).get_rna_type()
                if issubclass(cls, bpy.types.Operator) and not cls.bl_description:
                    silent.append(cls.__name__)
                if not issubclass(cls, (bpy.types.Operator, bpy.types.PropertyGroup)):
                    continue
                own = [p for p in rna.properties if p.identifier in cls.__annotations__]
                silent += [
                    f"{cls.__name__}.{p.identifier}"
                    for p in own
                    if not p.is_hidden and not p.description
                ]
        self.assertEqual(silent, [])
