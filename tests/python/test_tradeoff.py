"""Accuracy against time: the curves, and what is measured for them."""

from __future__ import annotations

import math
import time
from statistics import median

import ifa
import numpy as np
import pytest
from ifa.tradeoff import Outcome, Scene, Setting, keys
from ifa.tradeoff.knobs import KNOBS
from ifa.tradeoff.measure import measure
from ifa.tradeoff.pareto import pareto_front
from ifa.tradeoff.shape import mass_property_error
from ifa.tradeoff.throws import (
    Reference,
    Throws,
    event_simulation,
    measured,
    ode_simulation,
)
from scripted_studies import BALL_MARKS, scripted, study


def brute_force(times_s, errors):
    def dominated(k):
        return any(
            times_s[j] <= times_s[k]
            and errors[j] <= errors[k]
            and (times_s[j] < times_s[k] or errors[j] < errors[k])
            for j in range(len(times_s))
        )

    return [not math.isnan(errors[k]) and not dominated(k) for k in range(len(times_s))]


def test_the_front_is_that_of_brute_force():
    rng = np.random.default_rng(7)
    fronts = set()
    for trial in range(400):
        # A coarse grid makes ties in time, in error and in both.
        times_s = rng.integers(1, 2 + trial % 7, trial % 12).astype(float)
        errors = rng.integers(0, 2 + trial % 5, trial % 12).astype(float)
        errors[rng.random(len(errors)) < 0.1] = np.nan
        front = pareto_front(times_s, errors)
        assert front == brute_force(times_s, errors)
        fronts.add(sum(front))
    assert len(fronts) > 3  # the trials differ


def test_equal_points_are_on_the_front_together():
    assert pareto_front([1.0, 1.0, 2.0], [3.0, 3.0, 3.0]) == [True, True, False]


# Measuring


def test_points_are_medians_and_spread(mixed):
    point = mixed[0].points[0]
    assert (point.time_s, point.time_range_s) == (2, (1, 3))
    assert (point.error, point.error_range) == (5, (4, 9))
    assert (point.repeats, point.not_reached, point.failures) == (3, 0, ())


def test_failures_are_kept_and_named(mixed):
    points = {point.label: point for point in mixed[0].points}
    assert points["part"].failures == ('it, "fell" | <b>',)
    assert points["part"].error == median([2, 1])  # of what did not fail
    assert points["bad"].failures == ("no motion",) * 3
    assert math.isnan(points["bad"].error) and points["bad"].time_s >= 0.0
    assert not points["bad"].on_front
    assert points["nan"].failures == ("the error is not a finite number",) * 3
    assert points["lossy"].losses == ("2 of 9 throws",)
    assert [point.not_reached for point in mixed[2].points] == [3]


def test_all_settings_take_turns():
    order = []

    def noted(name):
        def run(repeat):
            order.append((name, repeat))
            return Outcome(1.0, 1.0)

        return Setting(name, run)

    measure([study(noted("a"), noted("b")), study(noted("c"))], repeats=2)
    assert order[:2] == [("a", 0), ("c", 0)]  # to warm up
    assert order[2:] == [(name, repeat) for repeat in (0, 1) for name in ("a", "c", "b")]


def test_a_run_that_would_end_too_late_is_not_begun():
    """The first run says that the second one would not fit; it is left out and counted."""

    def slow(repeat):
        time.sleep(0.2)
        return Outcome(0.2, 1.0)

    [curve] = measure([study(Setting("slow", slow))], repeats=50, deadline_s=time.monotonic() + 1.0)
    [point] = curve.points
    assert point.repeats + point.not_reached == 50
    assert point.not_reached >= 45  # at most 1 s / 0.2 s runs fit


def test_long_runs_wait_where_time_is_short():
    """A setting that is expected to take many times its share of the time goes to the end."""
    order = []

    def noted(name, time_s):
        def run(repeat):
            order.append(name)
            time.sleep(time_s)
            return Outcome(1.0, 1.0)

        return Setting(name, run)

    slow = study(noted("first", 0.2), noted("longer", 0.0), knob="slow")
    fast = study(*(noted(f"fast {k}", 0.0) for k in range(60)), knob="fast")
    measure([slow, fast], repeats=1, deadline_s=time.monotonic() + 5.0)
    del order[:2]  # to warm up
    assert order[-1] == "longer"  # 3 times 0.2 s, of 60 shares of 5 s
    assert sorted(order) == sorted(["first", "longer", *(f"fast {k}" for k in range(60))])


