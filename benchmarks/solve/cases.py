"""A case: one problem for the solver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import ifa

T = TypeVar("T")


@dataclass(frozen=True)
class Case:
    """A body, marks, and all that `ifa.solve` is told about them.

    before: marks of the same sound that are solved first, not timed; the solve of `marks` may then
    reuse that solution. None: solved from nothing.
    """

    name: str
    body: ifa.Body
    marks: ifa.Signature
    material: str = "given"
    events: str = "audible"
    energy_gain_j: float = 0.0
    before: ifa.Signature | None = None


def spread(items: Sequence[T], limit: int | None) -> list[T]:
    """At most `limit` of the items, evenly spread over all: the middles of that many parts."""
    if limit is None or limit >= len(items):
        return list(items)
    return [items[(2 * i + 1) * len(items) // (2 * limit)] for i in range(limit)]


def first_marks(marks: ifa.Signature, count: int) -> ifa.Signature:
    """The first of the marks; what comes after them is left open."""
    amplitudes = None if marks.amplitudes is None else marks.amplitudes[:count]
    return ifa.Signature(
        marks.times_s[:count],
        marks.durations_s[:count],
        amplitudes,
        marks.centroids_s[:count],
        "open",
    )
