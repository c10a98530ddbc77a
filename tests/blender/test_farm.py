"""The farm command, as a process of its own: exit codes, progress, a session's keys."""

import hashlib
import os
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np
from ifa_addon import compat, scene
from support import SceneTest, add_box

MARKS_S = [0.30, 0.42, 0.48, 0.52]  # a simulated 16 mm die's, rounded to 10 ms
ENDLESS_MARKS_S = [0.30, 0.34, 0.38, 1.9, 3.9, 3.95, 6.5]
LIMIT_S = 90
FARM = Path(__file__).resolve().parents[2] / "addon" / "ifa_addon" / "farm.py"


def command(file, *words):
    """Blender itself, or where bpy is a module a Python that opens the file."""
    if Path(bpy.app.binary_path).name.startswith("blender"):
        start = [bpy.app.binary_path, "-b", "--factory-startup", str(file), "--python", str(FARM)]
    else:
        code = (
            "import bpy, runpy, sys; bpy.ops.wm.open_mainfile(filepath=sys.argv[1]); "
            f"runpy.run_path({str(FARM)!r}, run_name='__main__')"
        )
        start = [sys.executable, "-c", code, str(file)]
    return [*start, "--", *words]


def keys_digest(obj):
    state = hashlib.sha256()
    for curve in compat.fcurves(obj.animation_data.action, obj):
        for name in ("co", "handle_left", "handle_right"):
            data = np.empty(2 * len(curve.keyframe_points), dtype=np.float32)
            curve.keyframe_points.foreach_get(name, data)
            state.update(data.tobytes())
    return state.hexdigest()


class FarmTest(SceneTest):
    def setUp(self):
        super().setUp()
        folder = TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def save(self, marks_s, name="würfel wurf.blend"):
        """A scene with one body, saved under a name that is not plain ASCII."""
        self.obj = add_box("die", (0.016, 0.016, 0.016))
        scene.add_marks(self.scene, marks_s)
        path = self.folder / name
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        return path

    def run_farm(self, path, *words):
        done = subprocess.run(
            command(path, *words), capture_output=True, text=True, timeout=LIMIT_S
        )
        return done.returncode, done.stdout

    def test_the_keys_are_those_of_a_session(self):
        path = self.save(MARKS_S)
        out = self.folder / "gelöst.blend"
        code, output = self.run_farm(path, "--save", str(out))
        self.assertEqual(code, 0, output)
        self.assertRegex(output, r"ifa: +\d+ %")
        self.assertIn("ifa: die: Solved", output)
        bpy.ops.ifa.solve()
        here = keys_digest(self.obj)
        bpy.ops.wm.open_mainfile(filepath=str(out))
        self.assertEqual(keys_digest(bpy.data.objects["die"]), here)

    def test_bad_marks_are_named_and_nothing_is_saved(self):
        path = self.save([0.3, 0.3])
        before = path.read_bytes()
        code, output = self.run_farm(path)
        self.assertEqual(code, 2, output)
        self.assertIn("'hit 1'", output)
        self.assertEqual(path.read_bytes(), before)

    def test_a_body_that_is_not_there(self):
        code, output = self.run_farm(self.save(MARKS_S), "--bodies", "ghost")
        self.assertEqual(code, 2, output)
        self.assertIn("'ghost'", output)

    def test_no_acceptable_motion_is_still_saved(self):
        self.scene.ifa.sound_source = "NONE"
        path = self.save([0.30, 0.34, 0.38, 1.78])  # rebounds from 2.4 m after 1 cm
        self.obj.ifa.time_budget_s = 0.5
        bpy.ops.wm.save_mainfile()
        code, output = self.run_farm(path)
        self.assertEqual(code, 3, output)
        bpy.ops.wm.open_mainfile(filepath=str(path))
        self.assertIsNotNone(bpy.data.objects["die"].animation_data)

    @unittest.skipIf(os.geteuid() == 0, "root may write anywhere")
    def test_a_folder_that_is_read_only(self):
        path = self.save(MARKS_S)
        closed = self.folder / "closed"
        closed.mkdir(mode=0o500)
        code, output = self.run_farm(path, "--save", str(closed / "out.blend"))
        self.assertEqual(code, 2, output)

    def test_a_seed_that_no_property_holds(self):
        code, output = self.run_farm(self.save(MARKS_S), "--seed", "3000000000")
        self.assertEqual(code, 2, output)

    def test_a_file_where_a_folder_should_be(self):
        path = self.save(MARKS_S)
        code, output = self.run_farm(path, "--save", str(path / "out.blend"))
        self.assertEqual(code, 2, output)
        self.assertIn("not a folder", output)

    def test_a_folder_that_is_not_there(self):
        code, output = self.run_farm(self.save(MARKS_S), "--save", "/nowhere/out.blend")
        self.assertEqual(code, 2, output)
        self.assertIn("/nowhere", output)

    def test_a_signal_cancels_and_saves_nothing(self):
        path = self.save(ENDLESS_MARKS_S)
        self.obj.ifa.time_budget_s = 60.0
        bpy.ops.wm.save_mainfile()
        before = path.read_bytes()
        running = subprocess.Popen(command(path), stdout=subprocess.PIPE, text=True)
        try:
            for line in running.stdout:
                if line.startswith("ifa:"):
                    break
            running.send_signal(signal.SIGTERM)
            began = time.monotonic()
            output = running.stdout.read()
            running.wait(timeout=LIMIT_S)
        finally:
            running.kill()
            running.stdout.close()
        self.assertEqual(running.returncode, 4, output)
        self.assertLess(time.monotonic() - began, LIMIT_S)
        self.assertEqual(path.read_bytes(), before)