def test_cancelling_stops_between_runs():
    progress = ifa.Progress()

    def run(repeat):
        progress.cancel()
        return Outcome(1.0, 1.0)

    with pytest.raises(ifa.Cancelled):
        measure([study(Setting("one", run))], repeats=2, progress=progress)


def test_a_part_of_a_progress_cancels_and_counts_within_its_whole():
    whole = ifa.Progress()
    part = whole.part(0.5, 0.7)
    part.raise_to(0.5)
    assert whole.fraction == pytest.approx(0.6, abs=1e-12)
    part.raise_to(0.1)
    assert part.fraction == 0.5
    whole.cancel()
    assert part.cancelled
    other = ifa.Progress()
    other.part(0.0, 1.0).cancel()
    assert not other.cancelled
    orphan = ifa.Progress().part(0.0, 1.0)  # keeps its whole
    orphan.raise_to(1.0)
    assert not orphan.cancelled


# What the knobs measure


def test_errors_fall_with_the_step():
    """ODE that steps through flights misses contacts by up to a step, which 20 throws average.

    A step eight times finer must then at least halve the mean: a throw whose contacts come in
    another order, which no step puts right, is one in a few dozen.
    """
    body = ifa.bodies.get("ball")
    throws = Throws(Scene(body, BALL_MARKS), 20, 3)
    reference = Reference(throws, event_simulation(body, 1e-4))
    coarse, fine = (
        measured(reference, ode_simulation(body, step_s, "stepped"))(0).error
        for step_s in (4e-3, 5e-4)
    )
    assert 0.0 < fine < 0.5 * coarse
    # A ball's contacts are exact for the event engine, whatever its step.
    assert measured(reference, event_simulation(body, 4e-3))(0).error == 0.0


def test_sustained_contact_is_better_with_finer_steps():
    """The event engine errs only by what it steps through; a quarter of the step at most half."""
    body = ifa.bodies.get("card")
    throws = Throws(Scene(body, BALL_MARKS, seed=1), 30, 4)
    reference = Reference(throws, event_simulation(body, 2e-5))
    coarse, fine = (
        measured(reference, event_simulation(body, step_s))(0).error for step_s in (4e-3, 2.5e-4)
    )
    assert 0.0 < fine < 0.5 * coarse


def test_throws_without_the_contact_are_losses():
    """A dead ball is heard once; of the others all contacts are."""
    body = ifa.bodies.get("ball")
    throws = Throws(Scene(body, BALL_MARKS), 5, 3)
    alive, dead = (event_simulation(b, 1e-3) for b in (body, body.replace(restitution=0.0)))
    short = "5 of 5 throws: fewer than 3 audible contacts"
    assert measured(Reference(throws, alive), dead)(0).failure == short
    assert measured(Reference(throws, dead), alive)(0).failure == f"{short} in the reference"

    def some(state, until_s):
        return (dead if state.velocity_m_s[0] > 0.0 else alive)(state, until_s)

    outcome = measured(Reference(throws, alive), some)(0)
    count = sum(throw.state.velocity_m_s[0] > 0.0 for throw in throws.of(0))
    assert 0 < count < 5
    assert outcome.losses == (f"{count} of 5 throws: fewer than 3 audible contacts",)
    assert (outcome.error, outcome.failure) == (0.0, "")


@pytest.mark.parametrize("knob", ["hull_detail", "rounding"])
def test_the_body_as_it_is_has_no_error(knob):
    scene = Scene(ifa.bodies.get("eraser"), BALL_MARKS)
    for make in KNOBS[knob]:
        [*others, whole] = make(scene, quick=True).settings
        assert whole.run(0).error == 0.0
        assert any(setting.run(0).error > 0.0 for setting in others)


