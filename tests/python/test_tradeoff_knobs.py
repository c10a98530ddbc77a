"""Knobs of the searches: each study on a small scene, its figures against the plain solve."""

from __future__ import annotations

import gc
import itertools

import ifa
import numpy as np
import pytest
from ifa import _core
from ifa.tradeoff import graph_knobs, search_knobs
from ifa.tradeoff.curve import Outcome, Scene

STUDIES = [
    search_knobs.beam,
    search_knobs.proposals,
    search_knobs.time_budget,
    graph_knobs.database_size,
    graph_knobs.neighbours,
    graph_knobs.search_exactness,
    graph_knobs.connection_tolerance,
]


@pytest.fixture(scope="module")
def scene():
    """A die, and the marks of a throw of it with four events."""
    die = ifa.bodies.get("d6")
    heard = (
        ifa.Signature.from_run(ifa.simulate(die, ifa.sample_states(die, 1, 5, i)[0]))
        for i in range(300)
    )
    return Scene(die, next(marks for marks in heard if len(marks) == 4), seed=1)


@pytest.fixture(scope="module")
def measured(scene):
    """All studies' first repeat: by knob, series and label."""
    out: dict[str, dict[tuple[str, str], Outcome]] = {}
    for make in STUDIES:
        study = make(scene, quick=True)
        out[study.knob] = {(s.series, s.label): s.run(0) for s in study.settings}
    return out


def setting(study, label, series=""):
    return next(s for s in study.settings if s.label == label and s.series == series)


def test_every_setting_has_a_time_and_an_error_or_a_named_failure(measured):
    assert {make.__name__ for make in STUDIES} == set(measured)
    for outcomes in measured.values():
        assert len(outcomes) > 2
        for outcome in outcomes.values():
            assert outcome.time_s > 0.0
            assert outcome.failure or 0.0 <= outcome.error < np.inf
        assert not all(outcome.failure for outcome in outcomes.values())
    # a throw of this very body: most works
    failed = [bool(o.failure) for outcomes in measured.values() for o in outcomes.values()]
    assert sum(failed) < len(failed) / 2


@pytest.mark.parametrize("make", STUDIES)
def test_the_full_study_goes_further_in_the_same_way(scene, make):
    quick, full = make(scene, quick=True), make(scene, quick=False)
    assert quick.knob == full.knob
    assert quick.error_name == full.error_name
    assert quick.note
    assert len(full.settings) > len(quick.settings)
    names = [(s.series, s.label) for s in full.settings]
    assert len(set(names)) == len(names)


def test_the_usual_proposals_are_those_of_the_plain_solve(scene, measured):
    plain = ifa.solve(scene.body, scene.marks, seed=scene.seed, rung=1)
    usual = {"roots": search_knobs.DEFAULT_ROOTS, "variants": search_knobs.DEFAULT_VARIANTS}
    same = ifa.solve(scene.body, scene.marks, seed=scene.seed, rung=1, expert=usual)
    assert same.motion.positions_m.tobytes() == plain.motion.positions_m.tobytes()
    assert same.motion.quaternions_wxyz.tobytes() == plain.motion.quaternions_wxyz.tobytes()
    for name in (
        ("root searches of a state", f"{search_knobs.DEFAULT_ROOTS} roots"),
        ("variants of a root", f"{search_knobs.DEFAULT_VARIANTS} variants"),
    ):
        assert measured["proposals"][name].error == 1.0 - plain.score
    other = ifa.solve(
        scene.body, scene.marks, seed=scene.seed, rung=1, expert={"roots": 1, "variants": 0}
    )
    assert other.simulated_s < plain.simulated_s


def test_a_beam_is_a_rung_of_the_ladder_and_repeats_are_seeds(scene):
    study = search_knobs.beam(scene, quick=True)
    for repeat in range(2):
        plain = ifa.solve(scene.body, scene.marks, seed=scene.seed + repeat, rung=0)
        outcome = setting(study, f"{_core.LADDER[0]} states").run(repeat)
        assert outcome.error == 1.0 - plain.score
        assert bool(outcome.failure) == (not plain.plausible)


def test_the_anytime_curve_never_gets_worse_and_takes_longer(scene, measured):
    outcomes = list(measured["time_budget"].values())
    for before, after in itertools.pairwise(outcomes):
        assert after.time_s > before.time_s
        assert before.failure or after.error <= before.error
    study = search_knobs.time_budget(scene, quick=True)
    # asked for alone, a point is what it is after the ones before it
    assert study.settings[-1].run(0).error == outcomes[-1].error


def test_the_history_of_a_solve_ends_with_it(scene):
    solution = ifa.solve(scene.body, scene.marks, seed=scene.seed, takes=2)
    last = solution.history[-1]
    assert (last.rung, last.score) == (solution.rung, solution.score)
    assert (last.succeeded, last.plausible) == (solution.succeeded, solution.plausible)
    assert 0.0 < last.time_s <= solution.solve_s
    assert all(not take.history for take in solution.others)
    assert "history" not in solution.to_dict()


