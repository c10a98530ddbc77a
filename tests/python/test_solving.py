"""What a solve can be asked for beside marks: takes, contact events, a lead-in, an earlier solve.

Every motion is checked by the verifier, which shares no code with the search.
"""

import ifa
import numpy as np
import pytest

TOSS = ifa.Signature([0.3, 0.42, 0.5, 0.56], ending="open")


@pytest.fixture(scope="module")
def die():
    return ifa.bodies.get("d6", surface="desk")


def thrown(body, seed, most=6):
    """Marks of a simulated throw: a motion that meets them exactly exists."""
    states = ifa.sample_states(body, 200, seed=seed)
    for i in range(200):
        run = ifa.simulate(body, states[i], until_s=20.0)
        clear = not (np.abs(run.hits.approach_speed_m_s / 0.05 - 1) < 0.06).any()
        if run.status == "rest" and clear:
            marks = ifa.Signature.from_run(run)
            if 3 <= len(marks) <= most:
                return marks
    raise AssertionError("no such throw")


def verified(solution):
    """The solution, if the verifier agrees with what it says of itself."""
    certificate = ifa.verify(
        solution.motion,
        solution.body,
        solution.marks,
        events=solution.motion.hearing["events"],
    )
    assert certificate.passed or not solution.succeeded, certificate.summary()
    return solution


def same_motion(a, b):
    return (
        a.motion.positions_m.tobytes() == b.motion.positions_m.tobytes()
        and a.motion.quaternions_wxyz.tobytes() == b.motion.quaternions_wxyz.tobytes()
    )


class TestTakes:
    def test_are_plausible_and_clearly_different(self, die):
        solution = ifa.solve(die, TOSS, takes=4, rung=0)
        takes = solution.takes
        assert len(takes) == 4 and takes[0] is solution
        first, last = TOSS.times_s[0], TOSS.times_s[-1]
        for i, take in enumerate(takes):
            assert verified(take).plausible
            assert take.takes == (take,) or i == 0
            for other in takes[:i]:
                difference = take.motion.difference(other.motion, first, last)
                assert difference >= ifa.CLEARLY_DIFFERENT
        scores = [take.score for take in takes[1:]]  # after the solve's own motion
        assert scores == sorted(scores, reverse=True)

    def test_are_the_same_for_any_number_of_threads(self, die):
        takes = [ifa.solve(die, TOSS, takes=3, rung=0, threads=n, seed=3).takes for n in (1, 2, 3)]
        for others in takes[1:]:
            assert len(others) == len(takes[0])
            assert all(same_motion(a, b) for a, b in zip(takes[0], others, strict=True))

    def test_one_is_the_default(self, die):
        solution = ifa.solve(die, TOSS, rung=0)
        assert solution.takes == (solution,)

    def test_fewer_than_asked_may_be_found(self):
        ball = ifa.Body.ball(0.02, mass_kg=0.03, restitution=0.4)
        out_of_reach = ifa.Signature([0.2, 0.3, 0.8], ending="open")
        solution = ifa.solve(ball, out_of_reach, takes=5, rung=0)
        assert not solution.succeeded and len(solution.takes) == 1


