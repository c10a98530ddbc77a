"""Solutions, explanations, estimates and bodies as text for people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ifa.body import Body
from ifa.constraints import ConstraintReport
from ifa.estimation import Estimate
from ifa.explanation import Explanation
from ifa.marks import MERGE_GAP_S, Signature
from ifa.solution import Event, Prediction, Solution
from ifa.table import table

# CONVENTIONS.md, "Accuracy of a solve"
_MET_WITHIN_S = 1e-3
_LARGEST_RETIMING = 0.30  # of max(r, 1/r) - 1
_PLAUSIBLE_RETIMING = 0.07
_PLAUSIBLE_EXCESS = 1.0
_ROUNDING = 1e-9
_LEAST_SCORE = 0.3
_LARGEST_PENETRATION_M = 1e-4
_AUDIBLE_SPEED_M_S = 0.05
_ROUNDING_J = 1e-9
_MOST_FINDINGS = 10  # in a text; a rhythm can have one at each mark
_MOST_NAMED = 5  # marks in a phrase
_SAME_S = 1e-9  # a hit's time and the same time as an event's


def shortcomings(
    solution: Solution, names: Sequence[str] = (), open_ending: str = "--ending open"
) -> list[str]:
    """Why a solution did not succeed, one phrase for each reason; empty if it did.

    names: of the marks, where they have any. open_ending: how the reader asks for an open ending.
    """
    if solution.succeeded:
        return []
    called = [f"'{name}'" for name in names] or [
        f"mark {k}" for k in range(1, len(solution.events) + 1)
    ]
    events = list(zip(called, solution.events, strict=True))
    reasons = []
    # not (error <= limit) also catches NaN
    off = [(name, e.error_retimed_s) for name, e in events if not _met(e)]
    if off:
        marks = ", ".join(f"{name} ({1e3 * error_s:+.1f} ms)" for name, error_s in off)
        reasons.append(f"off at {marks}")
    if solution.missed_hits:
        reasons.append(f"{_count(solution.missed_hits, 'mark')} without a hit")
    reasons += _unasked(solution, open_ending)
    stretched = [(name, e) for name, e in events if not e.retiming <= _LARGEST_RETIMING]
    if stretched:
        marks = ", ".join(f"{name} ({signed_percent(e):+.0f} %)" for name, e in stretched)
        reasons.append(f"too much retiming before {marks}")
    if solution.score < _LEAST_SCORE:
        reasons.append(f"score below {_LEAST_SCORE:g}")
    if solution.max_penetration_m > _LARGEST_PENETRATION_M:
        reasons.append(f"penetration of {1e3 * solution.max_penetration_m:.2g} mm")
    if solution.max_energy_gain_j > solution.energy_gain_j + _ROUNDING_J:
        reasons.append(f"a contact adds {solution.max_energy_gain_j:.2g} J")
    return reasons or ["it does not come to rest after the last mark"]


def troubles(solution: Solution) -> list[str]:
    """Which marks are the trouble of a solution that did not succeed, one phrase for each kind.

    Those without a hit, those that are met beyond what is plausible, and hits after the last one;
    where none stands out, its shortcomings.
    """
    events = list(enumerate(solution.events, start=1))
    missed = [f"mark {k}" for k, e in events if e.factors["time"] == 0.0]
    changed = [
        f"mark {k} (excess {e.excess:.2f})"
        for k, e in events
        if e.excess > _PLAUSIBLE_EXCESS + _ROUNDING
    ]
    retimed = [
        f"mark {k} ({signed_percent(e):+.0f} %)"
        for k, e in events
        if e.retiming > _PLAUSIBLE_RETIMING + _ROUNDING
    ]
    phrases = []
    if missed:
        phrases.append(f"nothing hits at {_named(missed)}")
    if changed:
        phrases.append(f"an impact is changed too much to meet {_named(changed)}")
    if retimed:
        phrases.append(f"retiming shows before {_named(retimed)}")
    return (phrases + _unasked(solution, "--ending open")) or shortcomings(solution)


def _named(marks: Sequence[str]) -> str:
    more = len(marks) - _MOST_NAMED
    return ", ".join(marks[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def _unasked(solution: Solution, open_ending: str) -> list[str]:
    """Phrases for the hits without a mark: before the last mark, and after it."""
    if not solution.extra_hits:
        return []
    marks = solution.marks
    last_s = marks.times_s[-1] + marks.durations_s[-1]
    times_s = _unasked_times_s(solution)
    before = [t for t in times_s if t <= last_s]
    after = [t for t in times_s if t > last_s]
    if not times_s:  # heard before retiming only, or contacts
        what = "contact" if solution.motion.hearing["events"] == "contact" else "hit"
        return [f"{_count(solution.extra_hits, what)} without a mark"]
    phrases = []
    if before:
        phrases.append(f"{_count(len(before), 'hit')} without a mark, first at {before[0]:.3f} s")
    if after:
        what = f"{_count(len(after), 'hit')} after the last mark, first at {after[0]:.3f} s"
        if not before and marks.ending == "rest":
            what += f" (mark {'it' if len(after) == 1 else 'them'} too, or use {open_ending})"
        phrases.append(what)
    return phrases


def _unasked_times_s(solution: Solution) -> list[float]:
    """When each chain of audible hits begins that belongs to no mark; empty for contacts."""
    if solution.motion.hearing["events"] == "contact":
        return []  # hits alone do not tell which of them begin an interval of contact
    spans = [
        (event.achieved_s - _SAME_S, event.achieved_s + duration_s + _SAME_S)
        for event, duration_s in zip(solution.events, solution.marks.durations_s, strict=True)
        if _met(event)
    ]
    hits = solution.motion.hits
    heard = hits["time_s"][hits["approach_speed_m_s"] >= _AUDIBLE_SPEED_M_S]
    begins = [t for k, t in enumerate(heard) if k == 0 or t - heard[k - 1] >= MERGE_GAP_S]
    return [float(t) for t in begins if not any(a <= t <= b for a, b in spans)]


def _met(event: Event) -> bool:
    return abs(event.error_retimed_s) <= _MET_WITHIN_S


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def signed_percent(event: Event) -> float:
    """The retiming that leads to a mark in percent, negative where the motion was made faster."""
    return 100.0 * (event.retiming if event.retime >= 1.0 else -event.retiming)


def verdict(solution: Solution) -> str:
    """One sentence."""
    if solution.succeeded:
        return f"succeeded, {'plausible' if solution.plausible else 'not plausible'}"
    return f"no acceptable motion ({'; '.join(shortcomings(solution))})"


def solution_text(solution: Solution) -> str:
    """The verdict, the numbers that matter, and one line for each mark."""
    body = solution.body
    lines = [
        f"{body.name}: {verdict(solution)}",
        f"score {solution.score:.3f} ({solution.score_without_sound:.3f} without sound), "
        f"worst error {1e3 * solution.max_abs_error_s:.3f} ms after retiming",
        f"restitution {solution.restitution:.3g}, friction {solution.friction:.3g}, "
        f"seed {solution.seed}, rung {solution.rung}, {solution.solve_s:.2f} s for "
        f"{solution.simulated_s:.0f} s of simulated motion",
    ]
    if solution.prediction is not None:
        lines.append(predicted_text(solution, solution.prediction))
    lines.append("")
    rows = [("mark", "at s", "error ms", "retimed ms", "retime %", "excess")]
    for k, event in enumerate(solution.events, start=1):
        rows.append(
            (
                str(k),
                f"{event.target_s:.4f}",
                f"{1e3 * event.error_s:+.2f}",
                f"{1e3 * event.error_retimed_s:+.3f}",
                f"{signed_percent(event):+.2f}",
                f"{event.excess:.3f}",
            )
        )
    lines += table(rows, align=">" * 6)
    if solution.constraints:
        lines += ["", *(constraint_text(report) for report in solution.constraints)]
    return "\n".join(lines)


def prediction_text(prediction: Prediction) -> str:
    """What is expected, before the solve."""
    return (
        f"{prediction.accuracy}: predicted {prediction.time_s:.2g} s, error (1 - score) "
        f"{prediction.error:.2g}"
    )


def predicted_text(solution: Solution, prediction: Prediction) -> str:
    """What was expected beside what came true."""
    return (
        f"{prediction.accuracy}: predicted {prediction.time_s:.2g} s, "
        f"took {solution.solve_s:.2g} s; predicted error (1 - score) {prediction.error:.2g}, "
        f"was {solution.error:.2g}"
    )


def constraint_text(report: ConstraintReport) -> str:
    """How far off a position or an orientation is, and whether that meets the constraint."""
    mark = report.constraint.mark
    at = "at rest" if mark == "rest" else f"mark {int(mark) + 1}"
    if report.error_m is not None:
        off = f"{1e3 * report.error_m:.1f} mm off its position"
    else:
        off = f"{report.error_deg:.1f} degrees off its orientation"
    return f"{at}: {off}{'' if report.met else ', not met'}"


def takes(solution: Solution, files: Sequence[str | None]) -> list[dict[str, Any]]:
    """Of each take its file, score, plausible, and its difference from the first in body radii."""
    first_s, last_s = solution.marks.times_s[[0, -1]]
    rows = []
    for take, out in zip(solution.takes, files, strict=True):
        to_s = last_s if last_s > first_s else max(solution.motion.end_s, take.motion.end_s)
        difference = solution.motion.difference(take.motion, first_s, to_s)
        rows.append(
            {
                "out": out,
                "score": take.score,
                "plausible": take.plausible,
                "difference": difference,
            }
        )
    return rows


def takes_text(solution: Solution, files: Sequence[str | None], asked: int) -> str:
    """One line for each take, and how many there are of those asked for."""
    found = takes(solution, files)
    rows = [("take", "plausible", "score", "difference", "written to")]
    for k, take in enumerate(found, start=1):
        rows.append(
            (
                str(k),
                "yes" if take["plausible"] else "no",
                f"{take['score']:.3f}",
                f"{take['difference']:.2f}",
                take["out"] or "-",
            )
        )
    lines = table(rows, align="><>><")
    if len(found) < asked:
        lines.append(f"{len(found)} of the {asked} takes asked for were found")
    return "\n".join(lines)


def estimate_text(estimate: Estimate, body: Body, marks: Signature) -> str:
    """The material to begin with, one line for each gap, and the findings."""
    source = "from the gaps" if estimate.restitution_from_gaps else "the body's own"
    if estimate.restitution_from_gaps and not estimate.ball:
        source += ", a hint"
    lines = [
        f"{body.name}: {len(marks)} marks, {marks.times_s[-1] - marks.times_s[0]:.4g} s",
        f"restitution {estimate.restitution:.3g} ({source}), friction {estimate.friction:.3g} "
        "(the body's own: gaps do not show it)",
    ]
    if estimate.next_gap_s is not None:
        near = "near" if estimate.rest_is_near else "not near"
        lines.append(
            f"rest is {near}: the last bounce would take {1e3 * estimate.next_gap_s:.3g} ms"
        )
    if estimate.gaps:
        rows = [("mark", "at s", "gap ms", "ratio", "take-off m/s", "apex mm", "least - most", "mJ",
                 "needed mJ")]  # fmt: skip
        for k, gap in enumerate(estimate.gaps, start=2):
            least_m, most_m = gap.apex_range_m
            rows.append(
                (
                    str(k),
                    f"{marks.times_s[k - 1]:.4f}",
                    f"{1e3 * gap.gap_s:.1f}",
                    "" if gap.ratio is None else f"{gap.ratio:.2f}",
                    f"{gap.takeoff_speed_m_s:.3f}",
                    f"{1e3 * gap.apex_m:.4g}",
                    f"{1e3 * least_m:.3g} - {1e3 * most_m:.3g}",
                    f"{1e3 * gap.energy_j:.3g}",
                    f"{1e3 * gap.needed_j:.3g}",
                )
            )
        lines += ["", "if the body flies in the gap before each mark:"]
        lines += table(rows, align=">" * len(rows[0]))
    if estimate.findings:
        lines += ["", *(str(finding) for finding in estimate.findings[:_MOST_FINDINGS])]
        if len(estimate.findings) > _MOST_FINDINGS:
            lines.append(f"and {len(estimate.findings) - _MOST_FINDINGS} more (--json has all)")
    return "\n".join(lines)


def explanation_text(explanation: Explanation, body: Body) -> str:
    """What is wrong, and the repairs."""
    if explanation.plausible:
        return f"{body.name}: nothing is wrong, a plausible motion meets the marks"
    how = "only a motion that is not plausible" if explanation.succeeded else "no acceptable motion"
    lines = [f"{body.name}: {how} was found"]
    for conflict in explanation.conflicts[:_MOST_FINDINGS]:
        lines.append(f"  {conflict}")
        if conflict.finding is not None:
            lines.append(f"    (estimate: {conflict.finding})")
    if len(explanation.conflicts) > _MOST_FINDINGS:
        lines.append(f"  and {len(explanation.conflicts) - _MOST_FINDINGS} more (--json has all)")
    tried = f"of {_count(explanation.trials, 'trial')}"
    if not explanation.complete:
        tried += ", which the time budget ended"
    if not explanation.repairs:
        return "\n".join([*lines, "", f"no repair works ({tried})"])
    lines += ["", f"repairs that work ({tried}):"]
    lines += table([(f"{r.cost:.2f}", str(r)) for r in explanation.repairs], align="><")
    return "\n".join(lines)


def bodies_text(bodies: Iterable[dict[str, Any]]) -> str:
    """One line for each body of the library; restitution / friction on each surface."""
    rows: list[tuple[str, ...]] = []
    for body in bodies:
        if not rows:
            rows.append(("name", "size", "g", "cone", "ms", "material", *body["surfaces"]))
        materials = [
            f"{s['restitution']:.2f} / {s['friction']:.2f}" for s in body["surfaces"].values()
        ]
        mass = f"{1e3 * body['mass_kg']:.2f}"
        cone, gap = f"{math.degrees(body['cone_rad']):.0f}", f"{1e3 * body['merge_gap_s']:.0f}"
        rows.append((body["name"], body["size"], mass, cone, gap, body["material"], *materials))
    return "\n".join(
        [
            *table(rows, align="<<>>>" + "<" * 9),
            "",
            "cone: degrees from straight down within which throws are sampled",
            "ms: contacts that are less apart are one event",
            "restitution / friction on each surface",
        ]
    )


def database_text(content: Mapping[str, Any], checked: bool) -> str:
    """What `Database.to_dict` says, in two lines."""
    nodes, simulations = content["nodes"], content["simulations"]
    return (
        f"{content['body']['name']}: {nodes:,} nodes ({content['terminal_nodes']:,} terminal) of "
        f"{simulations:,} simulations, {content['bytes'] / 1e6:,.1f} MB\n"
        f"written to {content['path']}{', checksums agree' if checked else ''}"
    )
