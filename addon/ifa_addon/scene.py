# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the scene on the main thread: timing, sound, marks, body, parent space."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import pairwise
from math import isfinite
from pathlib import Path

import bpy
import numpy as np

from . import compat, core, keys

MERGE_GAP_S = 0.010  # closer marks are one event to the solver
SHEAR_TOLERANCE = 1e-4  # relative; float32 matrices of nested parents reach a few 1e-6
LEVEL_TOLERANCE_DEG = 0.1  # how far a ground may tilt
FLAT_TOLERANCE = 1e-4  # of a ground's size: how far its vertices may be from its plane


class SceneError(Exception):
    """The scene cannot be solved or keyed; one sentence that names what is wrong."""


@dataclass(frozen=True)
class Mark:
    name: str
    frame: int
    time_s: float
    exact: bool  # the time comes from the marker's stored exact time
    dragged: bool  # a stored time was set aside because the marker has moved since


def metres_per_unit(scene) -> float:
    """Blender units are metres times scale_length, unless the scene has no units."""
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else float(units.scale_length)


def sound_strip(scene):
    """The chosen sound strip, or the first one where none is named; None without any."""
    strips = compat.sound_strips(scene)
    wanted = scene.ifa.sound_strip
    if not wanted:
        return strips[0] if strips else None
    for strip in strips:
        if strip.name == wanted:
            return strip
    raise SceneError(f"Sound strip '{wanted}' is not in the sequencer.")


def timing(scene) -> keys.Timing:
    """Frames to seconds from the sound's start, or from the scene's start frame without a strip."""
    render = scene.render
    if render.frame_map_old != render.frame_map_new:
        raise SceneError(
            f"Time remapping {render.frame_map_old} to {render.frame_map_new} is on: "
            "set both to 100 in the scene's output properties."
        )
    origin = float(scene.frame_start)
    by_sound = scene.ifa.sound_source == "STRIP"
    if by_sound:
        strip = sound_strip(scene)
        if strip is None:
            raise SceneError("There is no sound strip in the sequencer: add one or turn sound off.")
        if not compat.plays_as_recorded(strip):
            raise SceneError(
                f"Sound strip '{strip.name}' plays at another speed: set it to 1 and remove the "
                "retiming keys."
            )
        origin = compat.strip_start(strip)
    return keys.Timing(render.fps / render.fps_base, origin, by_sound)


def sound(scene) -> tuple[str, bytes]:
    """Path of the sound and, for one packed into the .blend, its bytes; empty for no sound."""
    source = scene.ifa.sound_source
    if source == "NONE":
        return "", b""
    library = None
    if source == "STRIP":
        strip = sound_strip(scene)
        if strip is None:
            raise SceneError("There is no sound strip in the sequencer: add one or turn sound off.")
        data = strip.sound
        if data is None:
            raise SceneError(f"Sound strip '{strip.name}' has no sound.")
        raw, library = data.filepath, data.library
        if data.packed_file is not None:
            return raw.replace("\\", "/").removeprefix("//") or "packed.wav", data.packed_file.data
    else:
        raw = scene.ifa.sound_file
        if not raw:
            raise SceneError("No sound file is chosen: choose one or turn sound off.")
    if raw.startswith("//") and not bpy.data.filepath:
        raise SceneError(f"Sound '{raw}' is relative to a .blend that is not saved: save it first.")
    path = bpy.path.abspath(raw, library=library)
    if not Path(path).is_file():
        raise SceneError(f"Sound '{path}' does not exist.")
    return path, b""


def name_matches(name: str, pattern: str) -> bool:
    """A pattern with * or ? matches the whole name, any other matches its beginning."""
    wild = any(c in pattern for c in "*?[")
    return fnmatchcase(name, pattern if wild else pattern + "*")


def matching_markers(scene, pattern: str) -> list:
    """Markers by name, in order of time; those that switch cameras are not contact marks."""
    found = [m for m in scene.timeline_markers if not m.camera and name_matches(m.name, pattern)]
    return sorted(found, key=lambda m: (m.frame, stored_time_s(m) or 0.0, m.name))


def stored_time_s(marker) -> float | None:
    """Seconds from the time origin, never rounded to a frame, if the marker keeps them."""
    try:
        time_s = float(marker.ifa.time_s)
    except ValueError:
        return None
    return time_s if isfinite(time_s) else None


