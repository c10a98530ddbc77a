# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve, cancel, clear, and reading marks from a file."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import bake, compat, core, job, properties, scene

POLL_S = 0.1


def _load_core(operator):
    """The package ifa, or None after telling the user why not."""
    try:
        return core.load(properties.core_path())
    except core.CoreMissing as error:
        operator.report({"ERROR"}, str(error))
        return None


def _read(context, obj):
    return scene.read_inputs(context.scene, obj, context.evaluated_depsgraph_get())


class IFA_OT_solve(bpy.types.Operator):
    bl_idname = "ifa.solve"
    bl_label = "Solve"
    bl_description = (
        "Find a motion of the active object whose contacts land on the "
        "marks, and key it (Esc cancels)"
    )
    bl_options = {"UNDO"}

    _job = None
    _timer = None
    _object = ""
    _scene = ""
    _digest = ""
    _marks = ()

    @classmethod
    def poll(cls, context):
        obj = context.object
        if obj is None or obj.type != "MESH":
            return _no(cls, "Select a mesh object")
        if obj.mode != "OBJECT":
            return _no(cls, "Leave edit mode first")
        return job.running() is None or _no(cls, "A solve is running")

    def execute(self, context):
        """Blocks: scripts and background runs. The window's path is invoke()."""
        job.failure = ""
        ifa = _load_core(self)
        if ifa is None:
            return {"CANCELLED"}
        try:
            inputs = _read(context, context.object)
        except scene.SceneError as error:
            return self._fail(str(error))
        try:
            outcome = core.solve(ifa, inputs, ifa.Progress())
        except ifa.IfaError as error:
            return self._fail(core.readable(error, inputs.mark_names))
        return self._write(context, context.object, outcome)

    def invoke(self, context, event):
        job.failure = ""
        ifa = _load_core(self)
        if ifa is None:
            return {"CANCELLED"}
        try:
            inputs = _read(context, context.object)
        except scene.SceneError as error:
            return self._fail(str(error))
        self._object, self._scene = context.object.name, context.scene.name
        self._digest, self._marks = inputs.digest(), inputs.mark_names
        progress = ifa.Progress()
        self._job = job.start(lambda: core.solve(ifa, inputs, progress), progress, self._object)
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(POLL_S, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

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
            return self._fail(core.readable(running.error, self._marks))
        return self._finish(context, running.result)

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

    def _finish(self, context, outcome):
        """Write only if the scene still asks for what was solved."""
        obj = context.scene.objects.get(self._object)
        if obj is None or context.scene.name != self._scene:
            return self._fail(f"'{self._object}' is gone: nothing was written.")
        try:
            inputs = _read(context, obj)
        except scene.SceneError as error:
            return self._fail(f"{error} Nothing was written.")
        if inputs.digest() != self._digest:
            return self._fail(
                f"The marks, the sound or '{self._object}' changed during the solve: nothing was "
                "written, solve again."
            )
        return self._write(context, obj, outcome)

    def _write(self, context, obj, outcome):
        try:
            time = scene.timing(context.scene)
            made = bake.bake(context.scene, obj, outcome.solution.motion, outcome.centre_of_mass_m)
        except (scene.SceneError, ValueError) as error:
            return self._fail(str(error))
        scene.store_exact_times(context.scene, obj.ifa.marker_filter, time)
        own, solution = obj.ifa, outcome.solution
        own.succeeded, own.plausible = bool(solution.succeeded), bool(solution.plausible)
        own.score, own.worst_error_ms = float(solution.score), core.worst_error_ms(outcome)
        own.result = core.describe(outcome)
        for note in (*outcome.notes, *made.notes):
            self.report({"WARNING"}, note)
        self.report({"INFO"} if own.succeeded else {"WARNING"}, own.result)
        compat.redraw_views()
        return {"FINISHED"}

    def _fail(self, message: str):
        job.failure = message
        compat.redraw_views()
        self.report({"ERROR"}, message)
        return {"CANCELLED"}


def _no(cls, reason: str) -> bool:
    cls.poll_message_set(reason)
    return False


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


class IFA_OT_clear(bpy.types.Operator):
    bl_idname = "ifa.clear"
    bl_label = "Clear"
    bl_description = (
        "Remove the keyed motion; transform, rotation mode and Action "
        "return to what they were before it"
    )
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        obj = context.object
        return obj is not None and obj.ifa.action is not None

    def execute(self, context):
        job.failure = ""
        bake.clear(context.object)
        return {"FINISHED"}


class IFA_OT_load_marks(bpy.types.Operator, ImportHelper):
    bl_idname = "ifa.load_marks"
    bl_label = "Load Marks"
    bl_description = (
        "Add a timeline marker for each mark of a file (Audacity labels "
        "or JSON), keeping its exact time"
    )
    bl_options = {"UNDO"}

    filter_glob: StringProperty(default="*.txt;*.json", options={"HIDDEN"})
    replace: BoolProperty(
        name="Replace", description="Remove the markers that the filter finds first", default=True
    )

    @classmethod
    def poll(cls, context):
        return context.object is not None

    def execute(self, context):
        ifa = _load_core(self)
        if ifa is None:
            return {"CANCELLED"}
        target, pattern = context.scene, context.object.ifa.marker_filter
        try:
            times = ifa.Signature.read(self.filepath).times_s
            scene.timing(target)
        except (ifa.IfaError, scene.SceneError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if self.replace:
            for marker in scene.matching_markers(target, pattern):
                target.timeline_markers.remove(marker)
        prefix = pattern if pattern and not set(pattern) & set("*?[") else "hit"
        scene.add_marks(target, [float(t) for t in times], prefix)
        return {"FINISHED"}


class IFA_OT_use_frames(bpy.types.Operator):
    bl_idname = "ifa.use_frames"
    bl_label = "Use Marker Frames"
    bl_description = "Forget the stored exact times: each mark is where its marker stands"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None

    def execute(self, context):
        for marker in scene.matching_markers(context.scene, context.object.ifa.marker_filter):
            scene.forget_time(marker)
        return {"FINISHED"}


CLASSES = (IFA_OT_solve, IFA_OT_cancel, IFA_OT_clear, IFA_OT_load_marks, IFA_OT_use_frames)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
