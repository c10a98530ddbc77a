# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings and results kept in the .blend. What is running is never among them (see job.py)."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import job, live

# What a resin die lands on: restitution and friction to start from, the same estimates as those of
# ifa.bodies. Material "Fit" refines them.
SURFACES = {
    "DESK": ("Desk", 0.50, 0.25),
    "WOOD": ("Wood", 0.45, 0.30),
    "CARPET": ("Carpet", 0.15, 0.55),
}


def _apply_surface(self, context) -> None:
    key = self.surface
    if key in SURFACES:
        _, self.restitution, self.friction = SURFACES[key]
        # Setting the first of the two has made it "Custom" for a moment.
        if self.surface != key:
            self.surface = key


def _leave_preset(self, context) -> None:
    if self.surface in SURFACES:
        _, restitution, friction = SURFACES[self.surface]
        if abs(self.restitution - restitution) > 1e-6 or abs(self.friction - friction) > 1e-6:
            self.surface = "CUSTOM"


# Keys of each quality, mm and degrees: those of ifa.ACCURACIES.
KEY_TOLERANCES = {"DRAFT": (0.2, 0.1), "GOOD": (0.05, 0.02), "BEST": (0.01, 0.005)}


def _apply_accuracy(self, context) -> None:
    self.position_tolerance_mm, self.rotation_tolerance_deg = KEY_TOLERANCES[self.accuracy]


class IFA_PG_mark(bpy.types.PropertyGroup):
    """How one mark was met by the motion that is keyed; `name` is the marker's."""

    time_s: FloatProperty(options={"HIDDEN"})
    error_ms: FloatProperty(options={"HIDDEN"})
    light: StringProperty(options={"HIDDEN"})  # see results.MarkReport
    text: StringProperty(options={"HIDDEN"})


class IFA_PG_repair(bpy.types.PropertyGroup):
    """A change that makes the marks work; `name` is its sentence."""

    kind: StringProperty(options={"HIDDEN"})
    mark: StringProperty(options={"HIDDEN"})  # name of the marker it concerns
    mark_time_s: FloatProperty(options={"HIDDEN"})  # as it was
    value: FloatProperty(options={"HIDDEN"})  # new: time in s, energy in J, restitution, friction
    plausible: BoolProperty(options={"HIDDEN"})
    seed: IntProperty(options={"HIDDEN"})