def store_time(marker, time_s: float, time: keys.Timing) -> None:
    """Keep an exact time, and what it is counted from."""
    own = marker.ifa
    own.time_s, own.frame = repr(time_s), marker.frame
    own.origin_frame, own.by_sound = time.origin_frame, time.by_sound


def forget_time(marker) -> None:
    marker.property_unset("ifa")


def read_mark(marker, time: keys.Timing) -> Mark:
    """A stored exact time holds while the marker stays where it was put, or where that time is.

    It goes along with a strip that is moved. A scene that begins on another frame, or has the sound
    from elsewhere now, does not move what its markers mark.
    """
    stored = stored_time_s(marker)
    if stored is not None:
        if not (time.by_sound and marker.ifa.by_sound):
            stored += (marker.ifa.origin_frame - time.origin_frame) / time.fps
        still = marker.frame == marker.ifa.frame
        if still or marker.frame == round(float(time.frame(stored))):
            return Mark(marker.name, marker.frame, stored, True, False)
    in_time = float(time.time_s(marker.frame))
    return Mark(marker.name, marker.frame, in_time, False, stored is not None)


def marks(scene, pattern: str, time: keys.Timing) -> list[Mark]:
    found = [read_mark(marker, time) for marker in matching_markers(scene, pattern)]
    return sorted(found, key=lambda mark: mark.time_s)


def checked_marks(scene, pattern: str, time: keys.Timing) -> list[Mark]:
    found = marks(scene, pattern, time)
    if not found:
        filtered = f" whose name begins with or matches '{pattern}'" if pattern else ""
        raise SceneError(f"No timeline markers{filtered}: put one on each contact (key M).")
    first = found[0]
    if first.time_s < 0:
        start = "the sound's start" if scene.ifa.sound_source == "STRIP" else "the scene's start"
        raise SceneError(f"Marker '{first.name}' (frame {first.frame}) lies before {start}.")
    for a, b in pairwise(found):
        gap = b.time_s - a.time_s
        if gap < MERGE_GAP_S:
            apart = "at the same time" if gap < 1e-9 else f"only {1e3 * gap:.1f} ms apart"
            raise SceneError(
                f"Markers '{a.name}' (frame {a.frame}) and '{b.name}' (frame {b.frame}) are "
                f"{apart}: contacts need {1e3 * MERGE_GAP_S:.0f} ms between them."
            )
    return found


def store_exact_times(scene, pattern: str, time: keys.Timing) -> None:
    """Keep each mark's time on its marker, so that a later drag can be told."""
    for marker in matching_markers(scene, pattern):
        store_time(marker, read_mark(marker, time).time_s, time)


def add_marks(scene, times_s, prefix: str = "hit") -> None:
    """New timeline markers at exact times (seconds from the time origin)."""
    time = timing(scene)
    width = len(str(len(times_s)))
    for i, time_s in enumerate(times_s, 1):
        frame = round(float(time.frame(time_s)))
        marker = scene.timeline_markers.new(f"{prefix} {i:0{width}}", frame=frame)
        move_mark(scene, marker, time_s)


def marker_at(scene, name: str, time_s: float):
    """The marker of that name whose mark is at `time_s`, to a float32's rounding."""
    time = timing(scene)
    for marker in matching_markers(scene, ""):
        if marker.name == name and abs(read_mark(marker, time).time_s - time_s) < 1e-4:
            return marker
    raise SceneError(f"Marker '{name}' at {time_s:.3f} s is gone: find repairs again.")


def move_mark(scene, marker, time_s: float) -> None:
    """Put a marker at an exact time."""
    time = timing(scene)
    marker.frame = round(float(time.frame(time_s)))
    store_time(marker, float(time_s), time)


def ancestors(obj) -> list:
    """Its parent, that one's parent and so on."""
    found = []
    while obj.parent is not None:
        obj = obj.parent
        found.append(obj)
    return found


def is_animated(obj) -> bool:
    """Whether keys, drivers, constraints or physics may move the object itself."""
    data = obj.animation_data
    return bool(
        (data and (data.action or data.drivers or data.nla_tracks))
        or any(not c.mute for c in obj.constraints)
        or (obj.rigid_body is not None and obj.rigid_body.type == "ACTIVE")
    )


