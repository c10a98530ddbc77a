"""Drives a real window: the three sidebars, Solve, Esc, Ctrl+Z, and what may happen meanwhile.

Run by run.py under Xvfb with simulated events. Arguments: a name for the pictures (NAME_idle.png
and so on), the report's path.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
import traceback
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "addon")]

import addon_utils  # noqa: E402
import bpy  # noqa: E402
import window_support as ui  # noqa: E402
from ifa_addon import compat, job, scene  # noqa: E402
from support import add_box  # noqa: E402

PICTURE, REPORT = sys.argv[sys.argv.index("--") + 1 :]
MARKS_S = [0.30, 0.42, 0.48, 0.52]  # a simulated 16 mm die's, rounded to 10 ms
# Late gaps that grow past any energy the first leaves: the search climbs on until cancelled.
ENDLESS_MARKS_S = [0.30, 0.34, 0.38, 1.9, 3.9, 3.95, 6.5]
IMPOSSIBLE_MARKS_S = [0.30, 0.34, 0.38, 1.78]  # a rebound from 2.4 m after one from 1 cm
KEYED_WITHIN_S = 40.0
ESC_WITHIN_S = 0.5  # what a demanding user accepts
passed: list[str] = []
failed: list[str] = []


def check(name: str, good: bool) -> None:
    (passed if good else failed).append(name)
    print(f"{name} ... {'ok' if good else 'FAIL'}", flush=True)


def take_picture(name: str) -> None:
    path = Path(f"{PICTURE}_{name}.png")
    ui.screenshot(path)
    check(f"a picture is taken: {name}", path.stat().st_size > 10_000)


def wait(until, limit_s: float):
    began = time.monotonic()
    while not until() and time.monotonic() - began < limit_s:
        yield 0.05


def die():
    return bpy.data.objects["die"]


def mark(times_s) -> None:
    bpy.context.scene.timeline_markers.clear()
    scene.add_marks(bpy.context.scene, times_s)


def set_up() -> None:
    """A die above the ground, close to the view, and one marker per mark."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    made = add_box("die", (0.016, 0.016, 0.016))
    made.location = (0.0, 0.0, 0.05)
    modifier = made.modifiers.new("round", "BEVEL")
    modifier.width, modifier.segments = 0.0015, 3
    bpy.context.scene.frame_end = 24
    mark(MARKS_S)
    space = ui.find_area("VIEW_3D").spaces.active
    space.overlay.grid_scale, space.clip_start = 0.01, 0.001
    space.region_3d.view_location = (0.0, 0.0, 0.03)
    space.region_3d.view_distance = 0.3
    area = ui.find_area("DOPESHEET")
    region = next(r for r in area.regions if r.type == "WINDOW")
    with bpy.context.temp_override(window=ui.window(), area=area, region=region):
        bpy.ops.action.view_all()
    bpy.ops.ed.undo_push(message="set up")


def drive():
    addon_utils.enable("ifa_addon")
    ui.count_draws()
    bpy.context.preferences.view.show_splash = False
    yield 0.5
    yield from ui.open_sidebars()
    yield 0.5
    set_up()
    yield 0.5
    for kind, name in (
        ("VIEW_3D", "IFA_PT_main"),
        ("DOPESHEET", "IFA_PT_main_dopesheet"),
        ("SEQUENCE_EDITOR", "IFA_PT_main_sequencer"),
    ):
        yield from ui.open_tab(kind, name)
        check(f"the tab opens in {kind}", ui.draws[name] > 0)
    take_picture("idle")
    yield from solve_and_undo()
    yield from cancel()
    yield from fail()
    yield from change_meanwhile()
    yield from load_meanwhile()
    yield from quit_meanwhile()


def solve_and_undo():
    yield from ui.press_solve()
    yield from wait(lambda: die().ifa.action, KEYED_WITHIN_S)
    curves = compat.fcurves(die().ifa.action, die()) if die().ifa.action else ()
    check("Solve keys the object", len(curves) == 7)
    check("the button is free again", job.running() is None)
    bpy.context.scene.frame_set(round(1 + 24 * MARKS_S[1]))
    yield 0.5
    take_picture("solved")
    # Over the 3D view, Ctrl+Z takes the bake back in one step.
    yield from ui.move_over(ui.find_area("VIEW_3D"))
    yield from ui.press("Z", ctrl=True)
    yield 0.5
    check("one Ctrl+Z undoes the bake", not die().ifa.action and not die().animation_data)