@pytest.fixture(scope="module")
def database(scene, tmp_path_factory):
    return ifa.Database.build(scene.body, tmp_path_factory.mktemp("knobs") / "db", 1000, 1)


def test_all_neighbours_are_those_of_the_plain_solve(scene, database, measured):
    common = {"method": "graph", "database": database}
    plain = ifa.solve(scene.body, scene.marks, **common)
    same = ifa.solve(scene.body, scene.marks, **common, expert={"neighbours": 32})
    assert same.motion.positions_m.tobytes() == plain.motion.positions_m.tobytes()
    assert same.search == plain.search
    # the study builds the same database: 1000 simulations, the scene's seed
    assert measured["neighbours"]["exact search", "32 transitions"].error == 1.0 - plain.score
    assert plain.history[-1].score == plain.score
    first = ifa.solve(scene.body, scene.marks, **common, rung=0)
    states = ifa.solve(scene.body, scene.marks, **common, rung=0, expert={"states": 20_000})
    assert states.motion.positions_m.tobytes() == first.motion.positions_m.tobytes()


def test_the_gap_is_that_to_the_bound(scene, database, measured):
    outcomes = measured["search_exactness"]
    assert all(outcome.error >= 0.0 for outcome in outcomes.values())
    expert = {"states": 1_000_000}  # beyond any layer of this database: no path is left out
    common = {"method": "graph", "database": database}
    widest = ifa.solve(scene.body, scene.marks, **common, rung=3, expert=expert)
    usual = ifa.solve(scene.body, scene.marks, **common, rung=3, expert={"states": 20_000})
    gap = widest.search["bound"] - usual.search["score"]
    assert outcomes["exact search", "20000 states"].error == pytest.approx(gap, abs=1e-12)
    paper = ifa.solve(scene.body, scene.marks, **common, search="branch_and_bound")
    gap = widest.search["bound"] - paper.search["score"]
    assert outcomes["branch and bound", "branch and bound"].error == pytest.approx(gap, abs=1e-12)
    for states in (50, 1000):
        solution = ifa.solve(
            scene.body,
            scene.marks,
            method="graph",
            database=database,
            rung=3,
            expert={"states": states},
        )
        # float32 sums of log weights of some tens
        assert solution.search["score"] <= solution.search["bound"] + 1e-5


def test_more_simulations_make_a_better_motion(measured):
    outcomes = measured["database_size"]
    alone = [o for (series, _), o in outcomes.items() if series == "solve alone"]
    built = [o for (series, _), o in outcomes.items() if series == "build and solve"]
    good = [o.error for o in alone if not o.failure]
    assert good[-1] == min(good)
    for a, b in zip(alone, built, strict=True):
        assert (a.error, a.failure) == (b.error, b.failure)


@pytest.mark.parametrize("name", ["d6", "card"])
def test_connections_miss_by_less_than_their_tolerance(name):
    connections = _core.Connections(ifa.bodies.get(name)._core, seed=1, simulations=50, count=50)
    for tolerance_rad in (1e-1, 1e-4, _core.SHOOTING_TOLERANCE_RAD):
        ours = graph_knobs.connect(connections, tolerance_rad, False)
        # 1e-10 rad: the rounding of the flights
        assert ours.error <= np.degrees(tolerance_rad + 1e-10)
    papers = graph_knobs.connect(connections, 1e-2, True)
    assert papers.error <= np.degrees(1e-2 + 1e-10)
    hopeless = graph_knobs.connect(connections, 1e-12, True)
    assert "did not converge" in (hopeless.failure or hopeless.losses[0])


def test_a_body_that_does_not_suit_the_graph_fails_by_name(scene, monkeypatch):
    # a dead ball never leaves the ground again: no transitions, no connections
    ball = ifa.bodies.get("ball").replace(restitution=0.0)
    odd = Scene(ball, scene.marks)
    monkeypatch.setattr(graph_knobs, "_QUICK_FIXED_SIZE", 20)
    monkeypatch.setattr(graph_knobs, "_QUICK_SIZES", (10,))
    for make in STUDIES[3:]:
        study = make(odd, quick=True)
        for one in (study.settings[0], study.settings[-1]):
            assert one.run(0).failure


@pytest.mark.parametrize(
    ("method", "expert", "message"),
    [
        ("forward", {"states": 3}, "expert: .*'states'"),
        ("forward", {"roots": 0}, "expert: roots"),
        ("forward", {"variants": 1.5}, "expert: variants"),
        ("graph", {"roots": 3}, "expert: .*'roots'"),
        ("graph", {"children": 0}, "expert: children"),
    ],
)
def test_senseless_sizes_are_refused(scene, method, expert, message):
    with pytest.raises(ifa.IfaValueError, match=message):
        ifa.solve(scene.body, scene.marks, method=method, expert=expert)


def test_the_databases_are_gone_with_the_study(scene, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    study = graph_knobs.database_size(scene, quick=True)
    study.settings[0].run(0)
    assert list(tmp_path.iterdir())
    del study
    gc.collect()
    assert not list(tmp_path.iterdir())
