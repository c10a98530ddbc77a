"""Enabling and disabling the add-on, with and without the core package."""

import os
import sys
import unittest
from types import SimpleNamespace
from unittest.mock import MagicMock

import addon_utils
import bpy
import enabling
from ifa_addon import core
from support import SceneTest, add_box


class RegisterTest(unittest.TestCase):
    def test_twenty_cycles_leave_nothing(self):
        self.addCleanup(addon_utils.disable, "ifa_addon")  # even where a cycle fails
        enabling.check(self, "ifa_addon")

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

    def test_the_panel_shows_it(self):
        """By a layout that notes what is called, for a background run draws none."""
        layout = MagicMock()
        # A run without a window has a scale of 0 and no region.
        system = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))
        region = SimpleNamespace(width=240)
        context = SimpleNamespace(object=None, region=region, preferences=system)
        bpy.types.IFA_PT_main.draw(SimpleNamespace(layout=layout), context)
        labels = [call.kwargs["text"] for call in layout.mock_calls if "text" in call.kwargs]
        self.assertGreater(len(labels), 3)  # wrapped to the sidebar's width
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        self.assertIn(f"ifa is not installed for Blender's Python {version}", " ".join(labels))

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