def parent_space(obj) -> np.ndarray:
    """(4, 4) from the object's own channels to the world, in Blender units."""
    if obj.parent is None:
        return np.eye(4)
    name = obj.parent.name
    if obj.parent_type != "OBJECT":
        raise SceneError(
            f"'{obj.name}' is parented to a part of '{name}': parent it to an object, or to none."
        )
    for ancestor in ancestors(obj):
        if is_animated(ancestor):
            raise SceneError(
                f"Parent '{ancestor.name}' of '{obj.name}' is animated: keys are made for one that "
                "stands still."
            )
    space = np.array(obj.parent.matrix_world @ obj.matrix_parent_inverse, dtype=np.float64)
    lengths = np.linalg.svd(space[:3, :3], compute_uv=False)
    if lengths.min() <= 0 or lengths.max() > lengths.min() * (1 + SHEAR_TOLERANCE):
        raise SceneError(
            f"Parent '{name}' of '{obj.name}' has a non-uniform scale, which shears what turns "
            "inside it: apply the parent's scale."
        )
    if np.linalg.det(space[:3, :3]) < 0:
        raise SceneError(f"Parent '{name}' of '{obj.name}' is mirrored: apply the parent's scale.")
    return space


def world_scale(obj) -> np.ndarray:
    """(3,) along the object's own axes, signed."""
    own = np.array(obj.scale, dtype=np.float64) * np.array(obj.delta_scale, dtype=np.float64)
    return own * np.cbrt(np.linalg.det(parent_space(obj)[:3, :3]))


def ground_height(scene, obj) -> float:
    """World z of the chosen ground's middle, Blender units; 0 without one. `obj` is the body."""
    ground = scene.ifa.ground
    if ground is None:
        return 0.0
    name = f"Ground '{ground.name}'"
    if ground.type != "MESH":
        raise SceneError(f"{name} is no mesh: choose a plane, or none for z = 0.")
    if ground.name not in scene.objects:
        raise SceneError(f"{name} is not in scene '{scene.name}': choose another, or none.")
    if obj == ground or obj in ancestors(ground):
        raise SceneError(f"{name} is '{obj.name}' or moves with it: choose another, or none.")
    if any(is_animated(moving) for moving in [ground, *ancestors(ground)]):
        raise SceneError(f"{name} is animated: the solver's ground stands still.")
    points = _world_vertices(ground)
    centre = points.mean(axis=0) if len(points) else np.zeros(3)
    # Semi-axes by falling length: the third is along a plane's normal, and zero.
    axes = np.linalg.eigh((points - centre).T @ (points - centre))[1][:, ::-1].T
    sizes = np.ptp((points - centre) @ axes.T, axis=0) if len(points) else np.zeros(3)
    if not np.isfinite(sizes).all() or sizes[1] <= FLAT_TOLERANCE * sizes[0]:
        raise SceneError(f"{name} has no area: choose a plane, or none for z = 0.")
    if sizes[2] > FLAT_TOLERANCE * sizes[0]:
        raise SceneError(f"{name} is not flat: choose a plane, or none for z = 0.")
    tilt_deg = float(np.degrees(np.arctan2(np.hypot(*axes[2, :2]), abs(axes[2, 2]))))
    if tilt_deg > LEVEL_TOLERANCE_DEG:
        raise SceneError(
            f"{name} is tilted by {tilt_deg:.2g} degrees: the solver's ground is level, to "
            f"{LEVEL_TOLERANCE_DEG:g} degrees."
        )
    return float(centre[2])


