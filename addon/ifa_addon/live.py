# SPDX-License-Identifier: GPL-3.0-or-later
"""While the toggle is on: a mark that is dragged is solved again from there, and the keys follow.

A timer looks at the marks of the bodies that were solved in this session. It exists only while the
toggle is on; neither is saved.
"""

from __future__ import annotations

import time

import bpy

from . import compat, core, job, preferences, results, scene, work, writing

LOOK_S = 0.1
SETTLED_S = 0.15  # a mark that has not moved for so long is let go of, or held still

_on = False
_seen: dict[str, tuple[str, float]] = {}  # of each object: what it asked for last, and since when
_passed: dict[str, str] = {}  # what is not to be solved: it failed, was cancelled or undone to
_job: job.Job | None = None
_tasks: list[work.Task] = []


def is_on() -> bool:
    return _on


def switch(on: bool) -> None:
    """Start or stop looking."""
    global _on
    if on and not _on:
        _on = True
        bpy.app.timers.register(look, first_interval=LOOK_S, persistent=True)
        for handlers in (bpy.app.handlers.undo_post, bpy.app.handlers.redo_post):
            handlers.append(_after_undo)
    elif not on:
        stop()


def stop() -> None:
    """For the toggle, for disabling the add-on, and for another file."""
    global _on, _job
    _on = False
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
    for handlers in (bpy.app.handlers.undo_post, bpy.app.handlers.redo_post):
        if _after_undo in handlers:
            handlers.remove(_after_undo)
    if _job is not None:
        _job.cancel()
        job.clear(_job)
        _job = None
    _seen.clear()
    _passed.clear()


def look() -> float | None:
    """One look; returns when to look again, None where the toggle is off."""
    global _job
    context = bpy.context
    if not _on:
        return None
    if context.scene is None:
        return LOOK_S
    if _job is not None:
        if _job.cancelled:
            _pass_over(context, _tasks)
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


def _asked(context, obj) -> dict:
    """What can be read at each look; raises SceneError."""
    time_ = scene.timing(context.scene)
    return scene.asked(obj, scene.checked_marks(context.scene, obj.ifa.marker_filter, time_))


def _solved(context) -> list[tuple]:
    """Bodies that were solved in this session, each with its latest solve and what it asks now."""
    found = []
    for obj in context.scene.objects:
        kept = results.of(obj.name) if obj.type == "MESH" else None
        if kept is None or obj.ifa.action is None:
            continue
        try:
            found.append((obj, kept, _asked(context, obj)))
        except scene.SceneError:
            continue  # such as two marks on one frame, on the way past
    return found


def _changed(context) -> list[work.Task]:
    """The bodies whose marks have moved since they were solved, and stand still now."""
    now, tasks = time.monotonic(), []
    for obj, kept, asked in _solved(context):
        key = repr(asked)
        same = all(getattr(kept.inputs, name) == value for name, value in asked.items())
        if same or key == _passed.get(obj.name):
            continue
        if _seen.get(obj.name, ("", 0.0))[0] != key:
            _seen[obj.name] = (key, now)
        elif now - _seen[obj.name][1] >= SETTLED_S:
            try:
                graph = context.evaluated_depsgraph_get()
                inputs = scene.read_inputs(context.scene, obj, graph)
            except scene.SceneError:
                continue
            tasks.append(work.Task(obj.name, inputs, _reusable(kept, inputs)))
    return tasks


def _reusable(kept: results.Kept, inputs: core.Inputs):
    """The earlier solution, where only the marks' times differ."""
    same = inputs.but_for_marks() == kept.inputs.but_for_marks()
    return kept.outcome.solution if same else None


def _pass_over(context, tasks: list[work.Task]) -> None:
    """What these ask for is not tried again before it changes."""
    names = {task.name for task in tasks}
    for obj, _, asked in _solved(context):
        if obj.name in names:
            _passed[obj.name] = repr(asked)


@bpy.app.handlers.persistent
def _after_undo(*_) -> None:
    """What an undo brings back had its keys too, and is not solved once more."""
    context = bpy.context
    if context.scene is not None:
        for obj, _, asked in _solved(context):
            _passed[obj.name] = repr(asked)


def _start(tasks: list[work.Task]) -> None:
    global _job
    try:
        ifa = core.load(preferences.core_path())
    except core.CoreMissing:
        return
    _tasks[:] = tasks
    progress = work.Progress(ifa, len(tasks))
    call = work.solve
    _job = job.start(lambda: work.run(ifa, tasks, progress, call), progress, "Following the marks")


def _take_in(context, done: job.Job) -> None:
    if done.error is not None:
        job.failure = str(done.error)
        _pass_over(context, _tasks)
        return
    dragging = compat.modal_runs(context)
    graph = context.evaluated_depsgraph_get()
    written, failures = False, []
    for task, outcome in zip(_tasks, done.result, strict=True):
        obj = context.scene.objects.get(task.name)
        if obj is None:
            continue
        try:
            if isinstance(outcome, Exception):
                raise scene.SceneError(core.readable(outcome, task.inputs.mark_names))
            if scene.read_inputs(context.scene, obj, graph).digest() != task.inputs.digest():
                continue  # moved on meanwhile: it is solved again
            # Of a drag that may yet be cancelled no marker must keep the time.
            store = dragging is False
            writing.write(context, obj, results.Kept(task.inputs, outcome), store=store)
            written = True
        except (scene.SceneError, ValueError) as error:
            _pass_over(context, [task])
            failures.append(f"{task.name}: {error}")
    job.failure = " ".join(failures)
    if written and dragging is False:
        compat.undo_push(context, "Inverse-Foley: Live")
    compat.redraw_views()
