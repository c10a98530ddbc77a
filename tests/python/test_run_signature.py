"""Signature.from_run: the marks of a simulated run, against a chaining written a second time."""

from __future__ import annotations

import math

import ifa
import numpy as np
import pytest

BODIES = ("d6", "d12", "coin", "card")  # few hits and many, chains and none
ROUNDING = 1e-13  # relative: sums of at most a few hundred products


def runs(name, count=25):
    body = ifa.bodies.get(name)
    states = ifa.sample_states(body, count, seed=11)
    return [ifa.simulate(body, states[i]) for i in range(count)]


def chained(run, audible_speed_m_s, merge_gap_s):
    """Groups of hit indices: a gap of the merge gap or more between audible hits cuts."""
    audible = np.flatnonzero(run.hits.approach_speed_m_s >= audible_speed_m_s)
    cuts = np.flatnonzero(np.diff(run.hits.time_s[audible]) >= merge_gap_s) + 1
    return [group for group in np.split(audible, cuts) if len(group)]


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize(("audible_speed_m_s", "merge_gap_s"), [(0.05, 0.01), (0.2, 0.03)])
def test_against_chaining_by_brute_force(name, audible_speed_m_s, merge_gap_s):
    seen = 0
    for run in runs(name):
        groups = chained(run, audible_speed_m_s, merge_gap_s)
        marks = ifa.Signature.from_run(
            run, audible_speed_m_s=audible_speed_m_s, merge_gap_s=merge_gap_s
        )
        assert len(marks) == len(groups)
        for k, group in enumerate(groups):
            times_s = run.hits.time_s[group]
            impulses = np.linalg.norm(run.hits.impulse_n_s[group], axis=1)
            length_s = times_s[-1] - times_s[0]
            assert marks.times_s[k] == times_s[0]
            assert marks.durations_s[k] == (length_s if length_s >= merge_gap_s else 0.0)
            amplitude = math.sqrt((impulses**2).sum())
            assert marks.amplitudes[k] == pytest.approx(amplitude, rel=ROUNDING)
            if length_s >= merge_gap_s:
                centroid_s = np.average(times_s - times_s[0], weights=impulses)
                assert marks.centroids_s[k] == pytest.approx(centroid_s, rel=ROUNDING)
                seen += 1
            else:
                assert math.isnan(marks.centroids_s[k])
        assert marks.ending == "rest" and run.rest_s >= marks.times_s[-1]
        # Valid as a user's own marks are, and the same again from a file's content.
        assert ifa.Signature.from_dict(marks.to_dict(), merge_gap_s=merge_gap_s) == marks
    assert seen  # chains long enough to be continuous are among them


def test_a_dropped_ball_in_closed_form():
    height_m, e = 0.5, 0.6
    ball = ifa.Body.ball(0.01, mass_kg=0.02, restitution=e, friction=0.0)
    run = ifa.simulate(ball, ifa.State([0.0, 0.0, height_m + 0.01]), until_s=1.0)
    marks = ifa.Signature.from_run(run)
    fall_s = math.sqrt(2.0 * height_m / 9.81)
    # contact instants are exact: rounding of the root
    expected_s = fall_s * (1.0 + 2.0 * np.cumsum([0.0, e, e**2]))
    np.testing.assert_allclose(marks.times_s, expected_s, rtol=1e-9)
    np.testing.assert_allclose(marks.amplitudes / marks.amplitudes[0], e ** np.arange(3), rtol=1e-9)
    assert marks.amplitudes[0] == pytest.approx((1.0 + e) * 0.02 * 9.81 * fall_s, rel=1e-9)
    assert marks.ending == "open"  # stopped in the air


def test_what_cannot_be():
    ball = ifa.bodies.get("ball")
    run = ifa.simulate(ball, ifa.State([0.0, 0.0, 0.5]), until_s=0.1)
    with pytest.raises(ifa.IfaValueError, match="run: none of its 0 hits is audible"):
        ifa.Signature.from_run(run)
    with pytest.raises(ifa.IfaValueError, match=r"run: needs an ifa\.Run, got list"):
        ifa.Signature.from_run([0.1, 0.2])
    for name in ("audible_speed_m_s", "merge_gap_s"):
        for value in (0.0, -1.0, math.nan, math.inf, "loud"):
            with pytest.raises(ifa.IfaValueError, match=name):
                ifa.Signature.from_run(run, **{name: value})