def test_mass_property_error_of_a_scaled_solid():
    """Of a solid f times as large: the volume f^3, the centre where it was, the inertia f^5."""
    wanted = 2.0, np.zeros(3), np.diag([1.0, 2.0, 3.0]), 0.5
    scaled = 2.0 * 1.1**3, np.zeros(3), np.diag([1.0, 2.0, 3.0]) * 1.1**5, 0.55
    assert mass_property_error(scaled, wanted) == pytest.approx(100.0 * (1.1**5 - 1.0), rel=1e-12)
    moved = (2.0, np.array([0.0, 0.1, 0.0]), *wanted[2:])
    assert mass_property_error(moved, wanted) == pytest.approx(20.0, rel=1e-12)


def parabola_motion():
    """A solved ball, which flies between its contacts without spin to speak of."""
    return Scene(ifa.bodies.get("ball"), BALL_MARKS).solution.motion


def test_errors_between_keys_of_a_parabola():
    """Linear curves cut the corner of a parabola by g dt^2 / 8, in the middle between two keys."""
    motion = parabola_motion()
    hits_s = motion.contact_times_s
    begin_s, end_s = hits_s[0] + 1e-6, hits_s[1] - 1e-6
    keys_s = np.linspace(begin_s, end_s, 6)
    middles_s = 0.5 * (keys_s[1:] + keys_s[:-1])
    got = keys.between_keys(keys_s, motion.sample(keys_s), middles_s)
    wrong_mm, _ = keys.pose_errors(got, motion.sample(middles_s))
    retime = motion.retime[1]  # a flight that is stretched by it falls with g / retime^2
    wanted_mm = 1e3 * 9.81 / retime**2 * (keys_s[1] - keys_s[0]) ** 2 / 8.0
    np.testing.assert_allclose(wrong_mm, wanted_mm, rtol=1e-9)  # roundings of mm in m


def test_angles_between_poses():
    half = np.radians([0.0, 1e-4, 30.0, 90.0]) / 2.0
    turned = np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=1)
    still = np.tile([-1.0, 0.0, 0.0, 0.0], (4, 1))  # the same orientation as +1
    where = np.zeros((4, 3))
    _, angles_deg = keys.pose_errors((where, turned), (where, still))
    np.testing.assert_allclose(angles_deg, [0.0, 1e-4, 30.0, 90.0], atol=1e-12)  # roundings


def test_keys_at_contacts_are_in_the_motion():
    motion = parabola_motion()
    even_s, all_s = (keys.key_times(motion, 24.0, contacts=c) for c in (False, True))
    assert set(even_s) <= set(all_s)
    assert set(motion.contact_times_s) <= set(all_s) | {motion.start_s, motion.end_s}
    assert (all_s[0], all_s[-1]) == (motion.start_s, motion.end_s)
    assert np.diff(even_s)[:-1] == pytest.approx(1.0 / 24.0, abs=1e-12)


def test_wider_floats_err_less():
    make = KNOBS["float_width"][0]
    half, single, double = (
        setting.run(0).error
        for setting in make(Scene(ifa.bodies.get("ball"), BALL_MARKS), quick=True).settings
    )
    assert half > 1000.0 * single > 0.0  # 13 bits are a factor of 8192
    assert double == 0.0


# Tables, pictures and the page


def test_a_setting_that_mostly_fails_is_not_on_the_front():
    """Its one good repeat is the best of all; the median over all three is a failure."""
    lucky = scripted(Outcome(1.0, 0.1), Outcome(1.0, 0.0, "missed"), Outcome(1.0, 0.0, "missed"))
    sure = scripted(*[Outcome(2.0, 0.5)] * 3)
    (curve,) = measure([study(Setting("lucky", lucky), Setting("sure", sure))], repeats=3)
    assert [p.on_front for p in curve.points] == [False, True]
    assert [p.success for p in curve.points] == [pytest.approx(1 / 3), 1.0]


def test_what_runs_at_the_deadline_is_cancelled_and_counts_as_not_reached():
    running = ifa.Progress()

    def endless(repeat):
        while not running.cancelled:
            time.sleep(0.001)
        raise ifa.Cancelled("cancelled")

    quick = scripted(*[Outcome(1.0, 0.5)] * 2)
    studies = [study(Setting("quick", quick)), study(Setting("endless", endless), knob="endless")]
    deadline_s = time.monotonic() + 0.2
    curves = measure(studies, repeats=2, deadline_s=deadline_s, running=running)
    (point,) = curves[1].points
    assert point.repeats == 0 and point.not_reached == 2 and not point.failures
