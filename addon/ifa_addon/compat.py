# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between versions of Blender, found by testing for the feature, never the version."""

from __future__ import annotations

import bpy


def fcurves(action, obj):
    """The F-curve collection of `obj` in `action`; slotted Actions keep one for each slot."""
    if hasattr(action, "fcurves"):
        return action.fcurves
    slot = obj.animation_data.action_slot
    if slot is None:
        slot = action.slots.new(id_type="OBJECT", name=obj.name)
        obj.animation_data.action_slot = slot
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(slot, ensure=True).fcurves


def sound_strips(scene) -> list:
    """Every sound strip of the sequencer, those inside meta strips too, in order of start."""
    editor = scene.sequence_editor
    if editor is None:
        return []
    strips = editor.strips_all if hasattr(editor, "strips_all") else editor.sequences_all
    return sorted((s for s in strips if s.type == "SOUND"), key=lambda s: (s.frame_start, s.name))


def strip_speed(strip) -> float:
    """How much faster than recorded the strip plays."""
    for name in ("pitch", "speed_factor"):
        if hasattr(strip, name):
            return float(getattr(strip, name))
    return 1.0


def draw_progress(layout, fraction: float, text: str) -> None:
    """A progress bar, drawn by a read-only slider where layouts have none of their own."""
    if hasattr(layout, "progress"):
        layout.progress(factor=fraction, text=text)
    else:
        layout.prop(bpy.context.window_manager, "ifa_progress", text=text, slider=True)


def redraw_views() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
