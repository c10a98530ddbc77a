"""benchmarks/solve: its cases, its bars, its tables, and a run from end to end."""

from __future__ import annotations

import csv
import dataclasses
import json
import math
from itertools import product
from pathlib import Path

import ifa
import numpy as np
import pytest
from ifa.sound import write_wav

from benchmarks.solve import __main__ as benchmark
from benchmarks.solve import bars, cases, kinds, measure, recorded, report, rhythm, simulated

G = 9.81


def same(a, b):
    """Whether two lists hold the same cases, to the last bit."""
    return [(c.name, c.body.to_dict(), c.marks, c.material, c.events, c.before) for c in a] == [
        (c.name, c.body.to_dict(), c.marks, c.material, c.events, c.before) for c in b
    ]


# --- cases ---------------------------------------------------------------------------------------


def test_a_limit_spreads_over_all():
    items = list(range(100))
    assert cases.spread(items, 4) == [12, 37, 62, 87]  # the middles of four quarters
    assert cases.spread(items, 1) == [50]
    for limit in (None, 100, 101):
        assert cases.spread(items, limit) == items
    for n, limit in product(range(1, 12), range(1, 12)):
        picked = cases.spread(range(n), limit)
        assert len(picked) == min(n, limit) and picked == sorted(set(picked))


def test_the_real_body_is_off_by_as_much_as_is_said():
    box = ifa.Body.box((0.02, 0.03, 0.04), mass_kg=0.05, restitution=0.4)
    for k in range(6):
        size_m = np.array([0.02, 0.03, 0.04])
        size_m[k % 3] *= 1.03
        real = simulated.real(box, k)
        assert real.mass_kg == 0.05 and real.friction == box.friction
        assert real.restitution == pytest.approx(0.4 * (1.1 if k % 2 == 0 else 0.9), rel=1e-15)
        corners_m = np.tile(0.5 * size_m, (8, 1))
        np.testing.assert_allclose(np.abs(real.vertices_m), corners_m, rtol=1e-12)  # rounding
        moments = 0.05 / 12.0 * ((size_m**2).sum() - size_m**2)
        # 1e-12 of the largest: rounding of the integral over the hull
        np.testing.assert_allclose(real.inertia_kg_m2, np.diag(moments), atol=1e-12 * moments.max())


def test_round_bodies_stay_round():
    ball, coin = ifa.bodies.get("ball"), ifa.bodies.get("coin")
    real = simulated.real(ball, 0)
    assert real.radius_m == pytest.approx(1.03 * ball.radius_m, rel=1e-15)
    expected = 0.4 * ball.mass_kg * real.radius_m**2
    np.testing.assert_allclose(np.diag(real.inertia_kg_m2), expected, rtol=1e-12)  # rounding
    for k in range(3):
        rings_m = simulated.real(coin, k).rings_m
        np.testing.assert_allclose(rings_m[:, 2], 1.03 * coin.rings_m[:, 2], rtol=1e-12)
        np.testing.assert_array_equal(rings_m[:, 3:], coin.rings_m[:, 3:])


def test_simulated_cases_are_the_same_again_and_whatever_the_limit():
    few = simulated.simulated(limit=5)
    assert [case.name for case in few] == ["d6_00", "d10_00", "d20_00", "coin_00", "card_00"]
    assert same(few, simulated.simulated(limit=5))
    of_fifteen = [case for case in simulated.simulated(limit=15) if case.name == "d6_00"]
    assert same(of_fifteen, few[:1])
    for case in few:
        assert same([case], [cases.Case(case.name, ifa.bodies.get(case.body.name), case.marks)])
        assert case.marks.ending == "rest" and case.marks.amplitudes is not None
        assert case.marks.times_s[0] == 0.0  # a throw begins as it touches


def test_a_throw_that_makes_no_sound_is_drawn_again(monkeypatch):
    silent = [True, False, True, True, False]
    original, drawn = ifa.Signature.from_run, []

    def from_run(run):
        drawn.append(run)
        if silent[len(drawn) - 1]:
            raise ifa.IfaValueError("run: none of its hits is audible")
        return original(run)

    monkeypatch.setattr(ifa.Signature, "from_run", from_run)
    throws = simulated._heard("d6", seed=3)
    assert [next(throws), next(throws)] == [original(drawn[1]), original(drawn[4])]


def test_rolls_have_thirty_marks_of_a_throw():
    rolls = simulated.rolls(3)
    assert same(rolls, simulated.rolls(3))
    assert [case.body.name for case in rolls] == ["d12", "d20", "d10"]
    for case in rolls:
        assert len(case.marks) == 30 and case.marks.ending == "open"


