"""The section about presets and predictions in docs/accuracy.md, from what was recorded."""

from __future__ import annotations

from typing import Any

import ifa
from ifa import accuracy
from ifa.prediction import FACTOR


def markdown() -> str:
    """The presets on the curve of all candidates, and how good predictions were; no heading.

    Raises KeyError where predictions were not judged since the last record: run with --predict.
    """
    content = accuracy.recorded()
    lines = [_measured(content["measured"]), "", *_points(content["points"])]
    lines += ["", *_judged(content["judged"])]
    return "\n".join(lines) + "\n"


def _measured(measured: dict[str, Any]) -> str:
    cases = ", ".join(f"{count} {kind}" for kind, count in measured["cases"].items())
    return (
        f"Over {cases} scenes (seconds: {measured['clock']}, {measured['threads'] or 'all'} "
        f"threads; {'; '.join(measured['machine'])}). The error is 1 - Score, and 1 where the "
        "motion did not succeed."
    )


def _points(points: list[dict[str, Any]]) -> list[str]:
    lines = [
        "| preset or candidate | s: median, mean, 90 % | error: median, mean, 90 % | succeeded "
        "| plausible | on the front |",
        "|---|---|---|---|---|---|",
    ]
    for p in sorted(points, key=lambda point: point["time_mean_s"]):
        name = f"**{p['preset']}**" if p["preset"] in ifa.ACCURACIES else p["preset"]
        lines.append(
            f"| {name} | {p['time_median_s']:.3g}, {p['time_mean_s']:.3g}, {p['time_p90_s']:.3g} "
            f"| {p['error_median']:.3g}, {p['error_mean']:.3g}, {p['error_p90']:.3g} "
            f"| {p['succeeded']} of {p['cases']} | {p['plausible']} "
            f"| {'yes' if p['on_front'] else ''} |"
        )
    return lines


def _judged(judged: dict[str, Any]) -> list[str]:
    lines = [
        f"Predictions for recordings (seconds: {judged['clock']}, {judged['threads'] or 'all'} "
        f"threads, {judged['date']}) that come true within a factor of {FACTOR:g}; in brackets of "
        "those whose end the calibration had not seen:",
        "",
        "| stop | seconds | error | both | longest calibration, s |",
        "|---|---|---|---|---|",
    ]
    for stop in judged["stops"]:
        n, unseen = stop["recordings"], stop["unseen"]
        lines.append(
            f"| {stop['accuracy']} | {stop['time_within']} of {n} "
            f"({stop['unseen_time_within']} of {unseen}) | {stop['error_within']} of {n} "
            f"({stop['unseen_error_within']} of {unseen}) | {stop['both_within']} "
            f"| {stop['longest_calibration_s']:.2f} |"
        )
    return lines
