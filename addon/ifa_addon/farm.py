# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves and keys bodies of a .blend without a window, for a render farm.

    blender -b scene.blend --python .../ifa_addon/farm.py -- [--bodies NAME ...] [--save FILE]
        [--seed N]

Without --bodies every body of the scene is solved (objects that were solved before, or have
*Solve with Others* on; the active object where there is none). The .blend is saved in place, or to
FILE. Progress goes to stdout. Exit codes: 0 done, 1 an error of the add-on (with its traceback), 2
bad input (nothing is saved), 3 some body has no acceptable motion (the best one is keyed and saved
all the same), 4 cancelled (nothing is saved).
"""

from __future__ import annotations

import argparse
import importlib
import os
import signal
import sys
import time
import traceback
from pathlib import Path

import bpy

DONE, FAILED, BAD_INPUT, NO_MOTION, CANCELLED = 0, 1, 2, 3, 4
POLL_S, TELL_S = 0.05, 1.0


def main(words: list[str]) -> int:
    """Solve as the words ask; the exit code. The add-on is enabled where it is not."""
    parser = argparse.ArgumentParser(prog="ifa farm", description="Solve and key bodies, headless.")
    parser.add_argument("--bodies", nargs="+", metavar="NAME", help="default: all bodies")
    parser.add_argument("--save", metavar="FILE", help="default: the .blend itself")
    parser.add_argument("--seed", type=_seed, metavar="N", help="default: each body's own")
    try:
        options = parser.parse_args(words)
    except SystemExit as ended:
        return int(ended.code or 0)
    target = options.save or bpy.data.filepath
    if not target:
        return _bad("the .blend is not saved: give --save FILE")
    folder = Path(target).resolve().parent
    if not folder.is_dir() or not os.access(folder, os.W_OK):
        return _bad(f"'{folder}' is not a folder that can be written to")
    package = _package()
    if hasattr(bpy.types.Object, "ifa"):
        return _solve(package, options, target)
    package.register()
    try:
        return _solve(package, options, target)
    finally:
        package.unregister()  # where bpy is a module, 4.5 crashes on leaving with it registered


def _seed(word: str) -> int:
    seed = int(word)
    if not 0 <= seed < 2**31:
        raise argparse.ArgumentTypeError(f"must be from 0 to {2**31 - 1}, got {word}")
    return seed


def _package():
    """The add-on, under whatever name Blender has it enabled; else by the name of its folder."""
    folder = Path(__file__).resolve().parent
    for module in list(sys.modules.values()):
        file = getattr(module, "__file__", None)
        if file and Path(file).resolve() == folder / "__init__.py":
            return module
    sys.path.insert(0, str(folder.parent))
    return importlib.import_module(folder.name)


def _solve(package, options: argparse.Namespace, target: str) -> int:
    core, job, results, scene = package.core, package.job, package.results, package.scene
    work, writing = package.work, package.writing
    context = bpy.context
    try:
        ifa = core.load(package.preferences.core_path())
        bodies = _bodies(scene, context, options.bodies)
        graph = context.evaluated_depsgraph_get()
        for obj in bodies:
            if options.seed is not None:
                obj.ifa.seed = options.seed
        tasks = [
            work.Task(obj.name, scene.read_inputs(context.scene, obj, graph)) for obj in bodies
        ]
    except (core.CoreMissing, scene.SceneError) as error:
        return _bad(str(error))
    progress = work.Progress(ifa, len(tasks))
    running = job.start(lambda: work.run(ifa, tasks, progress, work.solve), progress, "farm")
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: running.cancel())
    told = 0.0
    while not running.done:
        if time.monotonic() - told >= TELL_S:
            told = time.monotonic()
            _say(f"{100 * running.fraction:3.0f} %")
        time.sleep(POLL_S)
    job.clear(running)
    if running.cancelled:
        _say("cancelled: nothing was saved")
        return CANCELLED
    if running.error is not None:
        return _bad(str(running.error))
    code, wrong = DONE, False
    for task, outcome in zip(tasks, running.result, strict=True):
        obj = context.scene.objects[task.name]
        try:
            if isinstance(outcome, Exception):
                raise scene.SceneError(core.readable(outcome, task.inputs.mark_names))
            notes = writing.write(context, obj, results.Kept(task.inputs, outcome))
        except (scene.SceneError, ValueError) as error:
            _say(f"{task.name}: {error}")
            wrong = True
            continue
        for line in (obj.ifa.result, *notes):
            _say(f"{task.name}: {line}")
        if not obj.ifa.succeeded:
            code = NO_MOTION
    if wrong:
        return _bad("nothing was saved")
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(target).resolve()), copy=False)
    except RuntimeError as error:
        return _bad(str(error).strip())
    _say(f"saved {target}")
    return code


def _bodies(scene, context, names: list[str] | None) -> list:
    if names:
        missing = [name for name in names if name not in context.scene.objects]
        if missing:
            raise scene.SceneError(f"The scene has no object '{missing[0]}'.")
        return [context.scene.objects[name] for name in names]
    found = scene.bodies(context, "ALL") or scene.bodies(context, "ACTIVE")
    if not found:
        raise scene.SceneError("The scene has no body: name one with --bodies.")
    return found


def _say(text: str) -> None:
    print(f"ifa: {text}", flush=True)


def _bad(text: str) -> int:
    _say(text)
    return BAD_INPUT


def _main() -> int:
    """Blender leaves with 0 after an exception of a script, unless told otherwise."""
    try:
        return main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    except Exception:
        traceback.print_exc()
        return FAILED


if __name__ == "__main__":
    sys.exit(_main())
