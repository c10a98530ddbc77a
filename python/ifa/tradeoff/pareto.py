"""The points of a curve that are worth choosing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def pareto_front(times_s: Sequence[float], errors: Sequence[float]) -> list[bool]:
    """For each point, whether none is at least as good in both and better in one.

    Points that are equal in both are on the front together; NaN is never on it. O(n log n).
    """
    times, wrong = np.asarray(times_s, float), np.asarray(errors, float)
    front = [False] * len(times)
    best_error, best_time_s = np.inf, np.nan
    for k in np.lexsort((wrong, times)):
        if np.isnan(times[k]) or np.isnan(wrong[k]):
            continue
        ties = wrong[k] == best_error and times[k] == best_time_s
        if wrong[k] < best_error or ties:
            front[k] = True
            best_error, best_time_s = wrong[k], times[k]
    return front