def test_a_nudge_moves_one_mark():
    nudges = simulated.nudges()
    assert same(nudges, simulated.nudges())
    for case in nudges:
        assert len(case.marks) == len(case.before) == 15
        moved_s = case.marks.times_s - case.before.times_s
        (k,) = np.flatnonzero(moved_s)
        assert case.name == f"mark_{k + 1:02}"
        assert moved_s[k] == pytest.approx(0.005, rel=1e-12)  # rounding
    assert len({case.name for case in nudges}) == 3


def test_the_rhythm():
    d6, ball = rhythm.rhythm()
    assert (d6.body.name, ball.body.name) == ("d6", "ball") and d6.marks == ball.marks
    marks = d6.marks
    assert len(marks) == 200 and marks.ending == "open"
    gaps_s = np.diff(marks.times_s)
    # binary fractions: no rounding
    assert set(gaps_s) == {0.125, 0.25, 0.5}  # sixteenths, eighths, rests of a quarter at 120 bpm
    assert (gaps_s[1:] <= 2.0 * gaps_s[:-1]).all()
    assert len(set(marks.amplitudes)) >= 5 and marks.amplitudes.max() <= 1.0
    for case in (d6, ball):
        rising_m_s = G * 0.25  # half of the longest gap
        jump_j = 0.5 * case.body.mass_kg * rising_m_s**2
        assert case.energy_gain_j == pytest.approx(2.0 * jump_j, rel=1e-14)  # rounding


@pytest.fixture
def evaluation(tmp_path):
    """A folder like ../shared, its data made here: two tosses, a ball, a recording."""
    side_m = 0.1
    cube = ifa.Body.box((side_m,) * 3, mass_kg=0.4, restitution=0.2, friction=0.2)
    states = ifa.sample_states(cube, 2, seed=5)
    tosses = []
    for i in range(2):
        marks = ifa.Signature.from_run(ifa.simulate(cube, states[i]))
        amplitudes = marks.amplitudes.tolist()
        kinds_of = ["continuous" if d else "discrete" for d in marks.durations_s]
        rows = zip(marks.times_s, marks.durations_s, amplitudes, kinds_of, strict=True)
        tosses.append(
            {
                "toss": 10 * i,
                "terminal": i == 0,
                "hits": [{"t": t, "amp": a} for t, _, a, _ in rows],
                "events": [{"t": 0.25, "dur": 0.001, "kind": "discrete", "amp": 2.0},
                           {"t": 0.5, "dur": 0.125, "kind": "continuous", "amp": 1.0}],
            }
        )  # fmt: skip
    content = {
        "object": {"side_m": side_m, "mass_kg": 0.4, "inertia_kgm2": 0.4 / 6.0 * side_m**2,
                   "restitution": 0.2, "mu": 0.2},
        "tosses": tosses,
    }  # fmt: skip
    (tmp_path / "tosses").mkdir()
    (tmp_path / "tosses" / "cube_tosses.json").write_text(json.dumps(content), encoding="utf-8")
    throws = {"throws": [{"ball": "red_ball", "t": [0.0, 0.5, 0.9]}]}
    (tmp_path / "tosses" / "ball_bounces.json").write_text(json.dumps(throws), encoding="utf-8")
    sounds = tmp_path / "sounds"
    sounds.mkdir()
    sound = np.zeros(48_000)
    sound[[4_800, 24_000]] = 0.8, 0.4
    for name in ("die_d20_001", "qabcs_rubber_ball"):
        write_wav(sounds / f"{name}.wav", sound, 48_000)
        (sounds / f"{name}.hits.txt").write_text("0.1\t0.1\ta\n0.5\t0.5\tb\n", encoding="utf-8")
        (sounds / f"{name}.labels.txt").write_text("0.1\t0.6\tc\n", encoding="utf-8")
    return tmp_path


def test_recorded_cases(evaluation):
    die, ball = recorded.sounds(evaluation)
    assert (die.body.name, die.marks.ending, die.material) == ("d20", "rest", "fit")
    assert (ball.body.name, ball.marks.ending, ball.material) == ("ball", "open", "fit")
    # 1e-4: 16 bits in the file
    assert die.marks.amplitudes == pytest.approx([0.8, 0.4], abs=1e-4)
    die, _ = recorded.labels(evaluation)
    assert die.marks.times_s.tolist() == [0.1] and die.marks.durations_s.tolist() == [0.5]
    for toss, ending in zip(recorded.tosses(evaluation), ("rest", "open"), strict=True):
        assert (toss.marks.ending, toss.material, toss.events) == (ending, "given", "audible")
        assert toss.body.restitution == 0.2 and toss.body.vertices_m.shape == (8, 3)
    first, second = recorded.toss_events(evaluation)
    assert (first.name, second.name, first.events) == ("toss_000", "toss_010", "contact")
    assert first.marks == ifa.Signature([0.25, 0.5], [0.0, 0.125], [2.0, 1.0], ending="rest")
    (bounces,) = recorded.balls(evaluation)
    assert bounces.marks == ifa.Signature([0.0, 0.5, 0.9], ending="open")
    assert (bounces.name, bounces.body.name, bounces.material) == ("red_ball_00", "ball", "fit")


