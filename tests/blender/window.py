"""Drives a real window: opens the tab, presses Solve, Esc and Ctrl+Z, and takes a picture.

Run by run.py under Xvfb with simulated events. Arguments: the picture's path, the report's path.
"""

from __future__ import annotations

import json
import sys
import time
import traceback
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "addon")]

import addon_utils  # noqa: E402
import bpy  # noqa: E402
from ifa_addon import job, panel, scene  # noqa: E402
from support import add_box, fcurves  # noqa: E402

PICTURE, REPORT = sys.argv[sys.argv.index("--") + 1 :]
MARKS_S = [0.30, 0.42, 0.48, 0.52]  # a simulated 16 mm die's, rounded to 10 ms
# Late gaps that grow past any energy the first leaves: the search climbs on until cancelled.
ENDLESS_MARKS_S = [0.30, 0.34, 0.38, 1.9, 3.9, 3.95, 6.5]
KEYED_WITHIN_S = 40.0
passed: list[str] = []
failed: list[str] = []
draws = 0


def check(name: str, good: bool) -> None:
    (passed if good else failed).append(name)
    print(f"{name} ... {'ok' if good else 'FAIL'}", flush=True)


def count_draws() -> None:
    """How a click on a tab is known to have found ours: its panel is drawn."""
    original = panel.IFA_PT_main.draw

    def draw(self, context):
        global draws
        draws += 1
        original(self, context)

    panel.IFA_PT_main.draw = draw


def view3d():
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    return window, area, next(r for r in area.regions if r.type == "UI")


def click(window, x, y):
    for kind, value in (("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")):
        window.event_simulate(type=kind, value=value, x=int(x), y=int(y))
        yield 0.15


def press(window, key, **modifiers):
    for value in ("PRESS", "RELEASE"):
        window.event_simulate(type=key, value=value, **modifiers)
        yield 0.05


def screenshot(window, area, path):
    with bpy.context.temp_override(window=window, screen=window.screen, area=area):
        bpy.ops.screen.screenshot(filepath=str(path))


