"""Enabling and disabling the add-on, with and without the core package."""

import os
import sys
import threading
import unittest

import addon_utils
import bpy
from ifa_addon import core
from support import SceneTest, add_box


def state():
    handlers = {
        name: len(getattr(bpy.app.handlers, name))
        for name in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, name), list)
    }
    names = [name for name in dir(bpy.types) if "ifa" in name.lower()]
    properties = [
        (owner.__name__, name)
        for owner in (bpy.types.Object, bpy.types.Scene, bpy.types.WindowManager)
        for name in dir(owner)
        if name.startswith("ifa")
    ]
    return handlers, names, properties, threading.active_count(), list(sys.path)


class RegisterTest(unittest.TestCase):
    def test_twenty_cycles_leave_nothing(self):
        addon_utils.enable("ifa_addon")
        addon_utils.disable("ifa_addon")
        before = state()
        for _ in range(20):
            module = addon_utils.enable("ifa_addon")
            self.assertIsNotNone(module)
            self.assertTrue(hasattr(bpy.types, "IFA_PT_main"))
            core.load()
            addon_utils.disable("ifa_addon")
        self.assertEqual(state(), before)
        self.assertEqual(before[1], [])
        self.assertEqual(before[2], [])

    def test_bl_info(self):
        import ifa_addon

        self.assertEqual(ifa_addon.bl_info["blender"], (3, 4, 0))
        self.assertLessEqual(ifa_addon.bl_info["blender"], bpy.app.version)


class MissingCoreTest(SceneTest):
    def setUp(self):
        super().setUp()
        saved = {name: m for name, m in sys.modules.items() if name.split(".")[0] == "ifa"}
        path, variable = list(sys.path), os.environ.pop("IFA_PYTHONPATH", "")

        def restore():
            sys.modules.update(saved)
            sys.path[:] = path
            os.environ["IFA_PYTHONPATH"] = variable

        self.addCleanup(restore)
        for name in saved:
            del sys.modules[name]
        sys.path[:] = [p for p in path if not os.path.isdir(os.path.join(p, "ifa"))]

    def test_the_message_says_what_to_do(self):
        with self.assertRaisesRegex(core.CoreMissing, "ifa is not installed.*IFA_PYTHONPATH"):
            core.load()

    def test_solve_reports_it(self):
        add_box()
        self.add_markers([10, 20])
        with self.assertRaisesRegex(RuntimeError, "ifa is not installed"):
            bpy.ops.ifa.solve()

    def test_an_empty_folder_named_ifa_is_no_core(self):
        import tempfile

        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "ifa"))
            with self.assertRaisesRegex(core.CoreMissing, "ifa is not installed"):
                core.load(folder)
            sys.modules.pop("ifa", None)
