# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab IFA in the 3D view's sidebar."""

from __future__ import annotations

import textwrap

import bpy

from . import compat, core, job, properties, scene


class _Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "IFA"

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH"


def _paragraph(layout, context, text: str, icon: str = "NONE") -> None:
    """A wrapped text: labels cut what does not fit the sidebar."""
    width = max(16, int(context.region.width / (7.5 * context.preferences.system.ui_scale)) - 4)
    column = layout.column(align=True)
    for line in textwrap.wrap(text, width):
        column.label(text=line, icon=icon)
        icon = "BLANK1"


class IFA_PT_main(_Panel, bpy.types.Panel):
    bl_label = "Inverse-Foley Animation"

    @classmethod
    def poll(cls, context):
        return True

    def draw(self, context):
        layout = self.layout
        obj = context.object
        try:
            core.load(properties.core_path())
        except core.CoreMissing as error:
            _paragraph(layout, context, str(error), "ERROR")
            return
        if obj is None or obj.type != "MESH":
            layout.label(text="Select a mesh object", icon="INFO")
            return
        running = job.running()
        if running is not None:
            row = layout.row(align=True)
            text = f"Solving {running.label}"
            compat.draw_progress(row, running.fraction, text)
            row.operator("ifa.cancel", text="", icon="X")
        else:
            row = layout.row()
            row.scale_y = 1.4
            row.operator("ifa.solve", icon="PLAY")
        if job.failure and running is None:
            box = layout.box()
            box.alert = True
            _paragraph(box, context, job.failure, "ERROR")
        own = obj.ifa
        if own.action is not None:
            self._draw_result(context, own)
            layout.operator("ifa.clear", icon="X")

    def _draw_result(self, context, own) -> None:
        box = self.layout.box()
        if not own.succeeded:
            box.alert = True
            _paragraph(box, context, own.result, "ERROR")
            return
        box.label(text="Succeeded", icon="CHECKMARK")
        box.label(
            text="Plausible" if own.plausible else "Not plausible",
            icon="CHECKMARK" if own.plausible else "ERROR",
        )
        column = box.column(align=True)
        column.label(text=f"Score: {own.score:.2f}")
        column.label(text=f"Worst error: {own.worst_error_ms:.2f} ms")


class IFA_PT_body(_Panel, bpy.types.Panel):
    bl_label = "Body"
    bl_parent_id = "IFA_PT_main"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        own = context.object.ifa
        layout.label(text=context.object.name, icon="MESH_CUBE")
        layout.prop(own, "mass_from")
        layout.prop(own, "density_kg_m3" if own.mass_from == "DENSITY" else "mass_kg")
        layout.prop(own, "surface")
        layout.prop(own, "restitution")
        layout.prop(own, "friction")
        layout.prop(own, "material")


class IFA_PT_marks(_Panel, bpy.types.Panel):
    bl_label = "Marks and Sound"
    bl_parent_id = "IFA_PT_main"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        target, own = context.scene, context.object.ifa
        settings = target.ifa
        layout.prop(settings, "sound_source")
        if settings.sound_source == "STRIP" and target.sequence_editor:
            editor = target.sequence_editor
            name = "strips_all" if hasattr(editor, "strips_all") else "sequences_all"
            layout.prop_search(settings, "sound_strip", editor, name, icon="SOUND")
        elif settings.sound_source == "FILE":
            layout.prop(settings, "sound_file")
        layout.prop(own, "marker_filter", icon="FILTER")
        layout.operator("ifa.load_marks", icon="IMPORT")
        try:
            found = scene.marks(target, own.marker_filter, scene.timing(target))
        except scene.SceneError as error:
            _paragraph(layout, context, str(error), "ERROR")
            return
        if not found:
            _paragraph(layout, context, "No marks: put a timeline marker on each contact", "INFO")
            return
        plural = "s" if len(found) > 1 else ""
        layout.label(text=f"{len(found)} mark{plural}", icon="MARKER_HLT")
        dragged = [mark.name for mark in found if mark.dragged]
        if dragged:
            names = ", ".join(dragged)
            _paragraph(layout, context, f"Moved since solved or loaded: {names}", "ERROR")
        if any(mark.exact for mark in found):
            layout.operator("ifa.use_frames")


class IFA_PT_options(_Panel, bpy.types.Panel):
    bl_label = "Solve Options"
    bl_parent_id = "IFA_PT_main"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        own = context.object.ifa
        layout.prop(own, "ending")
        layout.prop(own, "place")
        layout.prop(own, "seed")
        layout.prop(own, "time_budget_s")


CLASSES = (IFA_PT_main, IFA_PT_body, IFA_PT_marks, IFA_PT_options)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
