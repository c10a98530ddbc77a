"""Presets of accuracy, what was recorded about them, and predictions made before a solve."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import subprocess
import sys
import threading

import ifa
import numpy as np
import pytest
from ifa import accuracy, prediction
from ifa.prediction import FACTOR, Rung, expected, most_probable

NAMES = ("draft", "good", "best")
MARKS = ifa.Signature([0.3, 0.42, 0.5, 0.56], ending="open")
DRAFT, GOOD, BEST = (ifa.ACCURACIES[name] for name in NAMES)


@pytest.fixture(scope="module")
def die():
    return ifa.bodies.get("d6", surface="desk")


def poses(solution):
    return (
        solution.motion.positions_m.tobytes(),
        solution.motion.quaternions_wxyz.tobytes(),
        solution.rung,
    )


class Ticks:
    """A clock that goes on by the same step whenever it is looked at."""

    def __init__(self, step_s):
        self._counts, self._step_s = itertools.count(), step_s

    def __call__(self):
        return next(self._counts) * self._step_s


def standing_still():
    return 0.0


# --- presets -------------------------------------------------------------------------------------


class TestPresets:
    def test_are_three_from_fast_to_accurate(self):
        assert tuple(ifa.ACCURACIES) == NAMES
        for each, (name, preset) in zip(NAMES, ifa.ACCURACIES.items(), strict=True):
            assert preset.name == name == each
            assert list(preset.ladder) == sorted(set(preset.ladder))
            assert 0 <= preset.least_rung < len(preset.ladder)
        for rough, fine in itertools.pairwise(ifa.ACCURACIES.values()):
            assert rough.key_position_m > fine.key_position_m > 0.0
            assert rough.key_angle_rad > fine.key_angle_rad > 0.0

    def test_recorded_points_cost_more_and_err_less(self):
        points = {point["preset"]: point for point in accuracy.recorded()["points"]}
        own = [points[name] for name in NAMES]
        for rough, fine in itertools.pairwise(own):
            assert rough["time_mean_s"] < fine["time_mean_s"]
            assert rough["error_mean"] > fine["error_mean"]
            assert rough["plausible"] <= fine["plausible"]
        # a point of the curve: nothing measured is both faster and more accurate
        for point, other in itertools.product(own, points.values()):
            assert not (
                other["time_mean_s"] < point["time_mean_s"]
                and other["error_mean"] < point["error_mean"]
            ), (point["preset"], other["preset"])

    def test_recorded_data_says_where_and_when(self):
        measured = accuracy.recorded()["measured"]
        assert measured["machine"] and measured["date"] and measured["version"]
        assert sum(measured["cases"].values()) == len(accuracy.recorded()["climbs"])

    def test_good_is_the_default_to_the_last_byte(self, die):
        assert GOOD.ladder == ifa._core.LADDER
        for seed in range(3):
            default = ifa.solve(die, MARKS, seed=seed, time_budget_s=60.0)
            good = ifa.solve(die, MARKS, seed=seed, time_budget_s=60.0, accuracy="good")
            assert poses(default) == poses(good)
            assert default.accuracy == good.accuracy == "good"

    def test_presets_climb_as_far_as_they_say(self, die):
        draft = ifa.solve(die, MARKS, accuracy="draft", time_budget_s=60.0)
        assert draft.succeeded
        # it is the first of its rungs that succeeds
        for rung in range(draft.rung + 1):
            alone = ifa.solve(die, MARKS, accuracy="draft", rung=rung)
            assert alone.succeeded == (rung == draft.rung)
        assert poses(alone) == poses(draft)

        best = ifa.solve(die, MARKS, accuracy="best", time_budget_s=600.0)
        rungs = [
            ifa.solve(die, MARKS, accuracy="best", rung=rung) for rung in range(BEST.least_rung + 1)
        ]
        assert best.error == min(rung.error for rung in rungs if rung.plausible)

    def test_ones_own_can_be_given(self, die):
        own = dataclasses.replace(GOOD, name="narrow", ladder=(GOOD.ladder[0],))
        solution = ifa.solve(die, MARKS, accuracy=own)
        assert poses(solution) == poses(ifa.solve(die, MARKS, rung=0))
        assert solution.accuracy == "narrow"
        made = ifa.predict(die, MARKS, accuracy=own, clock=standing_still)
        assert made.reached and made.error == solution.error

    @pytest.mark.parametrize(
        ("field", "value"),
        [
            ("ladder", (20, 10)),
            ("ladder", (0,)),
            ("ladder", (40.5,)),
            ("ladder", ()),
            ("least_rung", 99),
            ("until", "perfect"),
            ("time_budget_s", 0.0),
        ],
    )
    def test_bad_ones_are_named(self, die, field, value):
        with pytest.raises(ifa.IfaValueError, match=f"^{field}:"):
            ifa.solve(die, MARKS, accuracy=dataclasses.replace(GOOD, **{field: value}))

    def test_are_not_for_the_graph(self, die):
        with pytest.raises(ifa.IfaValueError, match=r"^accuracy:"):
            ifa.solve(die, MARKS, method="graph", accuracy="draft")


# --- the model, by hand --------------------------------------------------------------------------


def climb(*rungs):
    return {rung.beam: rung for rung in (Rung(*values) for values in rungs)}


class TestExpected:
    """A preset of three rungs, and recorded climbs of which the outcome is counted by hand."""

    PRESET = dataclasses.replace(GOOD, ladder=(10, 30, 90), time_budget_s=1e6)
    EASY = 4, climb((10, 1.0, True, True, 0.1))
    LATER = 4, climb((10, 1.0, True, False, 0.3), (30, 4.0, True, True, 0.2))

    def test_what_was_seen_to_its_end_is_the_outcome(self):
        seen = climb((10, 0.5, False, False, 1.0), (30, 2.0, True, True, 0.25))
        assert expected(self.PRESET, seen, 4, [self.EASY]) == (2.5, 0.25)

    def test_goes_on_as_a_recorded_climb_that_looked_the_same(self):
        seen = climb((10, 0.5, True, False, 0.9))
        # half as slow as the recorded one: 0.5 + 4.0 / 2, and its end
        time_s, error = expected(self.PRESET, seen, 4, [self.EASY, self.LATER])
        assert time_s == pytest.approx(2.5, rel=1e-12)
        assert error == pytest.approx(0.2, rel=1e-12)

    def test_a_better_motion_improves_as_a_recorded_one_did(self):
        preset = dataclasses.replace(self.PRESET, least_rung=1)
        seen = climb((10, 1.0, True, True, 0.4))
        record = 4, climb((10, 1.0, True, True, 0.3), (30, 2.0, True, True, 0.15))
        assert expected(preset, seen, 4, [record]) == pytest.approx((3.0, 0.2), rel=1e-12)

    def test_a_larger_rung_is_scaled_where_nothing_of_the_ladder_was_seen(self):
        preset = dataclasses.replace(self.PRESET, ladder=(30, 90))
        seen = climb((10, 2.0, False, False, 1.0))
        assert expected(preset, seen, 4, [self.LATER])[0] == pytest.approx(8.0, rel=1e-12)

    def test_a_beam_that_was_not_recorded_is_scaled_from_the_nearest(self):
        preset = dataclasses.replace(self.PRESET, ladder=(20, 60))
        seen = climb((20, 2.0, False, False, 1.0))
        # 30 in 4 s, so 20 in 8/3 s: this scene is faster by 3/4; and 60 in 8 s, here in 6 s
        assert expected(preset, seen, 4, [self.LATER]) == pytest.approx((8.0, 0.2), rel=1e-12)

    def test_a_rung_that_was_cut_off_says_nothing_of_its_end(self):
        preset = dataclasses.replace(self.PRESET, ladder=(10,))
        seen = climb((10, 3.0, False, False, 1.0, False))
        assert expected(preset, seen, 4, [self.EASY]) == pytest.approx((3.0, 0.1), rel=1e-12)

    def test_the_budget_ends_a_climb(self):
        preset = dataclasses.replace(self.PRESET, time_budget_s=1.0)
        seen = climb((10, 0.5, True, False, 0.9))
        assert expected(preset, seen, 4, [self.LATER]) == pytest.approx((0.5, 0.9), rel=1e-12)

    def test_the_most_probable_value_covers_most_weight(self):
        rng = np.random.default_rng(5)
        for _ in range(50):
            values = np.exp(rng.normal(0.0, 1.5, 30))
            weights = rng.uniform(0.1, 1.0, 30)

            def covered(x, values=values, weights=weights):
                close = (values <= x * FACTOR * (1 + 1e-12)) & (values >= x / FACTOR * (1 - 1e-12))
                return weights[close].sum()

            best = covered(most_probable(values, weights))
            # brute force; rounding of the sums
            assert best >= max(covered(x) for x in np.geomspace(0.01, 100.0, 2000)) - 1e-9


# --- predictions ---------------------------------------------------------------------------------


class TestPredict:
    def test_is_finite_and_positive_for_every_stop(self, die):
        predictions = ifa.predict_all(die, MARKS)
        assert tuple(predictions) == NAMES
        for name, each in predictions.items():
            assert each.accuracy == name
            assert 0.0 < each.time_s < math.inf
            assert 0.0 <= each.error <= 1.0
            assert each.calibration_s == predictions["good"].calibration_s

    def test_depends_on_the_clock_alone(self, die):
        first, again = (
            ifa.predict_all(die, MARKS, clock=standing_still, threads=threads) for threads in (1, 2)
        )
        assert first == again

    def test_has_seen_the_end_where_time_allows(self, die):
        prediction = ifa.predict(die, MARKS, clock=standing_still)
        solution = ifa.solve(die, MARKS, time_budget_s=600.0)
        assert prediction.reached and prediction.error == solution.error

    def test_has_not_where_it_does_not(self):
        # marks that no ball can meet: no rung reaches anything, so that only time ends it
        ball, marks = ifa.bodies.get("ball"), ifa.Signature([0.1, 0.2, 1.2, 1.3], ending="rest")
        prediction = ifa.predict(ball, marks, clock=Ticks(0.3))
        assert not prediction.reached
        assert 0.0 < prediction.time_s < math.inf

    def test_does_not_change_the_solve(self, die):
        before = ifa.solve(die, MARKS, time_budget_s=600.0)
        made = ifa.predict(die, MARKS)
        after = ifa.solve(die, MARKS, time_budget_s=600.0, prediction=made)
        assert poses(before) == poses(after)
        assert before.prediction is None and after.prediction is made
        assert "predicted" not in before.to_dict()
        assert after.to_dict()["predicted"] == {"time_s": made.time_s, "error": made.error}
        assert after.to_dict()["accuracy"] == "good"

    def test_can_be_cancelled(self, die):
        threads = threading.active_count()
        progress = ifa.Progress()
        progress.cancel()
        with pytest.raises(ifa.Cancelled):
            ifa.predict(die, ifa.Signature(np.linspace(0.1, 9.0, 200)), progress=progress)
        assert threading.active_count() == threads

    @pytest.mark.parametrize(
        ("field", "options"),
        [
            ("accuracy", {"accuracy": "perfect"}),
            ("takes", {"takes": 2}),
            ("seed", {"seed": -1}),
            ("time_budget_s", {"time_budget_s": 0.0}),
            ("progress", {"progress": 1}),
        ],
    )
    def test_bad_arguments_are_named(self, die, field, options):
        with pytest.raises(ifa.IfaValueError, match=f"^{field}:"):
            ifa.predict(die, MARKS, **options)

    def test_of_another_accuracy_is_refused(self, die):
        made = prediction.Prediction("draft", 1.0, 0.1, True, 0.1)
        with pytest.raises(ifa.IfaValueError, match=r"^prediction:"):
            ifa.solve(die, MARKS, prediction=made)


# --- the command line ----------------------------------------------------------------------------


def run(*arguments):
    command = [sys.executable, "-m", "ifa.cli", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


@pytest.fixture
def labels(tmp_path):
    path = tmp_path / "marks.txt"
    path.write_text("".join(f"{t}\t{t}\thit\n" for t in MARKS.times_s))
    return path


class TestCommandLine:
    def test_predicts_before_and_compares_after(self, labels):
        done = run("solve", "d6", labels, "--ending", "open", "--accuracy", "draft")
        assert done.returncode == 0, done.stderr
        assert "draft: predicted" in done.stderr
        assert "predicted" in done.stdout and "took" in done.stdout and "was" in done.stdout

    def test_json_has_both(self, labels):
        done = run("solve", "d6", labels, "--ending", "open", "--accuracy", "good", "--json")
        content = json.loads(done.stdout)
        assert content["accuracy"] == "good"
        assert content["predicted"]["time_s"] > 0.0 and content["solve_s"] > 0.0
        assert 0.0 <= content["predicted"]["error"] <= 1.0

    def test_without_it_nothing_is_predicted(self, labels):
        done = run("solve", "d6", labels, "--ending", "open", "--json")
        content = json.loads(done.stdout)
        assert content["accuracy"] == "good" and "predicted" not in content
        assert "predicted" not in done.stderr

    def test_bad_names_are_one_sentence(self, labels):
        done = run("solve", "d6", labels, "--accuracy", "perfect")
        assert done.returncode == 2 and done.stdout == ""
        assert len(done.stderr.splitlines()) == 1 and "--accuracy" in done.stderr
