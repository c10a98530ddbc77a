"""Driving a real window by simulated events: clicks, keys, tabs, areas, pictures."""

from __future__ import annotations

import bpy
from ifa_addon import job, panel

WAIT_S = 0.15  # for the window to take an event in
draws: dict[str, int] = {}  # of each sidebar's main panel, by its class's name


def count_draws() -> None:
    """How a click on a tab is known to have found ours: its panel is drawn."""
    for cls in panel.PANELS:
        if cls.__name__.startswith("IFA_PT_main"):
            draws[cls.__name__] = 0
            cls.draw = _counted(cls.__name__, cls.draw)


def _counted(name: str, original):
    def draw(self, context):
        draws[name] += 1
        original(self, context)

    return draw


def window():
    return bpy.context.window_manager.windows[0]


def find_area(kind: str):
    return next(a for a in window().screen.areas if a.ui_type == kind)


def sidebar(area):
    return next(r for r in area.regions if r.type == "UI")


def click(x, y):
    for kind, value in (("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")):
        window().event_simulate(type=kind, value=value, x=int(x), y=int(y))
        yield WAIT_S


def press(key, **modifiers):
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=key, value=value, **modifiers)
        yield 0.05


def move_over(area):
    x, y = area.x + area.width // 3, area.y + area.height // 2
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    yield WAIT_S


def screenshot(path) -> None:
    area = find_area("VIEW_3D")
    with bpy.context.temp_override(window=window(), screen=window().screen, area=area):
        bpy.ops.screen.screenshot(filepath=str(path))


def raise_edge(area, pixels: int) -> None:
    """Make an area taller by moving its upper edge."""
    with bpy.context.temp_override(window=window(), screen=window().screen, area=area):
        bpy.ops.screen.area_move(x=area.x + 300, y=area.y + area.height, delta=pixels)


def open_sidebars():
    """The dope sheet and the sequencer side by side below the 3D view, each with its sidebar.

    One change at a time: Blender 3.4 crashes where two meet in one step of the event loop.
    """
    below = find_area("TIMELINE")
    raise_edge(below, 300)
    yield WAIT_S
    below = find_area("TIMELINE")
    with bpy.context.temp_override(window=window(), screen=window().screen, area=below):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield WAIT_S
    for kind in ("DOPESHEET", "SEQUENCE_EDITOR"):
        find_area("TIMELINE").ui_type = kind
        yield WAIT_S
    for kind in ("VIEW_3D", "DOPESHEET", "SEQUENCE_EDITOR"):
        find_area(kind).spaces.active.show_region_ui = True
        yield WAIT_S


def open_tab(kind: str, name: str):
    """Click down the strip of tabs of an area's sidebar until our panel of that name is drawn."""
    for step in range(3, 60):
        region = sidebar(find_area(kind))
        before = draws[name]
        y = region.y + region.height - 12 * step
        if y < region.y:
            break
        yield from click(region.x + region.width - 10, y)
        if draws[name] > before:
            return


def press_solve():
    """Click down the upper part of the 3D view's panel until a solve runs or has run.

    On the way lie the three stops of quality, and a prediction, which is waited for.
    """
    job.failure = ""
    quality = bpy.data.objects["die"].ifa.accuracy
    for depth in range(34, 150, 6):
        region = sidebar(find_area("VIEW_3D"))
        before = bpy.data.objects["die"].ifa.action
        yield from click(region.x + region.width * 0.4, region.y + region.height - depth)
        while job.current is not None and not job.current.label.startswith("Solving"):
            yield WAIT_S
        if "die" not in bpy.data.objects:
            return
        keyed = bpy.data.objects["die"].ifa.action != before
        if job.current is not None or keyed or job.failure:
            bpy.data.objects["die"].ifa.accuracy = quality
            return