class IFA_PG_object(bpy.types.PropertyGroup):
    """Per object, so that every body can have its own marks and seed."""

    is_body: BoolProperty(
        name="Solve with Others",
        description="Solve this body too when others are solved and it is selected",
        default=False,
    )

    mass_from: EnumProperty(
        name="Mass From",
        description="What the body's mass follows from",
        items=[
            ("DENSITY", "Density", "The mass is the mesh's volume times the density"),
            ("MASS", "Mass", "The mass is given; the mesh gives its distribution"),
        ],
    )
    density_kg_m3: FloatProperty(
        name="kg / m³",
        description="Density of the solid in kg per cubic metre",
        default=1200.0,
        min=1.0,
        soft_max=20000.0,
    )
    mass_kg: FloatProperty(
        name="kg",
        description="Mass in kg",
        default=0.005,
        min=1e-6,
        soft_max=100.0,
        precision=4,
    )
    surface: EnumProperty(
        name="Surface",
        description="Sets restitution and friction to typical values",
        items=[("CUSTOM", "Custom", "Restitution and friction as set below")]
        + [(k, label, f"Restitution {e}, friction {mu}") for k, (label, e, mu) in SURFACES.items()],
        update=_apply_surface,
    )
    restitution: FloatProperty(
        name="Restitution",
        description="Rebound speed over approach speed: 0 is clay, 1 is a perfect bounce",
        default=0.5,
        min=0.0,
        max=1.0,
        update=_leave_preset,
    )
    friction: FloatProperty(
        name="Friction",
        description="Coulomb friction between body and ground",
        default=0.3,
        min=0.0,
        soft_max=1.5,
        update=_leave_preset,
    )
    material: EnumProperty(
        name="Material",
        description="Whether restitution and friction are kept, or chosen to suit the marks",
        items=[
            ("GIVEN", "Given", "Use restitution and friction as set"),
            ("FIT", "Fit", "Choose restitution and friction that suit the marks"),
        ],
    )
    marker_filter: StringProperty(
        name="Filter",
        description="Use the timeline markers whose names begin with this text (or match it, with "
        "* and ?). Empty: all. Markers that switch cameras never count",
    )
    ending: EnumProperty(
        name="Ending",
        description="What the body does after the last mark",
        items=[
            ("REST", "Rest", "The body comes to rest after the last mark without a further hit"),
            ("OPEN", "Open", "Nothing is asked after the last mark"),
        ],
    )
    accuracy: EnumProperty(
        name="Quality",
        description="How hard the search tries, and how closely keys follow the motion",
        items=[
            (
                "DRAFT",
                "Draft",
                "The first motion that meets the marks; few keys (0.2 mm, 0.1 degree)",
            ),
            ("GOOD", "Good", "The first motion that a viewer would believe (0.05 mm, 0.02 degree)"),
            ("BEST", "Best", "Larger searches go on for a better motion (0.01 mm, 0.005 degree)"),
        ],
        default="GOOD",
        update=_apply_accuracy,
    )
    seed: IntProperty(name="Seed", description="Another seed gives another take", min=0)
    time_budget_s: FloatProperty(
        name="Seconds",
        description="No larger search is begun once this many seconds are spent; 0: as the quality "
        "has it",
        default=0.0,
        min=0.0,
        soft_max=120.0,
    )
    takes: IntProperty(
        name="Takes",
        description="Look for so many clearly different motions; there may be fewer",
        default=1,
        min=1,
        soft_max=10,
        max=100,
    )
    energy_gain_j: FloatProperty(
        name="Energy Gain",
        description="How much energy a contact may add, in J: for rhythms that no thrown body has",
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=5,
    )
    place: EnumProperty(
        name="Place",
        description="Where on the ground the motion takes place",
        items=[
            ("OBJECT", "At the Object", "The first contact is below where the object stood"),
            ("WORLD", "At the World Origin", "As solved, around the world's origin"),
        ],
    )
    key_times: EnumProperty(
        name="Keys",
        description="Where keys stand",
        items=[
            (
                "SUBFRAME",
                "Exact",
                "Each contact on its fractional frame, in time with the sound to a millisecond",
            ),
            (
                "FRAME",
                "Whole Frames",
                "Each contact on the nearest whole frame, half a frame off at most; the motion "
                "between runs a little faster or slower",
            ),
            (
                "PICTURE_FIRST",
                "Picture First",
                "Each contact on the last whole frame before its sound, or on the next one where "
                "it would be seen more than 15 ms before it is heard",
            ),
        ],
    )
    position_tolerance_mm: FloatProperty(
        name="mm",
        description="How far the keyed position may be from the solved one, between keys too, in "
        "mm. Larger makes fewer keys",
        default=0.05,
        min=0.001,
        max=10.0,
        soft_max=1.0,
        precision=3,
    )
    rotation_tolerance_deg: FloatProperty(
        name="degrees",
        description="How far the keyed rotation may be from the solved one, between keys too, in "
        "degrees. Larger makes fewer keys",
        default=0.02,
        min=0.001,
        max=5.0,
        soft_max=1.0,
        precision=3,
    )

    # Of the last bake. Kept in the file, so that Clear works after loading it again.
    keyed: BoolProperty(options={"HIDDEN"})
    action: PointerProperty(type=bpy.types.Action, options={"HIDDEN"})
    result: StringProperty(options={"HIDDEN"})
    succeeded: BoolProperty(options={"HIDDEN"})
    plausible: BoolProperty(options={"HIDDEN"})
    score: FloatProperty(options={"HIDDEN"})
    worst_error_ms: FloatProperty(options={"HIDDEN"})
    solve_s: FloatProperty(options={"HIDDEN"})
    error: FloatProperty(options={"HIDDEN"})  # 1 - Score
    effects: StringProperty(options={"HIDDEN"})
    keyed_as: StringProperty(options={"HIDDEN"})  # see writing.key_state
    take: IntProperty(options={"HIDDEN"})
    takes_found: IntProperty(options={"HIDDEN"})
    mark_reports: CollectionProperty(type=IFA_PG_mark, options={"HIDDEN"})
    mark_index: IntProperty(options={"HIDDEN"})  # the row that is chosen in the list
    repairs: CollectionProperty(type=IFA_PG_repair, options={"HIDDEN"})
    before_action: PointerProperty(type=bpy.types.Action, options={"HIDDEN"})
    before_had_animation_data: BoolProperty(options={"HIDDEN"})
    before_rotation_mode: StringProperty(options={"HIDDEN"})
    before_location: FloatVectorProperty(options={"HIDDEN"})
    before_quaternion: FloatVectorProperty(size=4, options={"HIDDEN"})
    before_delta_quaternion: FloatVectorProperty(
        size=4, default=(1.0, 0.0, 0.0, 0.0), options={"HIDDEN"}
    )
    before_euler: FloatVectorProperty(options={"HIDDEN"})
    before_axis_angle: FloatVectorProperty(size=4, options={"HIDDEN"})


