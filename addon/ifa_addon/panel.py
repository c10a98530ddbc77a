# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab IFA in the sidebars of the 3D view, the Dope Sheet and the Sequencer."""

from __future__ import annotations

import textwrap

import bpy

from . import compat, core, job, preferences, presets, results, scene, writing


def paragraph(layout, context, text: str, icon: str = "NONE") -> None:
    """A wrapped text: labels cut what does not fit the sidebar."""
    width = max(16, int(context.region.width / (7.5 * context.preferences.system.ui_scale)) - 7)
    column = layout.column(align=True)
    for line in textwrap.wrap(text, width):
        column.label(text=line, icon=icon)
        icon = "BLANK1"


def settings_layout(panel):
    """Names to the left of their values, without dots for keys: none of these is animated."""
    panel.layout.use_property_split = True
    panel.layout.use_property_decorate = False
    return panel.layout


class IFA_UL_marks(bpy.types.UIList):
    """A light, the marker's name and the error of each mark."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0):
        row = layout.row(align=True)
        row.label(text=item.name, icon=compat.light_icon(item.light))
        side = row.row()
        side.alignment = "RIGHT"
        side.label(text="missed" if item.light == "MISSED" else f"{item.error_ms:+.2f} ms")


class Main:
    bl_label = "Inverse-Foley Animation"

    def draw(self, context):
        layout = self.layout
        obj = context.object
        try:
            core.load(preferences.core_path())
        except core.CoreMissing as error:
            paragraph(layout, context, str(error), "ERROR")
            return
        if obj is None or obj.type != "MESH":
            layout.label(text="Select a mesh object", icon="INFO")
            return
        self._draw_solve(context)
        own = obj.ifa
        if job.failure and job.running() is None:
            box = layout.box()
            box.alert = True
            paragraph(box, context, job.failure, "ERROR")
        if own.keyed:
            self._draw_result(context, own)
            self._draw_repairs(context, own)
            layout.operator("ifa.clear", icon="X")

    def _draw_solve(self, context) -> None:
        layout = self.layout
        running = job.running()
        if running is not None:
            row = layout.row(align=True)
            compat.draw_progress(row, running.fraction, running.label)
            row.operator("ifa.cancel", text="", icon="X")
            return
        self._draw_quality(context)
        others = len(scene.bodies(context, "SELECTED")) - 1
        row = layout.row(align=True)
        row.scale_y = 1.4
        text = "Solve" if others < 1 else f"Solve {others + 1} Bodies"
        row.operator("ifa.solve", text=text, icon="PLAY")
        row.prop(context.window_manager, "ifa_live", text="", icon="AUTO", toggle=True)

    def _draw_quality(self, context) -> None:
        """The three stops, each with its seconds and its error before solving."""
        own = context.object.ifa
        column = self.layout.column(align=True)
        row = column.row(align=True)
        row.prop(own, "accuracy", expand=True)
        predicted = _predictions(context, context.object)
        if not predicted:
            column.operator("ifa.predict", text="Predict Seconds and Error", icon="TIME")
            return
        stops = [predicted[name] for name in ("draft", "good", "best")]
        seconds, errors = column.row(align=True), column.row(align=True)
        for stop in stops:
            seconds.label(text=f"{stop.time_s:.2g} s")
            errors.label(text=f"error {stop.error:.2g}")

    def _draw_result(self, context, own) -> None:
        box = self.layout.box()
        if not own.succeeded:
            alert = box.column()
            alert.alert = True
            paragraph(alert, context, own.result, "ERROR")
        else:
            word = "plausible" if own.plausible else "not plausible"
            box.label(text=f"Succeeded, {word}", icon="CHECKMARK" if own.plausible else "INFO")
        column = box.column(align=True)
        column.label(text=f"Score {own.score:.2f} (error {own.error:.2g})")
        column.label(text=f"Worst mark {own.worst_error_ms:.2f} ms off")
        column.label(text=f"Solved in {own.solve_s:.2f} s")
        if own.takes_found > 1:
            row = box.row(align=True)
            row.operator("ifa.take", text="", icon="TRIA_LEFT").step = -1
            row.label(text=f"Take {own.take} of {own.takes_found}")
            row.operator("ifa.take", text="", icon="TRIA_RIGHT").step = 1

        if own.keyed_as != writing.key_state(context.scene, context.object):
            stale = box.column()
            stale.alert = True
            text = "Keyed for another frame rate, sound, place or other key options"
            paragraph(stale, context, text, "ERROR")
        box.operator("ifa.bake", icon="KEYINGSET")

    def _draw_repairs(self, context, own) -> None:
        if own.plausible:
            return
        box = self.layout.box()
        if not own.repairs:
            box.operator("ifa.explain", icon="TOOL_SETTINGS")
            return
        box.label(text="Repairs that work", icon="TOOL_SETTINGS")
        column = box.column(align=True)
        for index, repair in enumerate(own.repairs):
            icon = "CHECKMARK" if repair.plausible else "DOT"
            text = _shortened(repair.name, context)
            column.operator("ifa.repair", text=text, icon=icon).index = index


def _predictions(context, obj) -> dict:
    try:
        time = scene.timing(context.scene)
        found = scene.marks(context.scene, obj.ifa.marker_filter, time)
    except scene.SceneError:
        return {}
    return results.predictions_for(obj.name, scene.asked(obj, found))


def _shortened(text: str, context) -> str:
    width = max(20, int(context.region.width / (7.5 * context.preferences.system.ui_scale)) - 8)
    return text if len(text) <= width else text[: width - 1] + "…"


class Marks:
    bl_label = "Marks and Sound"

    def draw(self, context):
        layout = settings_layout(self)
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
            paragraph(layout, context, str(error), "ERROR")
            return
        if not found:
            paragraph(layout, context, "No marks: put a timeline marker on each contact", "INFO")
            return
        plural = "s" if len(found) > 1 else ""
        layout.label(text=f"{len(found)} mark{plural}", icon="MARKER_HLT")
        if own.mark_reports:
            layout.template_list(
                "IFA_UL_marks", "", own, "mark_reports", own, "mark_index", rows=3, maxrows=8
            )
            if own.mark_index < len(own.mark_reports):
                chosen = own.mark_reports[own.mark_index]
                paragraph(layout, context, f"{chosen.name}: {chosen.text}")
        keyed = [report.time_s for report in own.mark_reports]  # Live may have followed the drag
        dragged = [
            mark.name
            for mark in found
            if mark.dragged and not any(abs(mark.time_s - t) < 1e-4 for t in keyed)
        ]
        if dragged:
            names = ", ".join(dragged)
            paragraph(layout, context, f"Moved since solved or loaded: {names}", "ERROR")
        if any(mark.exact for mark in found):
            layout.operator("ifa.use_frames")


class Body:
    bl_label = "Body"

    def draw_header_preset(self, context):
        presets.IFA_PT_body_presets.draw_panel_header(self.layout)

    def draw(self, context):
        layout = settings_layout(self)
        own = context.object.ifa
        layout.label(text=context.object.name, icon="MESH_CUBE")
        layout.prop(own, "mass_from")
        layout.prop(own, "density_kg_m3" if own.mass_from == "DENSITY" else "mass_kg")
        layout.prop(own, "surface")
        layout.prop(own, "restitution")
        layout.prop(own, "friction")
        layout.prop(own, "material")
        layout.prop(own, "is_body")


class Options:
    bl_label = "Solve Options"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = settings_layout(self)
        own = context.object.ifa
        for name in ("ending", "seed", "takes", "time_budget_s", "energy_gain_j"):
            layout.prop(own, name)


class Keys:
    bl_label = "Place and Keys"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = settings_layout(self)
        own = context.object.ifa
        layout.prop(context.scene.ifa, "ground")
        for name in ("place", "key_times", "position_tolerance_mm", "rotation_tolerance_deg"):
            layout.prop(own, name)


class _Child:
    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH"


_SPACES = {"": "VIEW_3D", "_dopesheet": "DOPESHEET_EDITOR", "_sequencer": "SEQUENCE_EDITOR"}


class Effects:
    bl_label = "Effects"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        own = context.object.ifa
        if not own.effects:
            self.layout.label(text="Solve to see which effects it called for", icon="INFO")
            return
        for part in own.effects.split("; ", 1):
            paragraph(self.layout, context, part[:1].upper() + part[1:])


_PARTS = {
    "main": Main,
    "marks": Marks,
    "body": Body,
    "options": Options,
    "keys": Keys,
    "effects": Effects,
}


def _panels() -> tuple[type, ...]:
    """Each part once for each sidebar: Blender wants a class for every space."""
    made = []
    for ending, space in _SPACES.items():
        for name, part in _PARTS.items():
            place = {"bl_space_type": space, "bl_region_type": "UI", "bl_category": "IFA"}
            bases = (part, bpy.types.Panel)
            if part is not Main:
                place["bl_parent_id"] = f"IFA_PT_main{ending}"
                bases = (_Child, *bases)
            made.append(type(f"IFA_PT_{name}{ending}", bases, place))
    return tuple(made)


PANELS = _panels()
CLASSES = (IFA_UL_marks, *PANELS)
