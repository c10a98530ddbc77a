# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes keys to an object in bulk, and takes them back."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np

from . import compat, keys, scene

CHANNELS = {"location": 3, "rotation_quaternion": 4}  # F-curves that a bake writes
_REPLACED = {"location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle"}


def placement(scene_, obj, centre_of_mass_m: np.ndarray, motion) -> keys.Placement:
    """How the solver's world maps to this object's channels as the scene stands now."""
    unit_m = scene.metres_per_unit(scene_)
    space = scene.parent_space(obj)
    turn = space[:3, :3] / np.cbrt(np.linalg.det(space[:3, :3]))
    from_parent = _quaternion(turn)
    delta = np.array(_delta_turn(obj), dtype=np.float64)
    delta /= np.linalg.norm(delta)
    # world = parent * delta * own
    unturn = keys.multiply(from_parent, delta) * np.array([1.0, -1.0, -1.0, -1.0])
    shift = np.zeros(3)
    if obj.ifa.place == "OBJECT":
        place = _home_origin(obj, space) * unit_m
        first = np.asarray(motion.contact_times_s[:1], dtype=np.float64)
        touched, _ = motion.sample(first if len(first) else np.array([motion.start_s]))
        shift[:2] = place[:2] - touched[0, :2]
    shift[2] = scene.ground_height(scene_, obj) * unit_m
    return keys.Placement(
        centre_of_mass_m=centre_of_mass_m,
        metres_per_unit=unit_m,
        shift_m=shift,
        unparent=np.linalg.inv(space),
        unturn_wxyz=unturn,
        delta_location=np.array(obj.delta_location, dtype=np.float64),
    )


def _delta_turn(obj):
    """The delta rotation in effect, as a quaternion: an Euler mode has one of its own."""
    if obj.rotation_mode in {"QUATERNION", "AXIS_ANGLE"}:
        return obj.delta_rotation_quaternion
    return obj.delta_rotation_euler.to_quaternion()


def _quaternion(rotation: np.ndarray) -> np.ndarray:
    """A rotation matrix as wxyz."""
    m = rotation
    k = np.array(
        [
            [m[0, 0] + m[1, 1] + m[2, 2], 0, 0, 0],
            [m[2, 1] - m[1, 2], m[0, 0] - m[1, 1] - m[2, 2], 0, 0],
            [m[0, 2] - m[2, 0], m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], 0],
            [m[1, 0] - m[0, 1], m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1]],
        ]
    )
    # The quaternion is the eigenvector of this symmetric matrix to its largest eigenvalue.
    _, vectors = np.linalg.eigh(k)
    return vectors[:, -1]


def _home_origin(obj, space: np.ndarray) -> np.ndarray:
    """World place of the object's origin before it was first keyed, Blender units."""
    location = obj.ifa.before_location if obj.ifa.action else obj.location
    own = np.array(location, dtype=np.float64) + np.array(obj.delta_location, dtype=np.float64)
    return space[:3, :3] @ own + space[:3, 3]


def tolerance(obj) -> keys.Tolerance:
    own = obj.ifa
    return keys.Tolerance(
        1e-3 * own.position_tolerance_mm, float(np.radians(own.rotation_tolerance_deg))
    )


def make(scene_, obj, motion, centre_of_mass_m) -> keys.Keys:
    """The keys of `motion` for `obj` as the scene stands; nothing is written."""
    time = scene.timing(scene_)
    place = placement(scene_, obj, np.asarray(centre_of_mass_m, dtype=np.float64), motion)
    return keys.make_keys(motion, time, place, tolerance(obj), obj.ifa.key_times)


def bake(scene_, obj, motion, centre_of_mass_m) -> keys.Keys:
    """Key the motion on `obj`, into the Action of an earlier bake where there is one.

    Everything that can fail is computed before the object is touched.
    """
    made = make(scene_, obj, motion, centre_of_mass_m)
    write(scene_, [(obj, made)])
    return made


