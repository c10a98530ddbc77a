# SPDX-License-Identifier: GPL-3.0-or-later
"""What would help where marks cannot be met: offered as buttons, each tried beforehand."""

from __future__ import annotations

import bpy
from bpy.props import IntProperty

from . import compat, core, scene, solving, work


class IFA_OT_explain(solving.JobOperator, bpy.types.Operator):
    bl_idname = "ifa.explain"
    bl_label = "Find Repairs"
    bl_description = "Try which small changes to marks or material make a plausible motion possible"
    bl_options = {"UNDO"}

    doing = "Finding repairs for"
    call = staticmethod(work.explain)

    def bodies(self, context):
        return scene.bodies(context, "ACTIVE")

    def take_in(self, context, obj, task, explanation) -> None:
        own = obj.ifa
        own.repairs.clear()
        for repair in explanation.repairs:
            item = own.repairs.add()
            item.name = _sentence(repair, task.inputs.mark_names)
            item.kind, item.plausible = repair.kind, repair.plausible
            item.seed = repair.seed
            if repair.kind in ("shift", "drop"):
                item.mark = task.inputs.mark_names[repair.mark]
                item.mark_time_s = task.inputs.mark_times_s[repair.mark]
            item.value = {
                "shift": lambda r: float(r.marks.times_s[r.mark]),
                "drop": lambda r: 0.0,
                "energy": lambda r: float(r.energy_gain_j),
                "restitution": lambda r: float(r.body.restitution),
                "friction": lambda r: float(r.body.friction),
                "ending": lambda r: 0.0,
            }[repair.kind](repair)
        if not explanation.repairs and not explanation.plausible:
            raise scene.SceneError("No small change to the marks or the material helps.")


def _sentence(repair, names: tuple[str, ...]) -> str:
    return core.readable(ValueError(str(repair)), names)


class IFA_OT_repair(bpy.types.Operator):
    bl_idname = "ifa.repair"
    bl_label = "Apply Repair"
    bl_description = "Make this change, and solve again"
    bl_options = {"UNDO"}

    index: IntProperty(name="Repair", description="Its number in the list, from 0", min=0)

    @classmethod
    def description(cls, context, properties):
        """The whole sentence, which the button may have to cut."""
        found = context.object.ifa.repairs if context.object is not None else ()
        if properties.index < len(found):
            return f"{found[properties.index].name}. {cls.bl_description}"
        return cls.bl_description

    @classmethod
    def poll(cls, context):
        return solving.IFA_OT_solve.poll.__func__(cls, context)

    def execute(self, context):
        if not self._apply(context):
            return {"CANCELLED"}
        return bpy.ops.ifa.solve("EXEC_DEFAULT", bodies_from="ACTIVE")

    def invoke(self, context, event):
        if not self._apply(context):
            return {"CANCELLED"}
        bpy.ops.ifa.solve("INVOKE_DEFAULT", bodies_from="ACTIVE")
        return {"FINISHED"}

    def _apply(self, context) -> bool:
        own = context.object.ifa
        if self.index >= len(own.repairs):
            self.report({"ERROR"}, f"There is no repair {self.index + 1}: find repairs first.")
            return False
        repair = own.repairs[self.index]
        if repair.kind in ("shift", "drop"):
            try:
                marker = scene.marker_at(context.scene, repair.mark, repair.mark_time_s)
            except scene.SceneError as error:
                self.report({"ERROR"}, str(error))
                return False
            if repair.kind == "drop":
                context.scene.timeline_markers.remove(marker)
            else:
                scene.move_mark(context.scene, marker, repair.value)
        elif repair.kind == "ending":
            own.ending = "OPEN"
        else:
            name = {"energy": "energy_gain_j"}.get(repair.kind, repair.kind)
            setattr(own, name, repair.value)
        own.seed = repair.seed
        own.repairs.clear()
        compat.redraw_views()
        return True


CLASSES = (IFA_OT_explain, IFA_OT_repair)