def cancel():
    mark(ENDLESS_MARKS_S)
    die().ifa.time_budget_s = 60.0
    bpy.ops.ed.undo_push(message="endless marks")
    yield 0.3
    yield from ui.press_solve()
    check("a long solve runs", job.running() is not None)
    yield 0.5
    take_picture("running")
    yield from ui.move_over(ui.find_area("VIEW_3D"))
    cancelled, asked = job.current, time.monotonic()
    yield from ui.press("ESC")
    yield from wait(lambda: job.current is None, 5.0)
    # A figure, not a test: on a busy machine the window itself takes longer to draw.
    print(f"Esc freed the button after {time.monotonic() - asked:.2f} s (asked: {ESC_WITHIN_S} s)")
    check("Esc frees the button", job.current is None)
    yield from wait(lambda: cancelled is not None and cancelled.done, 5.0)
    check("Esc ends the thread", cancelled is not None and cancelled.done)
    check("Esc writes nothing", die().animation_data is None)


def fail():
    mark(IMPOSSIBLE_MARKS_S)
    die().ifa.time_budget_s = 0.5
    bpy.ops.ed.undo_push(message="impossible marks")
    yield from ui.press_solve()
    yield from wait(lambda: die().ifa.action, KEYED_WITHIN_S)
    yield 0.5
    check("a failure names its mark", "'hit 4'" in die().ifa.result)
    take_picture("failed")
    bpy.ops.ifa.clear()
    bpy.ops.ed.undo_push(message="clear")


def change_meanwhile():
    """What was solved is not written once the scene asks for something else, or it is gone."""
    changes = {
        "a moved marker": (lambda: move_marker(), "changed during the solve"),
        "an undo": (lambda: bpy.ops.ed.undo(), "changed during the solve"),
        "a deleted body": (lambda: bpy.data.objects.remove(die()), "is gone"),
    }
    for name, (change, told) in changes.items():
        mark(MARKS_S)
        bpy.ops.ed.undo_push(message="marks")
        die().ifa.seed += 1  # what the undo takes back
        bpy.ops.ed.undo_push(message="another seed")
        original = job.start

        def start_and_change(*arguments, change=change, original=original):
            started = original(*arguments)
            bpy.app.timers.register(lambda: change() and None, first_interval=0.0)
            return started

        job.start = start_and_change
        yield from ui.press_solve()
        job.start = original
        yield from wait(lambda: job.current is None, KEYED_WITHIN_S)
        yield 0.2
        check(f"{name} during a solve is noticed", told in job.failure)
        left = bpy.data.objects.get("die")
        check(f"{name} during a solve: nothing is written", not left or not left.animation_data)
    set_up()


def move_marker():
    bpy.context.scene.timeline_markers[2].frame += 5


def load_meanwhile():
    """A solve goes with its file: saved during it, the file opens with a free button."""
    mark(ENDLESS_MARKS_S)
    die().ifa.time_budget_s = 60.0
    yield from ui.press_solve()
    ended = job.current
    check("a solve runs while saving", ended is not None)
    path = Path(tempfile.mkdtemp(prefix="ifa-window-")) / "während.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    yield 0.5
    check("loading a file frees the button", job.current is None)
    yield from wait(lambda: ended is not None and ended.done, 5.0)
    check("loading a file ends the thread", ended is not None and ended.done)
    check("nothing of the solve is in the file", die().animation_data is None)
    check("the saved file can solve at once", bpy.ops.ifa.solve.poll())


def quit_meanwhile():
    """The report is written first: what counts is that Blender then ends, with code 0."""
    mark(ENDLESS_MARKS_S)
    die().ifa.time_budget_s = 60.0
    bpy.ops.ifa.solve("INVOKE_DEFAULT")
    check("a solve runs while quitting", job.running() is not None)
    yield 0.3


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