def test_the_evaluation_data_has_as_many_cases_as_the_bars_say(shared):
    for kind in kinds.KINDS.values():
        if kind.file:
            assert len(kind.make(shared, None)) == kind.bar.cases


def test_the_bars_ask_for_what_there_is():
    for name in ("rolls", "rhythm", "nudges"):
        kind = kinds.KINDS[name]
        assert len(kind.make(Path(), None)) == kind.bar.cases
        assert len(kind.make(Path(), 1)) == 1
    assert kinds.KINDS["simulated"].bar.cases == 50 * len(simulated.BODIES)
    for kind in kinds.KINDS.values():
        assert kind.bar.plausible <= kind.bar.succeeded <= kind.bar.cases


def test_what_is_missing_is_said(evaluation, tmp_path):
    for kind in kinds.KINDS.values():
        assert kind.argument or not kind.missing(evaluation)
        assert bool(kind.file) == ("no evaluation data" in kind.missing(tmp_path / "nowhere"))
    later = dataclasses.replace(kinds.KINDS["rhythm"], argument="sideways")
    assert "ifa.solve has no argument 'sideways' yet" in later.missing(evaluation)
    assert not dataclasses.replace(later, argument="seed").missing(evaluation)


# --- bars ----------------------------------------------------------------------------------------


def row(**changes):
    common = {"succeeded": True, "plausible": True, "verified": True, "solve_s": 1.0}
    return measure.Row("case", "forward", "d6", 5, **common | {"retime_percent": 1.0} | changes)


GOOD = [row(), row(retime_percent=3.0, solve_s=2.0), row(retime_percent=2.0, solve_s=6.0)]
BAR = bars.Bar(3, 3, 3, median_retime_percent=2.0, median_solve_s=2.0, longest_solve_s=6.0)


def missed(bar, rows):
    """What was missed, by the first words of its line."""
    cleared, text = bars.judged(bar, rows)
    lines = [line.removeprefix("    bar: ") for line in text.splitlines()]
    assert all(line.endswith((": cleared", ": MISSED")) for line in lines)
    failed = [line for line in lines if line.endswith(": MISSED")]
    assert cleared == (not failed)
    return [" ".join(line.split()[:2]) for line in failed]


def test_a_bar_is_cleared_at_its_edge():
    assert missed(BAR, GOOD) == []
    assert bars.judged(BAR, GOOD)[1].count("cleared") == 6
    only = bars.Bar(3, 3)  # nothing is said of what is not asked
    assert bars.judged(only, GOOD)[1].count("bar:") == 2


@pytest.mark.parametrize(
    ("rows", "what"),
    [
        (GOOD[:2], ["3 cases:", "3 of", "3 of"]),
        ([*GOOD[:2], row(succeeded=False, plausible=False)], ["3 of", "3 of"]),
        ([*GOOD[:2], row(plausible=False)], ["3 of"]),
        ([*GOOD[:2], row(verified=False)], ["3 of", "3 of"]),
        ([row(retime_percent=2.01), *GOOD[1:]], ["median of"]),
        ([row(solve_s=2.01), *GOOD[1:]], ["median solve"]),
        ([*GOOD[:2], row(solve_s=6.01)], ["longest solve"]),
        ([row(verified=False)] * 3, ["3 of", "3 of", "median of"]),  # the median of nothing
    ],
)
def test_a_bar_is_missed(rows, what):
    assert missed(BAR, rows) == what


# --- tables --------------------------------------------------------------------------------------


def test_the_table_fits_its_header():
    text = report.line(row(solve_s=12.5, restitution=0.5, rung=2, score=0.91234))
    assert len(text) == len(report.HEADER)
    heads = report.HEADER.replace("error ms", "error").replace("retime %", "retime").split()
    cells = dict(zip(heads, text.split(), strict=True))
    assert cells["succeeded"] == cells["verify"] == "yes"
    assert (cells["s"], cells["rung"], cells["e"], cells["score"]) == (
        "12.50",
        "2",
        "0.50",
        "0.912",
    )
    noted = report.line(row(verified=False, note="a word " * 100)).splitlines()
    assert " NO " in noted[0] and len(noted[1]) <= 4 + report.LONGEST_NOTE


