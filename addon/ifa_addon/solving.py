# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve, cancel, clear, and stepping through takes."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, IntProperty

from . import compat, core, job, preferences, results, scene, work, writing

POLL_S = 0.1


def load_core(operator):
    """The package ifa, or None after telling the user why not."""
    try:
        return core.load(preferences.core_path())
    except core.CoreMissing as error:
        operator.report({"ERROR"}, str(error))
        return None


def no(cls, reason: str) -> bool:
    """For poll: False, and why the button is grey."""
    cls.poll_message_set(reason)
    return False


def read(context, obj) -> core.Inputs:
    return scene.read_inputs(context.scene, obj, context.evaluated_depsgraph_get())


class JobOperator:
    """Work for some bodies: in a thread where there is a window, blocking without one.

    A subclass says which `bodies`, what to `call` for each (work.solve, ...), and what to do with
    one result (`take_in`), on the main thread.
    """

    doing = "Solving"
    _job = None
    _timer = None
    _scene = ""
    _tasks: tuple[work.Task, ...] = ()

    @classmethod
    def poll(cls, context):
        obj = context.object
        if obj is None or obj.type != "MESH":
            return no(cls, "Select a mesh object")
        if obj.mode != "OBJECT":
            return no(cls, "Leave edit mode first")
        return job.running() is None or no(cls, "A solve is running")

    def execute(self, context):
        """Blocks: scripts and background runs. The window's path is invoke()."""
        work_ = self._prepare(context)
        if work_ is None:
            return {"CANCELLED"}
        return self._end(context, work_[0]())

    def invoke(self, context, event):
        work_ = self._prepare(context)
        if work_ is None:
            return {"CANCELLED"}
        call, progress = work_
        names = [task.name for task in self._tasks]
        label = names[0] if len(names) == 1 else f"{len(names)} bodies"
        self._job = job.start(call, progress, f"{self.doing} {label}")
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(POLL_S, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _prepare(self, context):
        """What the thread runs and its progress; None after saying what is wrong."""
        job.failure = ""
        ifa = load_core(self)
        if ifa is None:
            return None
        tasks = []
        for obj in self.bodies(context):
            try:
                tasks.append(work.Task(obj.name, read(context, obj)))
            except scene.SceneError as error:
                self._fail(str(error))
                return None
        if not tasks:
            self._fail("There is no body to solve.")
            return None
        self._tasks, self._scene = tuple(tasks), context.scene.name
        progress = work.Progress(ifa, len(tasks))
        return (lambda: work.run(ifa, tasks, progress, self.call)), progress

    def modal(self, context, event):
        running = self._job
        if event.type == "ESC" and event.value == "PRESS":
            running.cancel()
        if running.cancelled:  # here, by the panel's button, or by loading a file
            self._stop(context)
            self.report({"INFO"}, "Cancelled: nothing was written")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not running.done:
            context.window_manager.progress_update(round(100 * running.fraction))
            compat.redraw_views()
            return {"PASS_THROUGH"}
        self._stop(context)
        if running.error is not None:
            return self._fail(str(running.error))
        return self._end(context, running.result, check=True)

    def cancel(self, context):
        """Blender ends the operator itself: another file, a closed window."""
        if self._job is not None:
            self._job.cancel()
            self._stop(context)

    def _stop(self, context) -> None:
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            self._timer = None
        job.clear(self._job)
        compat.redraw_views()

    def _end(self, context, found, check: bool = False):
        """Take in what was found, body by body; what went wrong is told together."""
        failures, written = [], 0
        for task, result in zip(self._tasks, found, strict=True):
            try:
                if isinstance(result, Exception):
                    raise scene.SceneError(core.readable(result, task.inputs.mark_names))
                obj = context.scene.objects.get(task.name)
                if check:
                    self._check_still_asked(context, obj, task)
                self.take_in(context, obj, task, result)
                written += 1
            except (scene.SceneError, ValueError) as error:
                named = str(error) if len(self._tasks) == 1 else f"{task.name}: {error}"
                failures.append(named)
        compat.redraw_views()
        if failures and not written:
            return self._fail(" ".join(failures))
        if failures:
            job.failure = " ".join(failures)
            self.report({"WARNING"}, job.failure)
        return {"FINISHED"}

    def _check_still_asked(self, context, obj, task: work.Task) -> None:
        """Raises SceneError unless the scene still asks for what was solved."""
        if obj is None or context.scene.name != self._scene:
            raise scene.SceneError(f"'{task.name}' is gone: nothing was written.")
        try:
            inputs = read(context, obj)
        except scene.SceneError as error:
            raise scene.SceneError(f"{error} Nothing was written.") from error
        if inputs.digest() != task.inputs.digest():
            raise scene.SceneError(
                f"The marks, the sound or '{task.name}' changed during the solve: nothing was "
                "written, solve again."
            )

    def _fail(self, message: str):
        job.failure = message
        compat.redraw_views()
        self.report({"ERROR"}, message)
        return {"CANCELLED"}


class IFA_OT_solve(JobOperator, bpy.types.Operator):
    bl_idname = "ifa.solve"
    bl_label = "Solve"
    bl_description = (
        "Find a motion of each selected body whose contacts land on its marks, and key it "
        "(Esc cancels)"
    )
    bl_options = {"UNDO"}

    bodies_from: EnumProperty(
        name="Bodies",
        description="Which bodies are solved",
        items=[
            ("ACTIVE", "Active", "The active object alone"),
            ("SELECTED", "Selected", "The active object and the other selected bodies"),
            ("ALL", "All", "Every body of the scene"),
        ],
        default="SELECTED",
        options={"SKIP_SAVE"},
    )

    call = staticmethod(work.solve)

    def bodies(self, context):
        return scene.bodies(context, self.bodies_from)

    def take_in(self, context, obj, task, outcome) -> None:
        kept = results.Kept(task.inputs, outcome)
        for note in writing.write(context, obj, kept):
            self.report({"WARNING"}, note)
        own = obj.ifa
        named = own.result if len(self._tasks) == 1 else f"{obj.name}: {own.result}"
        self.report({"INFO"} if own.succeeded else {"WARNING"}, named)


class IFA_OT_predict(JobOperator, bpy.types.Operator):
    bl_idname = "ifa.predict"
    bl_label = "Predict"
    bl_description = "Say how long each quality would take and how good its motion would be"

    doing = "Predicting"
    call = staticmethod(work.predict)

    def bodies(self, context):
        return scene.bodies(context, "ACTIVE")

    def take_in(self, context, obj, task, predictions) -> None:
        results.keep_predictions(obj.name, task.inputs, predictions)


class IFA_OT_cancel(bpy.types.Operator):
    bl_idname = "ifa.cancel"
    bl_label = "Cancel"
    bl_description = "Stop the running solve; nothing is written"

    @classmethod
    def poll(cls, context):
        return job.running() is not None

    def execute(self, context):
        job.running().cancel()
        return {"FINISHED"}


class IFA_OT_take(bpy.types.Operator):
    bl_idname = "ifa.take"
    bl_label = "Step Through Takes"
    bl_description = "Key the next or the previous take of the last solve"
    bl_options = {"UNDO"}

    step: IntProperty(name="Step", description="1 is the next take, -1 the previous", default=1)

    @classmethod
    def poll(cls, context):
        obj = context.object
        kept = results.of(obj.name) if obj is not None and obj.type == "MESH" else None
        if kept is None or obj.ifa.action is None:
            return no(cls, "Solve first: takes are kept until the file is closed")
        if len(kept.outcome.solution.takes) < 2:
            return no(cls, "The last solve has one take: ask for more in Solve Options")
        return job.running() is None or no(cls, "A solve is running")

    def execute(self, context):
        obj = context.object
        takes = len(results.of(obj.name).outcome.solution.takes)
        return key_again(self, context, (obj.ifa.take - 1 + self.step) % takes)


def key_again(operator, context, take: int):
    """Key a take of the latest solve, if the scene still asks for that."""
    obj = context.object
    kept = results.of(obj.name)
    try:
        if read(context, obj).digest() != kept.inputs.digest():
            raise scene.SceneError(
                f"The marks, the sound or '{obj.name}' changed since the solve: solve again."
            )
        notes = writing.write(context, obj, results.Kept(kept.inputs, kept.outcome, take))
    except (scene.SceneError, ValueError) as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    for note in notes:
        operator.report({"WARNING"}, note)
    compat.redraw_views()
    return {"FINISHED"}


class IFA_OT_bake(bpy.types.Operator):
    bl_idname = "ifa.bake"
    bl_label = "Bake Again"
    bl_description = (
        "Key the motion of the last solve again, for the frame rate, sound, place and key options "
        "of now; nothing is solved"
    )
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        obj = context.object
        if obj is None or obj.type != "MESH" or results.of(obj.name) is None:
            return no(cls, "Solve first: motions are kept until the file is closed")
        return job.running() is None or no(cls, "A solve is running")

    def execute(self, context):
        return key_again(self, context, max(0, context.object.ifa.take - 1))


class IFA_OT_clear(bpy.types.Operator):
    bl_idname = "ifa.clear"
    bl_label = "Clear"
    bl_description = (
        "Remove the keyed motion of the selected bodies; transform, rotation mode and Action "
        "return to what they were before it"
    )
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        obj = context.object
        return obj is not None and obj.ifa.keyed  # its Action may have been deleted

    def execute(self, context):
        job.failure = ""
        for obj in scene.bodies(context, "SELECTED"):
            writing.clear(obj)
        compat.redraw_views()
        return {"FINISHED"}


CLASSES = (IFA_OT_solve, IFA_OT_predict, IFA_OT_cancel, IFA_OT_take, IFA_OT_bake, IFA_OT_clear)