class IFA_PG_scene(bpy.types.PropertyGroup):
    """One recording for the scene."""

    sound_source: EnumProperty(
        name="Sound",
        description="Gives the marks their loudness; a strip also gives their time origin",
        items=[
            ("NONE", "None", "Times alone, from the scene's start frame"),
            ("STRIP", "Strip", "A sound strip in the sequencer; times run from its beginning"),
            ("FILE", "File", "A sound file that begins at the scene's start frame"),
        ],
    )
    sound_strip: StringProperty(
        name="Strip", description="Name of the sound strip; empty for the first one"
    )
    sound_file: StringProperty(name="File", description="Sound file", subtype="FILE_PATH")
    ground: PointerProperty(
        name="Ground",
        description="A flat, level mesh at whose height the motion takes place, as if it had no "
        "edges; none for z = 0",
        type=bpy.types.Object,
        poll=lambda self, obj: obj.type == "MESH",
    )


class IFA_PG_marker(bpy.types.PropertyGroup):
    """A registered property, for the markers of Blender 5 take no custom ones."""

    time_s: StringProperty(
        name="Exact Time",
        description="Seconds from time 0, as text, for a number property would round them",
        options={"HIDDEN"},
    )
    frame: IntProperty(
        name="Frame",
        description="Where the marker stood when its time was stored: elsewhere it was dragged",
        options={"HIDDEN"},
    )
    origin_frame: FloatProperty(options={"HIDDEN"})  # where time 0 was then
    by_sound: BoolProperty(options={"HIDDEN"})  # time 0 was the beginning of a sound strip


CLASSES = (
    IFA_PG_mark,
    IFA_PG_repair,
    IFA_PG_object,
    IFA_PG_scene,
    IFA_PG_marker,
)


def _progress_percent(self) -> float:
    running = job.running()
    return 100.0 * running.fraction if running else 0.0


def start() -> None:
    bpy.types.Object.ifa = PointerProperty(type=IFA_PG_object)
    bpy.types.Scene.ifa = PointerProperty(type=IFA_PG_scene)
    bpy.types.TimelineMarker.ifa = PointerProperty(type=IFA_PG_marker)
    # Of the session, not of the file: a saved toggle would come back without its timer.
    bpy.types.WindowManager.ifa_live = BoolProperty(
        name="Live",
        description="Solve again from a mark that is dragged: the motion follows",
        get=lambda self: live.is_on(),
        set=lambda self, on: live.switch(on),
    )
    bpy.types.WindowManager.ifa_progress = FloatProperty(
        name="Progress",
        description="Share of the solve that is done; Esc cancels",
        subtype="PERCENTAGE",
        min=0.0,
        max=100.0,
        precision=0,
        get=_progress_percent,
    )


def stop() -> None:
    del bpy.types.WindowManager.ifa_progress
    del bpy.types.WindowManager.ifa_live
    del bpy.types.TimelineMarker.ifa
    del bpy.types.Scene.ifa
    del bpy.types.Object.ifa
