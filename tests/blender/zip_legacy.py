"""The zip for Blender before 4.2, installed as the preferences do it."""

from __future__ import annotations

import unittest

import addon_utils
import bpy
from installed import ZIP, Installed, Path


class LegacyTest(Installed, unittest.TestCase):
    package = "ifa_addon"

    @classmethod
    def install(cls) -> None:
        bpy.ops.preferences.addon_install(filepath=str(ZIP))
        bpy.ops.preferences.addon_enable(module=cls.package)

    @classmethod
    def remove(cls) -> None:
        addon_utils.disable(cls.package, default_set=True)
        # The operator redraws the area that it was pressed in.
        window = bpy.data.window_managers[0].windows[0]
        with bpy.context.temp_override(window=window, area=window.screen.areas[0]):
            bpy.ops.preferences.addon_remove(module=cls.package)

    @classmethod
    def folder(cls) -> Path:
        return Path(bpy.utils.user_resource("SCRIPTS")) / "addons" / cls.package

    def version(self) -> str:
        return ".".join(map(str, self.module.bl_info["version"]))
