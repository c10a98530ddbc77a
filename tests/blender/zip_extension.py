"""The zip for Blender 4.2 and later, installed by Blender's own extension operators."""

from __future__ import annotations

import subprocess
import sys
import tomllib
import unittest
import zipfile

import addon_utils
import bpy
from installed import VERSION, ZIP, Installed, Path

ID = "inverse_foley_animation"


class ExtensionTest(Installed, unittest.TestCase):
    package = f"bl_ext.user_default.{ID}"

    @classmethod
    def install(cls) -> None:
        addon_utils.enable("bl_pkg")  # part of Blender; off where bpy is a module
        bpy.ops.extensions.package_install_files(
            filepath=str(ZIP), repo="user_default", enable_on_install=True
        )

    @classmethod
    def remove(cls) -> None:
        repos = [repo.module for repo in bpy.context.preferences.extensions.repos]
        bpy.ops.extensions.package_uninstall(repo_index=repos.index("user_default"), pkg_id=ID)

    @classmethod
    def folder(cls) -> Path:
        return Path(bpy.utils.user_resource("EXTENSIONS"))

    def version(self) -> str:
        manifest = Path(self.module.__file__).with_name("blender_manifest.toml")
        return tomllib.loads(manifest.read_text())["version"]


class ManifestTest(unittest.TestCase):
    def test_blenders_own_check(self) -> None:
        tool = Path(addon_utils.enable("bl_pkg").__file__).parent / "cli" / "blender_ext.py"
        command = [sys.executable, str(tool), "validate", str(ZIP)]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("Success", done.stdout)

    def test_what_blender_asks_of_extensions(self) -> None:
        with zipfile.ZipFile(ZIP) as archive:
            manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
            names = set(archive.namelist())
        self.assertEqual(manifest["version"], VERSION)
        self.assertNotIn("blender", (manifest["id"] + manifest["name"]).lower())
        self.assertIn("SPDX:GPL-3.0-or-later", manifest["license"])
        wheels = {wheel.removeprefix("./") for wheel in manifest["wheels"]}
        self.assertEqual(wheels, {name for name in names if name.endswith(".whl")})
        self.assertNotIn("network", manifest["permissions"])