def _world_vertices(obj) -> np.ndarray:
    """(n, 3) in Blender units, modifiers applied."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    data = evaluated.to_mesh()
    try:
        points = np.empty(3 * len(data.vertices), dtype=np.float32)
        data.vertices.foreach_get("co", points)
    finally:
        evaluated.to_mesh_clear()
    world = np.array(evaluated.matrix_world, dtype=np.float64)
    return points.reshape(-1, 3).astype(np.float64) @ world[:3, :3].T + world[:3, 3]


def mesh(obj, depsgraph, unit_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) in m and triangles (m, 3), modifiers and world scale applied.

    The axes are those of the object: what its world rotation turns.
    """
    evaluated = obj.evaluated_get(depsgraph)
    data = evaluated.to_mesh()
    try:
        data.calc_loop_triangles()
        if not len(data.vertices) or not len(data.loop_triangles):
            raise SceneError(f"'{obj.name}' has no faces: choose a mesh with a volume.")
        vertices = np.empty(3 * len(data.vertices), dtype=np.float32)
        data.vertices.foreach_get("co", vertices)
        triangles = np.empty(3 * len(data.loop_triangles), dtype=np.int32)
        data.loop_triangles.foreach_get("vertices", triangles)
    finally:
        evaluated.to_mesh_clear()
    scale = world_scale(obj) * unit_m
    points = vertices.reshape(-1, 3).astype(np.float64) * scale
    if not np.isfinite(points).all() or not np.abs(scale).min() > 0:
        raise SceneError(f"'{obj.name}' has a zero scale or a vertex that is not finite.")
    triangles = triangles.reshape(-1, 3).astype(np.int64)
    # A mirroring scale turns the faces inside out.
    return points, triangles[:, ::-1].copy() if np.prod(scale) < 0 else triangles


def checked_object(obj):
    if obj is None or obj.type != "MESH":
        raise SceneError("The active object is no mesh: select the body to animate.")
    if obj.library is not None or obj.override_library is not None:
        raise SceneError(f"'{obj.name}' is linked from another file: make it local first.")
    for driver in obj.animation_data.drivers if obj.animation_data else ():
        if driver.data_path.startswith(("location", "rotation")):
            raise SceneError(f"A driver of '{obj.name}' would override the keys: remove it.")
    for constraint in obj.constraints:
        if not constraint.mute:
            raise SceneError(
                f"Constraint '{constraint.name}' of '{obj.name}' would override the keys: mute it."
            )
    if obj.rigid_body is not None and obj.rigid_body.type == "ACTIVE":
        raise SceneError(f"'{obj.name}' is an active rigid body: remove that physics first.")
    return obj


def bodies(context, wanted: str) -> list:
    """Mesh objects by name: the active one, "SELECTED": also those selected, "ALL": every body.

    A body is what has been solved, or was made one (`obj.ifa.is_body`).
    """
    if wanted == "ALL":
        found = [obj for obj in context.scene.objects if obj.ifa.is_body]
    elif wanted == "ACTIVE":
        found = [context.object]
    else:
        chosen = [obj for obj in context.selected_objects if obj != context.object]
        found = [context.object, *(obj for obj in chosen if obj.ifa.is_body)]
    found = [obj for obj in found if obj is not None and obj.type == "MESH"]
    return sorted(found, key=lambda obj: obj.name)


def read_inputs(scene, obj, depsgraph) -> core.Inputs:
    """All that a solve needs, as plain data. Raises SceneError naming what is wrong."""
    checked_object(obj)
    settings = obj.ifa
    found = checked_marks(scene, settings.marker_filter, timing(scene))
    ground_height(scene, obj)  # refused before the solve, not after it
    vertices, triangles = mesh(obj, depsgraph, metres_per_unit(scene))
    path, packed = sound(scene)
    return core.Inputs(
        name=obj.name,
        vertices_m=vertices,
        triangles=triangles,
        mark_names=tuple(mark.name for mark in found),
        seed=settings.seed,
        accuracy=settings.accuracy.lower(),
        takes=settings.takes,
        sound_path=path,
        sound_bytes=packed,
        **asked(obj, found),
    )


def asked(obj, found: list[Mark]) -> dict:
    """The inputs of a solve that are read at once, without a look at the mesh or the sound."""
    settings = obj.ifa
    material = {"restitution": settings.restitution, "friction": settings.friction}
    if settings.mass_from == "DENSITY":
        material["density"] = settings.density_kg_m3
    else:
        material["mass_kg"] = settings.mass_kg
    return {
        "material_keywords": material,
        "mark_times_s": tuple(mark.time_s for mark in found),
        "ending": settings.ending.lower(),
        "material": settings.material.lower(),
        "energy_gain_j": settings.energy_gain_j,
        "time_budget_s": settings.time_budget_s or None,
    }
