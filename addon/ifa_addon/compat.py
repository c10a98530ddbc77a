# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between versions of Blender, found by testing for the feature, never the version."""

from __future__ import annotations

import math

import bpy
import numpy as np

_STOCK_STEP = 16  # lengths of the curves in stock are multiples of it


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


def strips_of(editor):
    """The strips of a sequence editor, which were sequences before Blender 4.4."""
    return editor.strips if hasattr(editor, "strips") else editor.sequences


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


def enum_number(name: str, item: str) -> int:
    """What foreach_set takes for an item of the property `name` of Keyframe."""
    return bpy.types.Keyframe.bl_rna.properties[name].enum_items[item].value


def _free_in_bulk(points) -> bool:
    """Whether foreach_set sets handle types, or takes them and does nothing."""
    for side in ("handle_left_type", "handle_right_type"):
        free = np.full(len(points), enum_number(side, "FREE"), dtype=np.int32)
        points.foreach_set(side, free)
    return len(points) > 0 and points[0].handle_left_type == "FREE"


class ActionStock:
    """Gives out Actions and keyframe points with free handles, as long as it is open.

    Early versions ignore foreach_set of handle types, and to set them one by one takes longer than
    everything else. There, new Actions are copies of a prepared one a little longer, whose excess
    points go: among many objects there are few lengths.
    """

    def __init__(self, channels: dict[str, int]) -> None:
        self._channels = channels  # curves of each data path
        self._stock: dict[tuple[int, ...], bpy.types.Action] = {}
        self._asked: set[tuple[int, ...]] = set()
        self._copied: bpy.types.Action | None = None  # the last one: all its handles are free

    def __enter__(self) -> ActionStock:
        return self

    def __exit__(self, *error) -> None:
        for action in self._stock.values():
            bpy.data.actions.remove(action)
        self._stock.clear()
        self._copied = None

    def new_action(self, name: str, lengths: dict[str, int]) -> bpy.types.Action:
        """An Action, empty or with curves of about these lengths (by data path)."""
        rounded = tuple(-(-n // _STOCK_STEP) * _STOCK_STEP for n in lengths.values())
        # Slotted Actions came after handle types could be set in bulk.
        if "slots" in bpy.types.Action.bl_rna.properties or rounded not in self._asked:
            self._asked.add(rounded)  # one object alone needs no prepared Action
            return bpy.data.actions.new(name)
        if rounded not in self._stock:
            self._stock[rounded] = self._prepare(dict(zip(lengths, rounded, strict=True)))
        self._copied = self._stock[rounded].copy()
        self._copied.name = name
        return self._copied

    def _prepare(self, lengths: dict[str, int]) -> bpy.types.Action:
        action = bpy.data.actions.new("IFA stock")
        for path, count in lengths.items():
            for index in range(self._channels[path]):
                curve = new_fcurve(action.fcurves, path, index, "Object Transforms")
                self.free_points(curve, count)
        return action

    def free_points(self, curve, count: int):
        """The curve's keyframe points, made `count` Bezier ones with free handles."""
        points = curve.keyframe_points
        if curve.id_data == self._copied:
            for _ in range(len(points) - count):
                points.remove(points[-1], fast=True)
            return points
        points.clear()
        points.add(count)
        if not _free_in_bulk(points):
            for point in points:
                point.handle_left_type = "FREE"
                point.handle_right_type = "FREE"
        return points


def sound_strips(scene) -> list:
    """Every sound strip of the sequencer, those inside meta strips too, in order of start."""
    editor = scene.sequence_editor
    if editor is None:
        return []
    strips = editor.strips_all if hasattr(editor, "strips_all") else editor.sequences_all
    return sorted((s for s in strips if s.type == "SOUND"), key=lambda s: (strip_start(s), s.name))


def write_mp4(render, path: str) -> None:
    """Render settings for H.264 with AAC sound."""
    settings = render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "VIDEO"
    settings.file_format = "FFMPEG"
    settings.color_mode = "RGB"
    video = render.ffmpeg
    video.format, video.codec = "MPEG4", "H264"
    video.constant_rate_factor, video.ffmpeg_preset = "MEDIUM", "GOOD"
    video.audio_codec, video.audio_bitrate = "AAC", 192
    render.use_file_extension = False
    render.filepath = path


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


_LIGHTS = {"MET": "COLOR_04", "SHOWS": "COLOR_03", "MISSED": "COLOR_01"}  # green, yellow, red


def light_icon(light: str) -> str:
    """An icon in the colour of a traffic light; strips' colours, whose icons were renamed."""
    icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
    for prefix in ("STRIP_", "SEQUENCE_"):
        if prefix + _LIGHTS.get(light, "COLOR_09") in icons:
            return prefix + _LIGHTS.get(light, "COLOR_09")
    return "DOT"


def redraw_views() -> None:
    kinds = {"VIEW_3D", "DOPESHEET_EDITOR", "SEQUENCE_EDITOR", "GRAPH_EDITOR"}
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in kinds:
                area.tag_redraw()


def modal_runs(context) -> bool | None:
    """Whether a modal operator such as a drag is under way; None where Blender cannot tell."""
    windows = context.window_manager.windows
    if bpy.app.background or not windows:
        return False
    if not hasattr(windows[0], "modal_operators"):
        return None
    return any(len(window.modal_operators) for window in windows)


def undo_push(context, message: str) -> None:
    """An undo step of its own, where there is a window."""
    windows = context.window_manager.windows
    if bpy.app.background or not windows:
        return
    with context.temp_override(window=context.window or windows[0]):
        if bpy.ops.ed.undo_push.poll():
            bpy.ops.ed.undo_push(message=message)


def fill_disk(x: float, y: float, radius: float, colour: tuple[float, ...]) -> None:
    """A filled disk in pixels of the region that is being drawn."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    try:
        shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    except (ValueError, SystemError):  # named so before Blender 4
        shader = gpu.shader.from_builtin("2D_UNIFORM_COLOR")
    rim = [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in _TURNS]
    triangles = [((x, y), rim[i], rim[i + 1]) for i in range(len(rim) - 1)]
    points = [corner for triangle in triangles for corner in triangle]
    if hasattr(shader, "attrs_info_get") and dict(shader.attrs_info_get()).get("pos") != "VEC2":
        points = [(px, py, 0.0) for px, py in points]
    batch = batch_for_shader(shader, "TRIS", {"pos": points})
    shader.bind()
    shader.uniform_float("color", colour)
    gpu.state.blend_set("ALPHA")
    batch.draw(shader)
    gpu.state.blend_set("NONE")


_TURNS = [2 * math.pi * k / 16 for k in range(17)]


def font_size(pixels: int) -> None:
    import blf

    try:
        blf.size(0, pixels)
    except TypeError:  # a third argument before Blender 4
        blf.size(0, pixels, 72)
