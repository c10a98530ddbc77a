"""Solving from Python: the contract's names and shapes, and motions that the verifier accepts."""

import json
import math
import threading

import ifa
import numpy as np
import pytest

EVENT_FIELDS = [
    "target_s",
    "achieved_s",
    "error_s",
    "error_retimed_s",
    "retime",
    "excess",
    "factors",
]
FACTORS = ["velocity", "orientation", "time", "amplitude", "length", "centroid"]


@pytest.fixture(scope="module")
def die():
    return ifa.bodies.get("d6", surface="desk")


def marks_of_a_throw(body, seed, most=6):
    """Marks of a simulated throw: a motion that meets them exactly exists."""
    random = np.random.default_rng(seed)
    while True:
        q = random.normal(size=4)
        state = ifa.State(
            (0, 0, 0.05),
            q,
            (*random.uniform(-0.7, 0.7, 2), -random.uniform(0.3, 1.0)),
            random.uniform(-12, 12, 3),
        )
        run = ifa.simulate(body, state, until_s=20.0)
        speeds = run.hits.approach_speed_m_s
        times = run.hits.time_s[speeds >= 0.05]
        impulses = np.linalg.norm(run.hits.impulse_n_s, axis=1)[speeds >= 0.05]
        first = np.concatenate([[True], np.diff(times) >= 0.0105])  # a chain is one event
        clear = not (np.abs(speeds / 0.05 - 1) < 0.06).any()
        if run.status == "rest" and clear and 3 <= first.sum() <= most:
            return ifa.Signature(0.2 + times[first], amplitudes=impulses[first])


@pytest.fixture(scope="module")
def solved(die):
    marks = marks_of_a_throw(die, 1)
    return ifa.solve(die, marks, rung=0)


