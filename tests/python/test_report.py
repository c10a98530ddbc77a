"""What is said of a solution that did not succeed, on hits placed by hand."""

from __future__ import annotations

from types import SimpleNamespace

import ifa
import numpy as np
import pytest
from ifa.report import shortcomings, troubles

TIMES_S = (0.3, 0.5, 0.6)


def event(target_s, error_retimed_s=0.0, retime=1.0, excess=0.0, time=1.0):
    achieved_s, factors = target_s + error_retimed_s, {"time": time}
    return ifa.Event(target_s, achieved_s, 0.0, error_retimed_s, retime, excess, factors)


def failed(ending="rest", hits=(), hearing="audible", **changes):
    """A failed solution with hits at the marks and at (time, speed) besides."""
    found = sorted([*((t, 0.5) for t in TIMES_S), *hits])
    fields = {
        "succeeded": False,
        "marks": ifa.Signature(TIMES_S, ending=ending),
        "events": [event(t) for t in TIMES_S],
        "motion": SimpleNamespace(
            hearing={"events": hearing},
            hits={
                "time_s": np.array([t for t, _ in found]),
                "approach_speed_m_s": np.array([v for _, v in found]),
            },
        ),
        "missed_hits": 0,
        "extra_hits": len(hits),
        "score": 0.8,
        "max_penetration_m": 0.0,
        "max_energy_gain_j": 0.0,
        "energy_gain_j": 0.0,
    }
    return SimpleNamespace(**(fields | changes))


def test_hits_after_the_last_mark_suggest_an_open_ending():
    solution = failed(hits=[(0.7, 0.2), (0.72, 0.06), (0.725, 0.06), (0.8, 0.04)])
    # 0.725 chains with 0.72, and 0.8 is silent
    assert shortcomings(solution) == [
        "2 hits after the last mark, first at 0.700 s (mark them too, or use --ending open)"
    ]
    assert "Ending: Open" in shortcomings(solution, open_ending="Ending: Open")[0]


def test_hits_before_and_after_the_last_mark_are_told_apart():
    solution = failed(hits=[(0.4, 0.2), (0.7, 0.2)])
    assert shortcomings(solution) == [
        "1 hit without a mark, first at 0.400 s",
        "1 hit after the last mark, first at 0.700 s",
    ]


def test_a_late_hit_answers_no_mark_and_is_named():
    events = [event(0.3), event(0.5, 0.0123), event(0.6, float("nan"))]
    reasons = shortcomings(failed(events=events, missed_hits=1), ["a", "b", "c"])
    assert reasons == ["off at 'b' (+12.3 ms), 'c' (+nan ms)", "1 mark without a hit"]
    assert shortcomings(failed(events=events))[0].startswith("off at mark 2 (+12.3 ms), mark 3")


@pytest.mark.parametrize(("retime", "said"), [(1.31, "+31 %"), (1 / 1.31, "-31 %")])
def test_retiming_counts_the_same_slower_and_faster(retime, said):
    events = [event(0.3), event(0.5, retime=retime), event(0.6, retime=1 / 1.29)]
    assert shortcomings(failed(events=events)) == [f"too much retiming before mark 2 ({said})"]
    assert events[1].retiming == pytest.approx(0.31, rel=1e-12)  # rounding


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"score": 0.2}, "score below 0.3"),
        ({"max_penetration_m": 2e-4}, "penetration of 0.2 mm"),
        ({"max_energy_gain_j": 0.01}, "a contact adds 0.01 J"),
        ({}, "it does not come to rest after the last mark"),
    ],
)
def test_other_reasons(changes, reason):
    assert shortcomings(failed(**changes)) == [reason]


def test_success_has_no_shortcomings():
    assert shortcomings(failed(succeeded=True)) == []


def test_troubles_name_the_marks():
    assert troubles(failed(hits=[(0.7, 0.2)])) == [
        "1 hit after the last mark, first at 0.700 s (mark it too, or use --ending open)"
    ]
    # beyond 1 and 7 %, whatever `succeeded` allows; at the edge it is still plausible
    events = [event(0.3), event(0.5, excess=1.0, retime=1 / 1.08), event(0.6, excess=1.5)]
    assert troubles(failed(events=events)) == [
        "an impact is changed too much to meet mark 3 (excess 1.50)",
        "retiming shows before mark 2 (-8 %)",
    ]
    missed = [event(0.3), event(0.5, retime=1.07), event(0.6, 0.1, time=0.0)]
    assert troubles(failed(events=missed, missed_hits=1)) == ["nothing hits at mark 3"]
    # where no mark stands out, what keeps the motion from succeeding
    assert troubles(failed(score=0.2)) == shortcomings(failed(score=0.2)) == ["score below 0.3"]


def test_many_troubles_are_cut_short():
    events = [event(t, time=0.0) for t in np.arange(1.0, 10.0)]
    marks = ifa.Signature(np.arange(1.0, 10.0))
    (phrase,) = troubles(failed(events=events, marks=marks, missed_hits=9))
    assert phrase == "nothing hits at mark 1, mark 2, mark 3, mark 4, mark 5 and 4 more"


def test_contacts_without_a_mark_are_counted():
    # 0.8 m/s at 0.7 s may lie within an interval of contact: hits alone do not tell
    assert shortcomings(failed(hits=[(0.7, 0.8)], hearing="contact")) == [
        "1 contact without a mark"
    ]
