# SPDX-License-Identifier: GPL-3.0-or-later
"""What was solved in this session, and how each mark was met. No bpy.

Motions are too large for a .blend and cost less to solve again than to keep in it: they are
forgotten with the file.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from . import core

MET_WITHIN_MS = 1.0  # of a mark, after retiming: ifa's `succeeded`
PLAUSIBLE_EXCESS, PLAUSIBLE_RETIMING = 1.0, 0.07  # ifa's `plausible`
ROUNDING = 1e-9


@dataclass
class Kept:
    """The latest solve of one object."""

    inputs: core.Inputs
    outcome: core.Outcome
    take: int = 0  # the one that is keyed

    @property
    def solution(self) -> Any:
        return self.outcome.solution.takes[self.take]


@dataclass(frozen=True)
class MarkReport:
    """How one mark was met. light: "MET", "SHOWS" (met, but not plausibly) or "MISSED"."""

    name: str
    time_s: float
    error_ms: float
    light: str
    text: str


_kept: dict[str, Kept] = {}
_predicted: dict[str, tuple[core.Inputs, dict[str, Any]]] = {}


def keep(name: str, kept: Kept) -> None:
    _kept[name] = kept


def of(name: str) -> Kept | None:
    """The latest solve of the object of that name in this session and file."""
    return _kept.get(name)


def keep_predictions(name: str, inputs: core.Inputs, predictions: dict[str, Any]) -> None:
    _predicted[name] = (inputs, predictions)


def predictions_for(name: str, asked: dict[str, Any]) -> dict[str, Any]:
    """Those made where these inputs were the same; else none.

    Shapes are not compared: a panel that draws has no time for that.
    """
    inputs, predictions = _predicted.get(name, (None, {}))
    fresh = inputs is not None and all(getattr(inputs, k) == v for k, v in asked.items())
    return predictions if fresh else {}


def forget(name: str = "") -> None:
    """Forget one object's solve and predictions, or all."""
    for kept in (_kept, _predicted):
        if name:
            kept.pop(name, None)
        else:
            kept.clear()


def mark_reports(solution: Any, names: tuple[str, ...]) -> list[MarkReport]:
    reports = []
    for name, event in zip(names, solution.events, strict=True):
        error_ms = 1e3 * event.error_retimed_s
        missed = event.factors["time"] == 0.0 or not abs(error_ms) <= MET_WITHIN_MS
        shown = []
        if event.excess > PLAUSIBLE_EXCESS + ROUNDING:
            shown.append(f"the impact is changed implausibly much (excess {event.excess:.1f})")
        if event.retiming > PLAUSIBLE_RETIMING + ROUNDING:
            shown.append(f"retimed by {100 * event.retiming:.0f} %")
        if missed:
            light, text = "MISSED", "nothing hits here"
        elif shown:
            light, text = "SHOWS", "; ".join(shown)
        else:
            light, text = "MET", f"{1e3 * event.error_s:+.1f} ms before retiming"
        reports.append(MarkReport(name, event.target_s, error_ms, light, text))
    return reports
