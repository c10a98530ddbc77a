# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between versions of Blender, found by testing for the feature, never the version."""

from __future__ import annotations

import bpy


def fcurves(action, obj):
    """The F-curve collection of `obj` in `action`; slotted Actions keep one for each slot."""
    if not hasattr(action, "slots"):
        return action.fcurves
    slot = obj.animation_data.action_slot
    if slot is None:
        slot = action.slots.new(id_type="OBJECT", name=obj.name)
        obj.animation_data.action_slot = slot
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(slot, ensure=True).fcurves


def new_fcurve(curves, path: str, index: int, group: str):
    """A new F-curve; slotted Actions call its group by another name, or did not take one yet."""
    parameters = curves.bl_rna.functions["new"].parameters
    for name in ("action_group", "group_name"):
        if name in parameters:
            return curves.new(path, index=index, **{name: group})
    return curves.new(path, index=index)


def assign_action(animation_data, action) -> None:
    """Set the Action, and of a slotted one a slot, without which it moves nothing."""
    animation_data.action = action
    if action is not None and getattr(animation_data, "action_slot", True) is None:
        suitable = animation_data.action_suitable_slots
        if suitable:
            animation_data.action_slot = suitable[0]


def sound_strips(scene) -> list:
    """Every sound strip of the sequencer, those inside meta strips too, in order of start."""
    editor = scene.sequence_editor
    if editor is None:
        return []
    strips = editor.strips_all if hasattr(editor, "strips_all") else editor.sequences_all
    return sorted((s for s in strips if s.type == "SOUND"), key=lambda s: (strip_start(s), s.name))


def strip_start(strip) -> float:
    """The frame where the recording begins, wherever the strip is trimmed to."""
    name = "content_start" if hasattr(strip, "content_start") else "frame_start"
    return float(getattr(strip, name))


def plays_as_recorded(strip) -> bool:
    """Whether the strip plays at the recording's own speed; retiming keys may bend it anywhere."""
    for name in ("pitch", "speed_factor"):
        if abs(float(getattr(strip, name, 1.0)) - 1.0) > 1e-6:
            return False
    return len(getattr(strip, "retiming_keys", ())) == 0


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