def test_a_summary_counts_and_takes_medians():
    rows = [
        row(retime_percent=4.0, retimings_percent=(0.0, 1.0, 4.0), score=0.5, solve_s=0.5),
        row(retime_percent=2.0, retimings_percent=(2.0, 2.0), plausible=False, score=0.9),
        row(succeeded=False, plausible=False, verified=False, retime_percent=90.0, solve_s=9.0,
            retimings_percent=(90.0,)),
    ]  # fmt: skip
    text = report.summary("dice", rows)
    assert "dice: succeeded 2 of 3, plausible 1 of 3, verified 2; solve 1.00 s median" in text
    assert "9.00 s longest, 10.5 s in all" in text
    assert "retiming 3.00 % median of the worst mark, 2.00 % median of all marks" in text
    assert "score 0.700 median, 0.500 lowest" in text
    assert "those that succeeded" not in report.summary("dice", rows[2:])


# --- solving -------------------------------------------------------------------------------------


def options_of(**changes):
    namespace = {"seed": 0, "time_budget": 0.01, "threads": 1}
    return benchmark.argparse.Namespace(**namespace | changes)


def test_a_solve_becomes_a_row():
    ball = ifa.bodies.get("ball")
    marks = ifa.Signature([0.3, 0.7, 1.0], ending="open")
    got = measure.solve(cases.Case("a", ball, marks), "forward", options_of())
    solution = ifa.solve(ball, marks, rung=got.rung)
    assert (got.case, got.body, got.marks, got.method) == ("a", "ball", 3, "forward")
    assert (got.succeeded, got.plausible) == (solution.succeeded, solution.plausible)
    assert got.score == solution.score and got.restitution == ball.restitution
    retimings = [100.0 * event.retiming for event in solution.events]
    assert got.retimings_percent == tuple(retimings[1:])
    assert got.retime_percent == max(retimings)
    assert got.verified and got.note == ""


def test_what_the_solver_refuses_is_a_row_that_says_so():
    case = cases.Case("a", ifa.bodies.get("ball"), ifa.Signature([0.3]), events="smells")
    got = measure.solve(case, "forward", options_of())
    assert not got.succeeded and not got.verified and math.isnan(got.retime_percent)
    assert got.note.startswith("events: ") and got.solve_s >= 0.0


def test_a_solve_after_another_reuses_it(monkeypatch):
    original, calls = ifa.solve, []

    def solve(body, marks, *, reuse=None, **named):
        calls.append((marks, reuse, original(body, marks, **named)))
        return calls[-1][2]

    monkeypatch.setattr(ifa, "solve", solve)
    assert not kinds.KINDS["nudges"].missing(Path())
    before, after = (ifa.Signature([0.3, t], ending="open") for t in (0.7, 0.705))
    case = cases.Case("a", ifa.bodies.get("ball"), after, before=before)
    got = measure.solve(case, "forward", options_of())
    (first, of_nothing, previous), (second, reuse, last) = calls
    assert (first, second) == (before, after)
    assert of_nothing is None and reuse is previous
    assert got.solve_s == last.solve_s


def test_a_run_from_end_to_end(evaluation, tmp_path, capsys):
    arguments = ["--shared", str(evaluation), "--output", str(tmp_path / "out")]
    arguments += ["--only", "tosses", "--time-budget", "0.01"]
    assert benchmark.main([*arguments, "--limit", "1"]) == 0
    out = capsys.readouterr().out
    assert "seed 0" in out and "toss_010" in out and "toss_000" not in out
    assert "tosses, forward: succeeded" in out
    assert "bar:" not in out  # not of a part
    lines = (tmp_path / "out" / "tosses.csv").read_text(encoding="utf-8").splitlines()
    assert any(line.startswith("# processor: ") for line in lines)
    table = list(csv.DictReader(line for line in lines if not line.startswith("# ")))
    assert list(table[0]) == [field.name for field in dataclasses.fields(measure.Row)]
    assert [line["case"] for line in table] == ["toss_010"]
    retimings = table[0]["retimings_percent"].split()
    assert len(retimings) == int(table[0]["marks"]) - 1
    assert max(map(float, retimings)) == pytest.approx(float(table[0]["retime_percent"]), rel=1e-5)

    assert benchmark.main([*arguments, "--seed", "1"]) == 1
    assert "bar: 179 cases: 2: MISSED" in capsys.readouterr().out


def test_a_run_without_data_says_so(tmp_path, capsys):
    arguments = ["--shared", str(tmp_path), "--output", str(tmp_path), "--only", "balls"]
    assert benchmark.main(arguments) == 2
    assert "balls: skipped, there is no evaluation data at" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())
    with pytest.raises(SystemExit):
        benchmark.main(["--limit", "0"])
    with pytest.raises(SystemExit):
        benchmark.main(["--only", "symphonies"])
