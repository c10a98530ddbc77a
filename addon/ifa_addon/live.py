# SPDX-License-Identifier: GPL-3.0-or-later
"""While the toggle is on: a mark that is dragged is solved again from there, and the keys follow.

A timer looks at the marks of the bodies that were solved in this session. It exists only while the
toggle is on; nothing is saved of it.
"""

from __future__ import annotations

import time

import bpy

from . import compat, core, job, properties, results, scene, work, writing

LOOK_S = 0.1
SETTLED_S = 0.15  # a mark that has not moved for so long is let go of, or held still

_seen: dict[str, tuple[str, float]] = {}  # of each object: what it asked for last, and since when
_refused: dict[str, str] = {}  # what could not be solved is not tried again
_job: job.Job | None = None
_tasks: list[work.Task] = []


def switch(on: bool) -> None:
    """Start or stop looking."""
    if on and not bpy.app.timers.is_registered(look):
        bpy.app.timers.register(look, first_interval=LOOK_S)
    elif not on:
        stop()


def stop() -> None:
    """For the toggle, for disabling the add-on, and for another file."""
    global _job
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
    if _job is not None:
        _job.cancel()
        job.clear(_job)
        _job = None
    _seen.clear()
    _refused.clear()


def look() -> float | None:
    """One look; returns when to look again, None where the toggle is off."""
    global _job
    context = bpy.context
    if context.scene is None or not context.scene.ifa.live:
        return None
    if _job is not None:
        if _job.cancelled:
            _job = None
        elif _job.done:
            done, _job = _job, None
            job.clear(done)
            _take_in(context, done)
        return LOOK_S
    if job.running() is None:
        tasks = _changed(context)
        if tasks:
            _start(tasks)
    return LOOK_S


def _changed(context) -> list[work.Task]:
    """The bodies whose marks have moved since they were solved, and stand still now."""
    graph = context.evaluated_depsgraph_get()
    now, tasks = time.monotonic(), []
    for obj in context.scene.objects:
        kept = results.of(obj.name) if obj.type == "MESH" else None
        if kept is None or obj.ifa.action is None:
            continue
        try:
            inputs = scene.read_inputs(context.scene, obj, graph)
        except scene.SceneError:
            continue  # such as two marks on one frame, on the way past
        asked = inputs.digest()
        if asked == kept.inputs.digest() or asked == _refused.get(obj.name):
            continue
        if _seen.get(obj.name, ("", 0.0))[0] != asked:
            _seen[obj.name] = (asked, now)
        elif now - _seen[obj.name][1] >= SETTLED_S:
            tasks.append(work.Task(obj.name, inputs, _reusable(kept, inputs)))
    return tasks


def _reusable(kept: results.Kept, inputs: core.Inputs):
    """The earlier solution, where only the marks' times differ."""
    same = inputs.but_for_marks() == kept.inputs.but_for_marks()
    return kept.outcome.solution if same else None


def _start(tasks: list[work.Task]) -> None:
    global _job
    try:
        ifa = core.load(properties.core_path())
    except core.CoreMissing:
        return
    _tasks[:] = tasks
    progress = work.Progress(ifa, len(tasks))
    _job = job.start(lambda: work.run(ifa, tasks, progress, work.solve), progress, "live")


def _take_in(context, done: job.Job) -> None:
    if done.error is not None:
        return
    graph = context.evaluated_depsgraph_get()
    written = False
    for task, outcome in zip(_tasks, done.result, strict=True):
        obj = context.scene.objects.get(task.name)
        if obj is None:
            continue
        try:
            if isinstance(outcome, Exception):
                raise scene.SceneError(core.readable(outcome, task.inputs.mark_names))
            if scene.read_inputs(context.scene, obj, graph).digest() != task.inputs.digest():
                continue  # moved on meanwhile: it is solved again
            writing.write(context, obj, results.Kept(task.inputs, outcome))
            written = True
        except (scene.SceneError, ValueError) as error:
            _refused[task.name] = task.inputs.digest()
            job.failure = f"{task.name}: {error}"
    if written:
        job.failure = ""
        compat.undo_push(context, "Inverse-Foley: Live")
    compat.redraw_views()
