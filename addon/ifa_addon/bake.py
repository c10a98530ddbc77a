# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes keys to an object in bulk, and takes them back."""

from __future__ import annotations

import bpy
import numpy as np

from . import compat, keys, scene

CHANNELS = [("location", i) for i in range(3)] + [("rotation_quaternion", i) for i in range(4)]
_REPLACED = {"location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle"}


def placement(scene_, obj, centre_of_mass_m: np.ndarray, motion) -> keys.Placement:
    """How the solver's world maps to this object's channels as the scene stands now."""
    unit_m = scene.metres_per_unit(scene_)
    space = scene.parent_space(obj)
    turn = space[:3, :3] / np.cbrt(np.linalg.det(space[:3, :3]))
    from_parent = _quaternion(turn)
    delta = np.array(obj.delta_rotation_quaternion, dtype=np.float64)
    delta /= np.linalg.norm(delta)
    # world = parent * delta * own
    unturn = keys.multiply(from_parent, delta) * np.array([1.0, -1.0, -1.0, -1.0])
    shift = np.zeros(3)
    if obj.ifa.place == "OBJECT":
        place = _home_origin(obj, space) * unit_m
        first = np.asarray(motion.contact_times_s[:1], dtype=np.float64)
        touched, _ = motion.sample(first if len(first) else np.array([motion.start_s]))
        shift[:2] = place[:2] - touched[0, :2]
    return keys.Placement(
        centre_of_mass_m=centre_of_mass_m,
        metres_per_unit=unit_m,
        shift_m=shift,
        unparent=np.linalg.inv(space),
        unturn_wxyz=unturn,
        delta_location=np.array(obj.delta_location, dtype=np.float64),
    )


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


def bake(scene_, obj, motion, centre_of_mass_m) -> keys.Keys:
    """Key the motion on `obj`, into the Action of an earlier bake where there is one.

    Everything that can fail is computed before the object is touched.
    """
    time = scene.timing(scene_)
    place = placement(scene_, obj, np.asarray(centre_of_mass_m, dtype=np.float64), motion)
    made = keys.make_keys(motion, time, place)
    _remember(obj)
    obj.rotation_mode = "QUATERNION"
    curves = compat.fcurves(_own_action(obj), obj)
    for channel, (path, index) in enumerate(CHANNELS):
        curve = curves.find(path, index=index) or compat.new_fcurve(
            curves, path, index, "Object Transforms"
        )
        write_curve(curve, made, channel)
    obj.update_tag()
    scene_.frame_set(scene_.frame_current, subframe=scene_.frame_subframe)
    return made


def write_curve(curve, made: keys.Keys, channel: int) -> None:
    points = curve.keyframe_points
    points.clear()
    points.add(len(made.frames))
    co = np.column_stack([made.frames, made.values[:, channel]])
    points.foreach_set("co", co.astype(np.float32).ravel())
    # foreach_set ignores handle types silently. They come first: others would move the handles.
    for point, contact in zip(points, made.is_contact, strict=True):
        point.interpolation = "BEZIER"
        point.handle_left_type = "FREE"
        point.handle_right_type = "FREE"
        point.type = "EXTREME" if contact else "KEYFRAME"
    points.foreach_set("handle_left", made.left[:, channel].astype(np.float32).ravel())
    points.foreach_set("handle_right", made.right[:, channel].astype(np.float32).ravel())
    points.foreach_set("select_control_point", np.zeros(len(points), dtype=bool))
    curve.extrapolation = "CONSTANT"
    curve.update()


def _remember(obj) -> None:
    """Keep transform, rotation mode and Action from before the first bake."""
    own = obj.ifa
    if own.action:
        return
    own.before_rotation_mode = obj.rotation_mode
    own.before_location = obj.location
    own.before_quaternion = obj.rotation_quaternion
    own.before_euler = obj.rotation_euler
    own.before_axis_angle = obj.rotation_axis_angle
    own.before_had_animation_data = obj.animation_data is not None
    own.before_action = obj.animation_data.action if obj.animation_data else None


def _own_action(obj):
    """The Action that bakes go into; other channels of the earlier Action are carried over."""
    own = obj.ifa
    data = obj.animation_data or obj.animation_data_create()
    if own.action is None:
        earlier = own.before_action
        if earlier is None:
            own.action = bpy.data.actions.new(f"{obj.name} IFA")
        else:
            own.action = earlier.copy()
            own.action.name = f"{obj.name} IFA"
    elif any(other != obj and other.ifa.action == own.action for other in bpy.data.objects):
        own.action = own.action.copy()  # this object was duplicated after a bake
    compat.assign_action(data, own.action)
    curves = compat.fcurves(own.action, obj)
    kept = {path for path, _ in CHANNELS} if own.keyed else set()
    for curve in list(curves):
        if curve.data_path in _REPLACED - kept:
            curves.remove(curve)
    own.keyed = True
    return own.action


def clear(obj) -> None:
    """Put transform, rotation mode and Action back as they were before the first bake."""
    own = obj.ifa
    if own.action is None:
        return
    action, own.action = own.action, None
    data = obj.animation_data
    if data is not None:
        compat.assign_action(data, own.before_action)
        if not own.before_had_animation_data and not data.drivers and not data.nla_tracks:
            obj.animation_data_clear()
    own.before_action = None
    own.keyed = False
    obj.rotation_mode = own.before_rotation_mode
    obj.location = own.before_location
    obj.rotation_quaternion = own.before_quaternion
    obj.rotation_euler = own.before_euler
    obj.rotation_axis_angle = own.before_axis_angle
    own.result = ""
    if action.users == 0:
        bpy.data.actions.remove(action)