def write(scene_, baked: Iterable[tuple[bpy.types.Object, keys.Keys]]) -> None:
    """Write finished keys to their objects and show them; for many objects in one go."""
    with compat.ActionStock(CHANNELS) as stock:
        for obj, made in baked:
            _remember(obj)
            obj.delta_rotation_quaternion = _delta_turn(obj)
            obj.rotation_mode = "QUATERNION"
            tracks = {"location": made.location, "rotation_quaternion": made.rotation}
            lengths = {path: len(track.frames) for path, track in tracks.items()}
            curves = compat.fcurves(_own_action(obj, stock, lengths), obj)
            for path, track in tracks.items():
                for index in range(CHANNELS[path]):
                    curve = curves.find(path, index=index) or compat.new_fcurve(
                        curves, path, index, "Object Transforms"
                    )
                    _write_curve(curve, track, index, stock)
            obj.update_tag()
    scene_.frame_set(scene_.frame_current, subframe=scene_.frame_subframe)


def _write_curve(curve, track: keys.Track, channel: int, stock: compat.ActionStock) -> None:
    count = len(track.frames)
    # Handle types come first: other ones would move the handles.
    points = stock.free_points(curve, count)
    co = np.column_stack([track.frames, track.values[:, channel]])
    points.foreach_set("co", co.astype(np.float32).ravel())
    points.foreach_set("handle_left", track.left[:, channel].astype(np.float32).ravel())
    points.foreach_set("handle_right", track.right[:, channel].astype(np.float32).ravel())
    contact, other = (compat.enum_number("type", item) for item in ("EXTREME", "KEYFRAME"))
    points.foreach_set("type", np.where(track.is_contact, contact, other).astype(np.int32))
    points.foreach_set("select_control_point", np.zeros(count, dtype=bool))
    curve.extrapolation = "CONSTANT"
    curve.update()


def _remember(obj) -> None:
    """Keep transform, rotation mode and Action from before the first bake."""
    own = obj.ifa
    if own.keyed:
        return
    own.before_rotation_mode = obj.rotation_mode
    own.before_location = obj.location
    own.before_quaternion = obj.rotation_quaternion
    own.before_delta_quaternion = obj.delta_rotation_quaternion
    own.before_euler = obj.rotation_euler
    own.before_axis_angle = obj.rotation_axis_angle
    own.before_had_animation_data = obj.animation_data is not None
    own.before_action = obj.animation_data.action if obj.animation_data else None


def _own_action(obj, stock: compat.ActionStock, lengths: dict[str, int]):
    """The Action that bakes go into; other channels of the earlier Action are carried over."""
    own = obj.ifa
    data = obj.animation_data or obj.animation_data_create()
    if own.action is None:
        earlier = own.before_action
        if earlier is None:
            own.action = stock.new_action(f"{obj.name} IFA", lengths)
        else:
            own.action = earlier.copy()
            own.action.name = f"{obj.name} IFA"
    elif own.action.users > 1 + (data.action == own.action) and any(
        other != obj and other.ifa.action == own.action for other in bpy.data.objects
    ):
        own.action = own.action.copy()  # this object was duplicated after a bake
    compat.assign_action(data, own.action)
    curves = compat.fcurves(own.action, obj)
    kept = set(CHANNELS) if own.keyed or own.before_action is None else set()
    for curve in list(curves):
        if curve.data_path in _REPLACED - kept:
            curves.remove(curve)
    own.keyed = True
    return own.action


def clear(obj) -> None:
    """Put transform, rotation mode and Action back as they were before the first bake."""
    own = obj.ifa
    if not own.keyed:
        return
    action, own.action = own.action, None
    data = obj.animation_data
    if data is not None and data.action in (action, None):  # else another one was assigned since
        compat.assign_action(data, own.before_action)
        if not own.before_had_animation_data and not data.drivers and not data.nla_tracks:
            obj.animation_data_clear()
    own.before_action = None
    own.keyed = False
    obj.rotation_mode = own.before_rotation_mode
    obj.location = own.before_location
    obj.rotation_quaternion = own.before_quaternion
    obj.delta_rotation_quaternion = own.before_delta_quaternion
    obj.rotation_euler = own.before_euler
    obj.rotation_axis_angle = own.before_axis_angle
    own.result = ""
    if action is not None and action.users == 0:
        bpy.data.actions.remove(action)
