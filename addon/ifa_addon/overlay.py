# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights and errors of the active body's marks, drawn in the timeline and the sequencer."""

from __future__ import annotations

import blf
import bpy

from . import compat, scene

COLOURS = {
    "MET": (0.25, 0.75, 0.3, 1.0),
    "SHOWS": (0.95, 0.7, 0.15, 1.0),
    "MISSED": (0.9, 0.25, 0.2, 1.0),
    "MOVED": (0.6, 0.6, 0.6, 1.0),
}
LIGHT_PX, TEXT_PX = 5, 11  # at a user-interface scale of 1
LEAST_APART_PX = 42  # texts nearer than this would cover each other

_SPACES = ("SpaceDopeSheetEditor", "SpaceSequenceEditor", "SpaceGraphEditor")
_handles: list[tuple[type, object]] = []


def placed(context) -> list[tuple[float, str, str]]:
    """Frame, light and text of each mark of the active body, in order of time."""
    obj = context.object
    if obj is None or obj.type != "MESH" or not obj.ifa.mark_reports:
        return []
    try:
        time = scene.timing(context.scene)
        found = scene.marks(context.scene, obj.ifa.marker_filter, time)
    except scene.SceneError:
        return []
    left = list(found)
    rows = []
    for report in obj.ifa.mark_reports:
        # Names need not be unique: of those with this one the nearest, each once.
        same = [mark for mark in left if mark.name == report.name]
        if not same:
            continue
        mark = min(same, key=lambda m: abs(m.time_s - report.time_s))
        left.remove(mark)
        if abs(mark.time_s - report.time_s) > 1e-4:  # float32 in the file
            rows.append((float(time.frame(mark.time_s)), "MOVED", "moved"))
        elif report.light == "MISSED":
            rows.append((float(time.frame(mark.time_s)), "MISSED", "missed"))
        else:
            text = f"{report.error_ms:+.2f} ms"
            rows.append((float(time.frame(mark.time_s)), report.light, text))
    return sorted(rows)


def draw() -> None:
    context = bpy.context
    rows = placed(context)
    region = context.region
    if not rows or region is None:
        return
    scale = context.preferences.system.ui_scale
    size, above = LIGHT_PX * scale, 44 * scale  # above the markers and their names
    last = -1e9
    for frame, light, text in rows:
        x, _ = region.view2d.view_to_region(frame, 0.0, clip=False)
        if not -50 < x < region.width + 50:
            continue
        compat.fill_disk(x, above, size, COLOURS[light])
        if x - last >= LEAST_APART_PX * scale or light != "MET":
            blf.color(0, *COLOURS[light])
            compat.font_size(round(TEXT_PX * scale))
            blf.position(0, x + size + 2, above - size * 0.8, 0)
            blf.draw(0, text)
            last = x


def start() -> None:
    for name in _SPACES:
        space = getattr(bpy.types, name, None)
        if space is not None:
            handle = space.draw_handler_add(draw, (), "WINDOW", "POST_PIXEL")
            _handles.append((space, handle))


def stop() -> None:
    while _handles:
        space, handle = _handles.pop()
        space.draw_handler_remove(handle, "WINDOW")