class TestReuse:
    @pytest.mark.parametrize("k", [1, 2, 3])
    def test_a_nudged_mark_is_met(self, die, k):
        before = ifa.solve(die, TOSS, rung=0)
        times = np.array(TOSS.times_s)
        times[k] += 0.004
        marks = ifa.Signature(times, ending="open")
        runs = [ifa.solve(die, marks, rung=0, reuse=before, threads=n) for n in (1, 2)]
        assert verified(runs[0]).plausible
        assert same_motion(*runs)
        assert runs[0].simulated_s < before.simulated_s  # the same up to mark k: less is left to do

    def test_one_edit_follows_another(self, die):
        marks = thrown(die, 1)
        solution = ifa.solve(die, marks, rung=0)
        for _ in range(3):
            times = np.array(solution.marks.times_s)
            times[-1] += 0.002
            edited = ifa.Signature(times, amplitudes=marks.amplitudes)
            solution = verified(ifa.solve(die, edited, rung=0, reuse=solution))
            assert solution.succeeded

    def test_after_a_change_of_the_first_mark_it_is_a_fresh_solve(self, die):
        before = ifa.solve(die, TOSS, rung=0)
        moved = ifa.Signature([0.29, *TOSS.times_s[1:]], ending="open")
        again = ifa.solve(die, moved, rung=0, reuse=before)
        assert same_motion(again, ifa.solve(die, moved, rung=0))

    @pytest.mark.parametrize(
        "options",
        [{"events": "contact"}, {"energy_gain_j": 1e-3}, {"material": "fit"}],
    )
    def test_of_other_options_is_an_error(self, die, options):
        before = ifa.solve(die, TOSS, rung=0)
        with pytest.raises(ifa.IfaValueError, match=r"^reuse:"):
            ifa.solve(die, TOSS, rung=0, reuse=before, **options)

    def test_goes_through_marks_that_cannot_be_met(self):
        """The materials of a fit depend on the marks: what is kept keeps its own."""
        die = ifa.bodies.get("d6", surface="wood")
        solution = None
        for last in (0.517, 1.3, 0.52):
            marks = ifa.Signature([0.2, 0.4, 0.48, last], ending="open")
            solution = ifa.solve(die, marks, material="fit", rung=0, reuse=solution)
            assert len(solution.events) == 4
        assert verified(solution).succeeded

    def test_of_another_body_or_of_a_take_is_an_error(self, die):
        before = ifa.solve(die, TOSS, rung=0, takes=2)
        for body in (
            die.replace(restitution=0.3),
            die.replace(mass_kg=0.006),
            ifa.bodies.get("d8"),
        ):
            with pytest.raises(ifa.IfaValueError, match=r"^reuse:"):
                ifa.solve(body, TOSS, rung=0, reuse=before)
        with pytest.raises(ifa.IfaValueError, match=r"^reuse:.*takes"):
            ifa.solve(die, TOSS, rung=0, reuse=before.takes[1])
        with pytest.raises(ifa.IfaValueError, match=r"^reuse:"):
            ifa.solve(die, TOSS, rung=0, reuse=before.motion)


class TestLeadIn:
    def test_is_as_long_as_asked_where_nothing_is_in_the_way(self, die):
        solutions = {s: ifa.solve(die, TOSS, rung=0, lead_in_s=s) for s in (0.02, 0.1, 2.0)}
        for asked, solution in solutions.items():
            lead = TOSS.times_s[0] - verified(solution).motion.start_s
            wanted = min(asked, TOSS.times_s[0])  # not before the sound begins
            if lead != pytest.approx(wanted, abs=1e-12):
                assert lead < wanted
                self.comes_from_the_ground(solution)
        times = np.linspace(TOSS.times_s[0], TOSS.times_s[-1], 50)
        poses = [s.motion.sample(times)[0] for s in solutions.values()]
        np.testing.assert_array_equal(poses[0], poses[1])
        np.testing.assert_array_equal(poses[0], poses[2])

    @staticmethod
    def comes_from_the_ground(solution):
        motion, body = solution.motion, solution.body
        position, quaternion = motion.sample([motion.start_s])
        velocity, spin = motion.sample_velocity([motion.start_s])
        backwards = ifa.State(position[0], quaternion[0], -velocity[0], -spin[0])
        run = ifa.simulate(body, backwards, until_s=1.0)
        assert run.hits.time_s[0] < 2e-3  # a thousandth of the flight is left

    @pytest.mark.parametrize("lead_in_s", [0.0, -1.0, np.nan, np.inf, "long", None])
    def test_must_be_a_positive_number(self, die, lead_in_s):
        with pytest.raises(ifa.IfaValueError, match=r"^lead_in_s:"):
            ifa.solve(die, TOSS, lead_in_s=lead_in_s)


class TestContactEvents:
    @pytest.mark.parametrize("name", ["d6", "eraser"])
    def test_are_met(self, name):
        body = ifa.bodies.get(name)
        runs = [ifa.solve(body, TOSS, events="contact", rung=0, threads=n) for n in (1, 2, 3)]
        assert verified(runs[0]).plausible
        assert same_motion(runs[0], runs[1]) and same_motion(runs[0], runs[2])

    def test_are_another_question_than_what_is_heard(self, die):
        """A motion for what is heard touches the ground in silence between the marks."""
        marks = thrown(die, 3)
        heard = verified(ifa.solve(die, marks, rung=1))
        assert heard.succeeded
        assert not ifa.verify(heard.motion, heard.body, marks, events="contact").passed

    def test_written_file_says_so_and_passes_as_such(self, tmp_path):
        ball = ifa.Body.ball(0.02, mass_kg=0.03, restitution=0.5)
        bounces = [0.1, 0.4, 0.55, 0.625, 0.6625, 0.68125]  # each flight half as long
        solution = ifa.solve(ball, ifa.Signature(bounces), events="contact", rung=0)
        assert verified(solution).plausible
        solution.write(tmp_path / "out.json")
        certificate = ifa.verify(tmp_path / "out.json", ball, solution.marks)
        assert certificate.passed and certificate.options["events"] == "contact"
