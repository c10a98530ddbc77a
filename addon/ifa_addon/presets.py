# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of stored bodies: mass, material and surface under a name."""

from __future__ import annotations

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

FOLDER = "ifa/body"


class IFA_PT_body_presets(PresetPanel, bpy.types.Panel):
    bl_label = "Body Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "ifa.body_preset"


class IFA_OT_body_preset(AddPresetBase, bpy.types.Operator):
    bl_idname = "ifa.body_preset"
    bl_label = "Store Body Preset"
    bl_description = "Store density or mass, surface, restitution and friction under a name"
    preset_menu = "IFA_PT_body_presets"
    preset_subdir = FOLDER
    preset_defines = ["own = bpy.context.object.ifa"]
    preset_values = [
        "own.mass_from",
        "own.density_kg_m3",
        "own.mass_kg",
        "own.surface",
        "own.restitution",
        "own.friction",
        "own.material",
    ]


CLASSES = (IFA_PT_body_presets, IFA_OT_body_preset)
