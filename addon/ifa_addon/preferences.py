# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept for all files: where the core is."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty


class IFA_preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    core_path: StringProperty(
        name="Folder of the Package ifa",
        description="A folder that holds the Python package ifa, built for Blender's Python. "
        "Empty where Blender's Python finds it by itself",
        subtype="DIR_PATH",
    )

    def draw(self, context) -> None:
        self.layout.prop(self, "core_path")


def core_path() -> str:
    """The preference, or nothing where the add-on runs without being enabled in the preferences."""
    entry = bpy.context.preferences.addons.get(__package__)
    path = entry.preferences.core_path if entry and entry.preferences else ""
    return bpy.path.abspath(path) if path else ""


CLASSES = (IFA_preferences,)
