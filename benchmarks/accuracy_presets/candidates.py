"""Presets that could be, and what each costs and reaches on measured climbs."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import replace

import ifa

from benchmarks.physics.report import Row

from .climbs import BEAMS, LARGEST_FOR_ALL, Measured

_G = ifa.ACCURACIES["good"]


def candidates() -> list[ifa.Accuracy]:
    """The presets, and others: single beams, other first beams, goals and least rungs."""
    standard = _G.ladder
    out = list(ifa.ACCURACIES.values())
    for beam in (beam for beam in BEAMS if beam <= LARGEST_FOR_ALL):
        out.append(replace(_G, name=f"beam {beam} alone", ladder=(beam,)))
    for first in (10, 20, 40):
        ladder = tuple(beam for beam in (10, 20, *standard) if beam >= first)
        for until in ("succeeded", "plausible"):
            out.append(replace(_G, name=f"from {first} until {until}", ladder=ladder, until=until))
    for least in range(1, 4):
        out.append(replace(_G, name=f"to beam {standard[least]} at least", least_rung=least))
    return out


Outcome = tuple[float, bool, bool, float]


def outcome(preset: ifa.Accuracy, climb: Measured) -> Outcome | None:
    """Seconds, succeeded, plausible and error of the preset on a climb; the clock ends none.

    None where its first rung was not run; a climb that was measured no further ends there.
    """
    rungs = {rung.beam: rung for rung in climb.rungs}
    time_s, best = 0.0, None
    for k, beam in enumerate(preset.ladder):
        if beam not in rungs:
            break
        rung = rungs[beam]
        time_s += rung.time_s
        if best is None or _rank(rung) > _rank(best):
            best = rung
        if k >= preset.least_rung and preset.reached(
            succeeded=best.succeeded, plausible=best.plausible
        ):
            break
    if best is None:
        return None
    return time_s, best.succeeded, best.plausible, best.error


def point(preset: ifa.Accuracy, climbs: Sequence[Measured]) -> Row:
    """One row of the table: what the preset costs and reaches over all climbs.

    error: 1 - Score, and 1 where the motion did not succeed. Empty where no climb has its rungs.
    """
    outcomes = (outcome(preset, climb) for climb in climbs)
    results = [result for result in outcomes if result is not None]
    if not results:
        return {}
    times_s = sorted(result[0] for result in results)
    errors = sorted(result[3] if result[1] else 1.0 for result in results)
    ninth = min(len(results) - 1, int(0.9 * len(results)))
    return {
        "preset": preset.name,
        "cases": len(results),
        "time_median_s": statistics.median(times_s),
        "time_mean_s": statistics.fmean(times_s),
        "time_p90_s": times_s[ninth],
        "error_median": statistics.median(errors),
        "error_mean": statistics.fmean(errors),
        "error_p90": errors[ninth],
        "succeeded": sum(result[1] for result in results),
        "plausible": sum(result[2] for result in results),
    }


def mark_front(rows: Sequence[Row]) -> None:
    """Adds `on_front`: no other preset is both faster and more accurate, by the means.

    Only those that all cases were run with compare: slow cases lack some rungs.
    """
    most = max((int(row["cases"]) for row in rows), default=0)  # type: ignore[call-overload]
    for row in rows:
        row["on_front"] = False
    rows = [row for row in rows if row["cases"] == most]
    for row in rows:
        time_s, error = float(row["time_mean_s"]), float(row["error_mean"])  # type: ignore[arg-type]
        row["on_front"] = not any(
            float(other["time_mean_s"]) <= time_s  # type: ignore[arg-type]
            and float(other["error_mean"]) <= error  # type: ignore[arg-type]
            and (other["time_mean_s"], other["error_mean"]) != (time_s, error)
            for other in rows
        )


def _rank(rung: ifa.prediction.Rung) -> tuple[bool, bool, float]:
    return rung.plausible, rung.succeeded, -rung.error
