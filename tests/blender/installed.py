"""What is asked of an installed zip, whichever way it was installed.

The repository's own add-on and core are on no path here: what runs is what the zip holds.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
from pathlib import Path

import addon_utils
import bpy
import enabling
import numpy as np

ZIP = Path(os.environ["IFA_TEST_ZIP"])
LISTS = Path(__file__).resolve().parents[2] / "CMakeLists.txt"
VERSION = re.search(r"project\(ifa VERSION ([0-9.]+)", LISTS.read_text()).group(1)
PARTS = {"ifa", "ifa.libs", "__pycache__"}
MARKS_S = [0.30, 0.42, 0.48, 0.52]  # a simulated 16 mm die's, rounded to 10 ms
SIDE_M = 0.016
NETWORK_EVENTS = {"socket.connect", "socket.getaddrinfo", "socket.gethostbyname", "socket.sendto"}


def refuse_network(event: str, _) -> None:
    if event in NETWORK_EVENTS:
        raise ConnectionError(f"The add-on asked for the network: {event}")


def find_core():
    try:
        return importlib.import_module("ifa")
    except ModuleNotFoundError:
        return None


class Installed:
    """For a TestCase that sets `package`, the add-on's module name, and installs and removes it."""

    package = ""

    @classmethod
    def install(cls) -> None:
        raise NotImplementedError

    @classmethod
    def remove(cls) -> None:
        raise NotImplementedError

    @classmethod
    def folder(cls) -> Path:
        """Where the installed core must be."""
        raise NotImplementedError

    @classmethod
    def setUpClass(cls) -> None:
        if find_core() is not None:
            raise AssertionError("A core is on the path before the zip is installed")
        sys.addaudithook(refuse_network)
        cls.install()
        cls.addClassCleanup(cls.check_removal)

    @classmethod
    def check_removal(cls) -> None:
        module = sys.modules[cls.package]
        places = [Path(module.__file__).parent, Path(module.core.load().__file__).parent]
        cls.remove()
        left = [str(place) for place in places if place.exists()]
        if left or hasattr(bpy.types, "IFA_PT_main"):
            raise AssertionError(f"The removal left {left} or the add-on's classes")

    def setUp(self) -> None:
        if self.package not in bpy.context.preferences.addons:
            addon_utils.enable(self.package, default_set=True)
        self.module = sys.modules[self.package]

    def add_die(self):
        half = SIDE_M / 2
        corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        data = bpy.data.meshes.new("die")
        data.from_pydata(corners, [], faces)
        obj = bpy.data.objects.new("die", data)
        bpy.context.scene.collection.objects.link(obj)
        bpy.context.view_layer.objects.active = obj
        return obj

    def test_a_scene_is_solved(self) -> None:
        bpy.ops.wm.read_homefile(use_factory_startup=False, use_empty=True)
        scene = bpy.context.scene
        obj = self.add_die()
        self.module.scene.add_marks(scene, MARKS_S)
        self.assertEqual(bpy.ops.ifa.solve(), {"FINISHED"})
        self.assertTrue(obj.ifa.succeeded, obj.ifa.result)
        curves = self.module.compat.fcurves(obj.animation_data.action, obj)
        self.assertEqual(len(curves), 7)
        points = curves.find("location", index=2).keyframe_points
        rate = scene.render.fps / scene.render.fps_base
        contacts = np.array([p.co[0] for p in points if p.type == "EXTREME"])
        for mark in MARKS_S:
            frame = scene.frame_start + mark * rate
            self.assertLess(np.abs(contacts - frame).min() / rate, 1e-3)
        # The die moves in the evaluated scene, not only in its curves.
        heights = []
        for frame in range(scene.frame_start, scene.frame_start + 12):
            scene.frame_set(frame)
            graph = bpy.context.evaluated_depsgraph_get()
            heights.append(obj.evaluated_get(graph).matrix_world.translation.z)
        self.assertGreater(max(heights) - min(heights), SIDE_M / 4)

    def test_the_core_is_that_of_the_zip(self) -> None:
        core = self.module.core.load()
        place = Path(core.__file__).resolve()
        self.assertTrue(place.is_relative_to(self.folder().resolve()), place)
        self.assertEqual(core.__version__, VERSION)
        self.assertEqual(self.version(), VERSION)

    def version(self) -> str:
        """That of the installed add-on."""
        raise NotImplementedError

    def test_nothing_but_the_core_is_beside_it(self) -> None:
        """Above all no numpy: Blender's own must stay."""
        place = Path(self.module.core.load().__file__).resolve().parents[1]
        beside = [p.name for p in place.iterdir() if p.name.split("-")[0] not in PARTS]
        self.assertEqual(beside, [])

    def test_licences_are_there(self) -> None:
        """One text for each bundled library, by the names in the core's folder of libraries."""
        folder = Path(self.module.__file__).parent
        self.assertIn("GNU GENERAL PUBLIC LICENSE", (folder / "LICENSE").read_text())
        texts = " ".join(path.stem for path in (folder / "licences").iterdir())
        core = Path(self.module.core.load().__file__).parent
        libraries = sorted(path.name for path in core.with_name("ifa.libs").iterdir())
        self.assertGreaterEqual(len(libraries), 3)
        for library in libraries:
            stem = library.removeprefix("lib").split("-")[0].split(".")[0]
            self.assertIn(stem.lower().replace("_", "-"), texts.lower(), library)
        for part in ("eigen", "nanoflann", "pybind11", "ifa"):
            self.assertIn(part, texts)
        sources = (folder / "licences" / "SOURCES.txt").read_text()
        self.assertRegex(sources, r"libsndfile1: Debian source package libsndfile \d")

    def test_twenty_cycles_leave_nothing(self) -> None:
        enabling.check(self, self.package)
