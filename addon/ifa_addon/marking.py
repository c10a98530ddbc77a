# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks from a file, and the exact times that markers keep."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import scene, solving


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
        ifa = solving.load_core(self)
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


CLASSES = (IFA_OT_load_marks, IFA_OT_use_frames)
