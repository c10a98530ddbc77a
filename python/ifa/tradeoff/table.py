"""The points of curves as CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence

from ifa.tradeoff.curve import Curve, Point

COLUMNS = (
    "knob", "series", "setting", "time_s", "time_least_s", "time_most_s", "error", "error_least",
    "error_most", "error_name", "on_front", "repeats", "success", "not_reached", "failures",
    "losses",
)  # fmt: skip
_BETWEEN = " | "  # several failures in one field


def csv_text(curves: Sequence[Curve]) -> str:
    """One row for each point; numbers in full, empty where there is none."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for curve in curves:
        writer.writerows(_row(curve, point) for point in curve.points)
    return out.getvalue()


def _row(curve: Curve, point: Point) -> tuple[object, ...]:
    return (
        curve.study.knob,
        point.series,
        point.label,
        *map(_number, (point.time_s, *point.time_range_s)),
        *map(_number, (point.error, *point.error_range)),
        curve.study.error_name,
        int(point.on_front),
        point.repeats,
        _number(point.success),
        point.not_reached,
        _BETWEEN.join(point.failures),
        _BETWEEN.join(point.losses),
    )


def _number(value: float) -> str:
    return repr(value) if math.isfinite(value) else ""