class TestContract:
    def test_solution_has_the_contracts_fields(self, solved):
        assert solved.succeeded
        assert 0.0 < solved.score <= 1.0 and 0.0 < solved.score_without_sound <= 1.0
        assert isinstance(solved.plausible, bool) and isinstance(solved.succeeded, bool)
        assert solved.missed_hits == solved.extra_hits == 0
        assert solved.max_abs_error_s <= 1e-3 and solved.max_penetration_m <= 1e-4
        assert solved.simulated_s > 0.0 and solved.solve_s > 0.0
        assert (solved.seed, solved.rung, solved.method) == (0, 0, "forward")
        assert isinstance(solved.effects, ifa.Plan) and solved.effects["amplitude_matching"]
        assert solved.restitution == solved.body.restitution
        assert len(solved.events) == len(solved.marks)

    def test_events(self, solved):
        logs = 0.0
        for event, target in zip(solved.events, solved.marks.times_s, strict=True):
            assert list(vars(event)) == EVENT_FIELDS
            assert sorted(event.factors) == sorted(FACTORS)
            assert event.target_s == target
            assert event.error_retimed_s == event.achieved_s - event.target_s
            logs += sum(math.log(f) for f in event.factors.values())
        # eq. 12
        assert solved.score == pytest.approx(math.exp(logs / (6 * len(solved.events))), rel=1e-12)
        intervals = np.diff(solved.marks.times_s)
        for event, target in zip(solved.events[1:], intervals, strict=True):
            assert event.retime == pytest.approx(target / (target + event.error_s), rel=1e-12)

    def test_motion_samples(self, solved):
        motion = solved.motion
        times = np.linspace(motion.start_s - 0.1, motion.end_s + 0.1, 200)
        positions, quaternions = motion.sample(times)
        assert positions.shape == (200, 3) and quaternions.shape == (200, 4)
        assert positions.dtype == quaternions.dtype == np.float64
        assert positions.flags.c_contiguous and quaternions.flags.c_contiguous
        np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, atol=1e-14)
        assert (np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1]) >= 0).all()
        np.testing.assert_array_equal(positions[0], positions[1])  # held still before it begins
        empty, none = motion.sample([])
        assert empty.shape == (0, 3) and none.shape == (0, 4)

    def test_velocities_are_those_of_the_poses(self, solved):
        motion = solved.motion
        t = motion.contact_times_s[0] - 0.02  # in the first flight
        h = 1e-5
        positions, _ = motion.sample([t - h, t + h])
        velocities, spins = motion.sample_velocity([t])
        assert velocities.shape == spins.shape == (1, 3)
        # a parabola's central difference is exact; rounding of 1e-16 over h
        np.testing.assert_allclose(
            (positions[1] - positions[0]) / (2 * h), velocities[0], atol=1e-9
        )

    def test_velocities_jump_at_impacts(self, solved):
        t = solved.marks.times_s[:1]
        before, _ = solved.motion.sample_velocity(t, side="left")
        after, _ = solved.motion.sample_velocity(t, side="right")
        # The hit's own impulse, changed by up to 40 % along it, and scaled by the retiming after.
        impulse = solved.body.mass_kg * (after - before)[0]
        np.testing.assert_allclose(impulse[2], solved.motion.hits["impulse_n_s"][0, 2], rtol=0.5)
        assert impulse[2] > 0.0

    def test_keys_hold_every_impact_and_a_millisecond_at_most(self, solved):
        motion = solved.motion
        steps = np.diff(motion.times_s)
        assert (steps > 0).all() and steps.max() <= 1e-3
        assert np.isin(motion.contact_times_s, motion.times_s).all()
        assert motion.positions_m.shape == (len(motion.times_s), 3)
        assert motion.quaternions_wxyz.shape == (len(motion.times_s), 4)
        hits = motion.hits
        assert set(hits) == {"time_s", "impulse_n_s", "approach_speed_m_s", "position_m"}
        audible = hits["time_s"][hits["approach_speed_m_s"] >= 0.05]
        for mark in solved.marks.times_s:
            assert np.abs(audible - mark).min() < 1e-9

    def test_bad_samples(self, solved):
        with pytest.raises(ifa.IfaValueError, match=r"^times_s:"):
            solved.motion.sample(0.5)
        with pytest.raises(ifa.IfaValueError, match=r"^times_s"):
            solved.motion.sample([np.nan])
        with pytest.raises(ifa.IfaValueError, match=r"^side:"):
            solved.motion.sample_velocity([0.5], side="before")

    def test_to_dict_is_json_and_complete(self, solved):
        plain = json.loads(json.dumps(solved.to_dict(), allow_nan=False))
        assert plain["version"] == ifa.__version__
        assert plain["score"] == solved.score
        assert set(plain["events"][0]) == set(EVENT_FIELDS)
        assert None not in plain.values()

    def test_written_file_is_the_motion(self, solved, tmp_path):
        path = tmp_path / "out.json"
        solved.write(path)
        data = json.loads(path.read_text())
        np.testing.assert_array_equal(data["times_s"], solved.motion.times_s)
        np.testing.assert_array_equal(data["positions_m"], solved.motion.positions_m)
        np.testing.assert_array_equal(data["quaternions_wxyz"], solved.motion.quaternions_wxyz)
        assert data["hits"]["time_s"] == solved.motion.contact_times_s.tolist()
        assert [e["time_s"] for e in data["marks"]["events"]] == list(solved.marks.times_s)
        assert ifa.verify(path, solved.body, solved.marks).passed
        with pytest.raises(ifa.IfaValueError, match="json"):
            solved.write(tmp_path / "out.csv")
        with pytest.raises(ifa.IfaFileError):
            solved.write(tmp_path / "nowhere" / "out.json")


