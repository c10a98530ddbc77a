# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys and reports of one solved body into the scene, on the main thread."""

from __future__ import annotations

from . import bake, core, results, scene


def key_state(scene_, obj) -> str:
    """What keys follow from beside the motion; where it differs now they are stale."""
    own = obj.ifa
    try:
        time = scene.timing(scene_)
    except scene.SceneError:
        return own.keyed_as
    ground = scene_.ifa.ground.name if scene_.ifa.ground else ""
    options = own.key_times, own.position_tolerance_mm, own.rotation_tolerance_deg
    return repr((time.fps, time.origin_frame, own.place, ground, *options))


def write(context, obj, kept: results.Kept, store: bool = True) -> tuple[str, ...]:
    """Key the take of `kept` on the object and say how it meets the marks; returns what to warn of.

    Raises scene.SceneError or ValueError before anything is touched.
    """
    time = scene.timing(context.scene)
    outcome, solution = kept.outcome, kept.solution
    made = bake.bake(context.scene, obj, solution.motion, outcome.centre_of_mass_m)
    if store:
        scene.store_exact_times(context.scene, obj.ifa.marker_filter, time)
    results.keep(obj.name, kept)
    own = obj.ifa
    own.is_body = True
    own.succeeded, own.plausible = bool(solution.succeeded), bool(solution.plausible)
    own.score = float(solution.score)
    own.worst_error_ms = 1e3 * float(solution.max_abs_error_s)
    own.take, own.takes_found = kept.take + 1, len(outcome.solution.takes)
    own.solve_s, own.error = float(solution.solve_s), float(solution.error)
    own.effects = solution.effects.line()
    own.keyed_as = key_state(context.scene, obj)
    own.result = core.describe(solution, outcome.mark_names)
    own.mark_reports.clear()
    for report in results.mark_reports(solution, outcome.mark_names):
        item = own.mark_reports.add()
        item.name, item.time_s = report.name, report.time_s
        item.error_ms, item.light, item.text = report.error_ms, report.light, report.text
    own.repairs.clear()
    return (*outcome.notes, *made.notes)


def clear(obj) -> None:
    """Take keys and reports back."""
    bake.clear(obj)
    results.forget(obj.name)
    obj.ifa.mark_reports.clear()
    obj.ifa.repairs.clear()
    obj.ifa.effects = obj.ifa.keyed_as = ""