def set_up():
    """A die above the ground, close to the view, and one marker per mark."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    die = add_box(size=(0.016, 0.016, 0.016))
    die.location = (0.0, 0.0, 0.05)
    modifier = die.modifiers.new("round", "BEVEL")
    modifier.width = 0.0015
    modifier.segments = 3
    bpy.context.scene.frame_end = 24
    scene.add_marks(bpy.context.scene, MARKS_S)
    bpy.ops.ed.undo_push(message="set up")
    return die


def close_up(window, area):
    timeline = next(a for a in window.screen.areas if a.type == "DOPESHEET_EDITOR")
    with bpy.context.temp_override(window=window, screen=window.screen, area=timeline):
        edge = timeline.y + timeline.height
        bpy.ops.screen.area_move(x=timeline.x + 300, y=edge, delta=64)  # room for the markers
    region = next(r for r in timeline.regions if r.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=timeline, region=region):
        bpy.ops.action.view_all()
    space = area.spaces.active
    space.show_region_ui = True
    space.overlay.grid_scale = 0.01
    space.clip_start = 0.001
    view = space.region_3d
    view.view_location = (0.0, 0.0, 0.03)
    view.view_distance = 0.3
    bpy.context.preferences.view.show_splash = False


def open_tab(window, region):
    """Click down the strip of tabs until ours is drawn."""
    x = region.x + region.width - 10
    for step in range(3, 60):
        yield from click(window, x, region.y + region.height - 12 * step)
        if draws:
            return


def press_solve(window, region):
    """Click down the upper part of the panel until a solve runs or has run."""
    job.failure = ""
    for depth in range(34, 90, 6):
        before = bpy.data.objects["die"].ifa.action
        x, y = region.x + region.width * 0.45, region.y + region.height - depth
        yield from click(window, x, y)
        keyed = bpy.data.objects["die"].ifa.action != before
        if job.current is not None or keyed or job.failure:
            return


def drive():
    addon_utils.enable("ifa_addon")
    count_draws()
    bpy.context.preferences.view.show_splash = False
    yield 0.5
    window, area, region = view3d()
    set_up()
    close_up(window, area)
    yield 0.5
    window, area, region = view3d()
    yield from open_tab(window, region)
    check("the tab opens", draws > 0)

    yield from press_solve(window, region)
    started = time.monotonic()
    while not bpy.data.objects["die"].ifa.action and time.monotonic() - started < KEYED_WITHIN_S:
        yield 0.1
    die = bpy.data.objects["die"]
    check("Solve keys the object", die.ifa.action is not None and len(fcurves(die)) == 7)
    check("the button is free again", job.running() is None)
    bpy.context.scene.frame_set(round(1 + 24 * MARKS_S[1]))
    yield 0.5
    screenshot(window, area, PICTURE)
    check("a picture is taken", Path(PICTURE).stat().st_size > 10_000)

    # Over the 3D view, Ctrl+Z takes the bake back in one step.
    window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=area.x + 400, y=area.y + 300)
    yield 0.2
    yield from press(window, "Z", ctrl=True)
    yield 0.5
    die = bpy.data.objects["die"]
    check("one Ctrl+Z undoes the bake", die.ifa.action is None and die.animation_data is None)

    bpy.context.scene.timeline_markers.clear()
    scene.add_marks(bpy.context.scene, ENDLESS_MARKS_S)
    die.ifa.time_budget_s = 60.0
    bpy.ops.ed.undo_push(message="endless marks")
    yield 0.3
    window, area, region = view3d()
    yield from press_solve(window, region)
    check("a long solve runs", job.running() is not None)
    yield 0.5
    screenshot(window, area, PICTURE.replace(".png", "_running.png"))
    window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=area.x + 400, y=area.y + 300)
    yield 0.1
    cancelled = job.current
    asked = time.monotonic()
    yield from press(window, "ESC")
    while job.current is not None and time.monotonic() - asked < 5.0:
        yield 0.05
    check("Esc frees the button", job.current is None)
    while cancelled is not None and not cancelled.done and time.monotonic() - asked < 5.0:
        yield 0.05
    check("Esc ends the thread", cancelled is not None and cancelled.done)
    check("Esc writes nothing", bpy.data.objects["die"].animation_data is None)

    yield from solve_and_move_a_marker()
    yield from solve_and_load_a_file()


def solve_and_move_a_marker():
    """What was solved is not written once the scene asks for something else."""
    bpy.context.scene.timeline_markers.clear()
    scene.add_marks(bpy.context.scene, MARKS_S)
    window, _, region = view3d()
    original = job.start

    def start_and_move(*arguments):
        bpy.context.scene.timeline_markers[2].frame += 5
        return original(*arguments)

    job.start = start_and_move
    yield from press_solve(window, region)
    job.start = original
    started = time.monotonic()
    while job.current is not None and time.monotonic() - started < KEYED_WITHIN_S:
        yield 0.1
    check("a stale motion is refused", "changed during the solve" in job.failure)
    check("a stale motion is not written", bpy.data.objects["die"].animation_data is None)


def solve_and_load_a_file():
    """A solve ends with the file it belongs to, and the next file can solve at once."""
    bpy.context.scene.timeline_markers.clear()
    scene.add_marks(bpy.context.scene, ENDLESS_MARKS_S)
    window, _, region = view3d()
    yield from press_solve(window, region)
    ended = job.current
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield 0.5
    check("loading a file frees the button", ended is not None and job.current is None)
    started = time.monotonic()
    while ended is not None and not ended.done and time.monotonic() - started < 5.0:
        yield 0.05
    check("loading a file ends the thread", ended is not None and ended.done)


def finish() -> None:
    counts = {"passed": len(passed), "failed": len(failed), "skipped": 0}
    Path(REPORT).write_text(json.dumps(counts))
    bpy.ops.wm.quit_blender()


def main() -> None:
    steps = drive()

    def step():
        try:
            return next(steps)
        except StopIteration:
            pass
        except Exception:
            traceback.print_exc()
            failed.append("the script")
        finish()
        return None

    bpy.app.timers.register(step, first_interval=1.0, persistent=True)


main()
