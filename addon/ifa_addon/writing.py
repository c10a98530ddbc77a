# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys and reports of one solved body into the scene, on the main thread."""

from __future__ import annotations

from . import bake, core, results, scene


def write(context, obj, kept: results.Kept) -> tuple[str, ...]:
    """Key the take of `kept` on the object and say how it meets the marks; returns what to warn of.

    Raises scene.SceneError or ValueError before anything is touched.
    """
    time = scene.timing(context.scene)
    outcome, solution = kept.outcome, kept.solution
    made = bake.bake(context.scene, obj, solution.motion, outcome.centre_of_mass_m)
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