class TestSearch:
    # The verifier shares no code with the search.
    def test_meets_marks_of_its_own_throws(self, die):
        succeeded = 0
        for seed in range(2, 6):
            marks = marks_of_a_throw(die, seed)
            solution = ifa.solve(die, marks, rung=0, seed=seed)
            certificate = ifa.verify(
                solution.motion,
                solution.body,
                marks,
                retime=[event.retime for event in solution.events],
            )
            assert certificate.passed or not solution.succeeded, certificate.summary()
            if solution.succeeded:
                assert certificate.missed_hits == certificate.extra_hits == 0
                assert certificate.max_abs_error_s < 1e-6
                assert certificate.at_rest
            succeeded += solution.succeeded
        assert succeeded >= 3  # the smallest beam may miss one

    def test_same_bytes_for_any_number_of_threads(self, die):
        marks = ifa.Signature([0.2, 0.3, 0.36], ending="open")
        runs = [ifa.solve(die, marks, rung=0, threads=n, seed=7) for n in (1, 2, 3)]
        assert len({r.motion.positions_m.tobytes() for r in runs}) == 1
        assert len({r.motion.quaternions_wxyz.tobytes() for r in runs}) == 1
        assert len({r.score for r in runs}) == 1

    def test_endings(self, die):
        rest = ifa.solve(die, ifa.Signature([0.4]), rung=0)
        last = rest.motion.contact_times_s[rest.motion.hits["approach_speed_m_s"] >= 0.05][-1]
        assert last < 0.4 + 0.0101 * rest.motion.contact_times_s.size  # one event, then silence
        before, _ = rest.motion.sample([rest.motion.end_s - 0.05])
        after, _ = rest.motion.sample([rest.motion.end_s])
        assert np.linalg.norm(after - before) < 0.01 * 0.05  # rest: slower than 0.01 m/s
        open_ = ifa.solve(die, ifa.Signature([0.4], ending="open"), rung=0)
        assert open_.succeeded and open_.score == 1.0
        assert not open_.effects["settling_to_rest"]

    def test_material_fit_says_what_it_chose(self):
        ball = ifa.Body.ball(0.02, mass_kg=0.03, restitution=0.3)
        marks = ifa.Signature([0.1, 0.35, 0.5, 0.59], ending="open")  # gaps shrink by 0.6
        solution = ifa.solve(ball, marks, material="fit", rung=0)
        assert solution.plausible
        assert abs(solution.restitution - 0.6) <= 0.16
        assert solution.body.restitution == solution.restitution
        assert solution.effects["material_fit"]

    def test_inputs_stay_as_they_were(self, die):
        marks = ifa.Signature([0.2, 0.3], ending="open")
        before = (die.to_dict(), marks.to_dict())
        ifa.solve(die, marks, rung=0)
        assert (die.to_dict(), marks.to_dict()) == before

    def test_cancel_from_another_thread(self, die):
        progress = ifa.Progress()
        marks = ifa.Signature(np.arange(20) * 0.1)
        timer = threading.Timer(0.05, progress.cancel)
        timer.start()
        with pytest.raises(ifa.Cancelled):
            ifa.solve(die, marks, rung=4, progress=progress)
        assert 0.0 <= progress.fraction < 1.0


class TestErrors:
    @pytest.mark.parametrize(
        ("name", "options"),
        [
            ("method", {"method": "magic"}),
            ("events", {"events": "heard"}),
            ("material", {"material": "wood"}),
            ("takes", {"takes": 0}),
            ("constraints", {"constraints": ["face up"]}),
            ("energy_gain_j", {"energy_gain_j": -1.0}),
            ("energy_gain_j", {"energy_gain_j": np.nan}),
            ("energy_gain_j", {"energy_gain_j": np.inf}),
            ("energy_gain_j", {"energy_gain_j": "much"}),
            ("seed", {"seed": -1}),
            ("seed", {"seed": 1.5}),
            ("seed", {"seed": 2**64}),
            ("seed", {"seed": True}),
            ("threads", {"threads": -1}),
            ("threads", {"threads": 2.0}),
            ("time_budget_s", {"time_budget_s": 0.0}),
            ("time_budget_s", {"time_budget_s": "soon"}),
            ("accuracy", {"accuracy": "perfect"}),
            ("accuracy", {"accuracy": None}),
            ("prediction", {"prediction": 1.0}),
            ("rung", {"rung": -1}),
            ("rung", {"rung": 99}),
            ("body", {"body": "d6"}),
            ("marks", {"marks": [0.1, 0.2]}),
        ],
    )
    def test_name_the_argument(self, die, name, options):
        arguments = {"body": die, "marks": ifa.Signature([0.1])} | options
        with pytest.raises(ifa.IfaValueError, match=f"^{name}:"):
            ifa.solve(arguments.pop("body"), arguments.pop("marks"), **arguments)

    def test_are_ifa_errors_and_value_errors(self, die):
        with pytest.raises(ValueError):
            ifa.solve(die, ifa.Signature([0.1]), seed=-1)
        with pytest.raises(ifa.IfaError):
            ifa.solve(die, ifa.Signature([0.1]), seed=-1)
        assert issubclass(ifa.NoMotionError, ifa.IfaError)

    def test_options_are_named_ones(self, die):
        with pytest.raises(TypeError):
            ifa.solve(die, ifa.Signature([0.1]), "forward")


@pytest.mark.parametrize("seed", range(4))
def test_a_mark_with_a_duration_is_judged_alike_by_solver_and_verifier(seed):
    body = ifa.bodies.get("eraser")
    marks = ifa.Signature([0.3, 0.5, 0.9], durations_s=[0.0, 0.15, 0.0])
    solution = ifa.solve(body, marks, rung=0, seed=seed)
    certificate = ifa.verify(solution.motion, body, marks)
    assert certificate.passed or not solution.succeeded, certificate.failures
