"""method="graph": solved from a database, verified, refused; in Python and on the command line."""

from __future__ import annotations

import json
import math

import ifa
import pytest
from ifa import cli


@pytest.fixture(scope="module")
def die():
    return ifa.bodies.get("d6")


@pytest.fixture(scope="module")
def database(die, tmp_path_factory):
    return ifa.Database.build(die, tmp_path_factory.mktemp("graph") / "db", 1500).prepare()


@pytest.fixture(scope="module")
def marks(die):
    """Of throws of a die that bounces 10 % more, with 4 to 6 marks."""
    real = die.replace(restitution=1.1 * die.restitution)
    runs = (ifa.simulate(real, ifa.sample_states(real, 1, 31, i)[0]) for i in range(60))
    heard = (ifa.Signature.from_run(run) for run in runs)
    return [m for m in heard if 4 <= len(m) <= 6][:8]


def test_solutions_hold_before_the_verifier_and_the_bound(die, database, marks):
    succeeded = 0
    for m in marks:
        solution = ifa.solve(die, m, method="graph", database=database)
        assert solution.method == "graph"
        assert solution.search["kind"] == "exact"
        # float32 sums of log weights of some tens
        assert solution.search["score"] <= solution.search["bound"] + 1e-5
        if solution.succeeded:
            succeeded += 1
            certificate = ifa.verify(solution.motion, solution.body, m)
            assert certificate.passed, certificate.failures
    assert succeeded > len(marks) // 2


def test_a_simulation_of_the_database_is_found_again(die, database):
    # one of its simulations, of which nobody could hear an event otherwise (flag 4)
    flags, simulation = database.columns["flags"], database.columns["simulation"]
    clear = next(k for k in range(100) if not (flags[simulation == k] & 4).any())
    run = ifa.simulate(die, ifa.sample_states(die, 1, database.seed, clear)[0])
    solution = ifa.solve(die, ifa.Signature.from_run(run), method="graph", database=database)
    assert solution.plausible
    assert solution.score == pytest.approx(1.0, abs=1e-4)  # it keeps times as float32
    assert max(event.excess for event in solution.events) < 1e-9


def test_the_papers_search_runs_too(die, database, marks):
    solution = ifa.solve(
        die, marks[0], method="graph", database=database, search="branch_and_bound"
    )
    assert solution.search["kind"] == "branch_and_bound"


def test_the_same_bytes_again_and_from_the_folder(die, database, marks):
    first = ifa.solve(die, marks[0], method="graph", database=database)
    again = ifa.solve(die, marks[0], method="graph", database=database.path, threads=1)
    assert first.motion.positions_m.tobytes() == again.motion.positions_m.tobytes()
    assert first.motion.quaternions_wxyz.tobytes() == again.motion.quaternions_wxyz.tobytes()


@pytest.mark.parametrize("face", [(1, 0, 0), (0, 0, -1)])
def test_a_die_lands_on_any_face(die, database, marks, face):
    asked = ifa.Orientation(mark="rest", body_direction=face, direction=(0, 0, 1))
    free = [ifa.solve(die, m, method="graph", database=database) for m in marks]
    m, plain = next((m, s) for m, s in zip(marks, free, strict=True) if s.succeeded)
    solution = ifa.solve(die, m, method="graph", database=database, constraints=[asked])
    assert solution.succeeded
    # a cube looks the same from all sides, so another face costs nothing; it stands on it
    assert solution.constraints[0].error_deg < 0.1
    assert solution.score >= plain.score - 1e-6


def test_a_single_mark(die, database):
    solution = ifa.solve(die, ifa.Signature([0.3]), method="graph", database=database)
    assert solution.succeeded
    assert solution.score == 1.0


def test_a_sequence_that_nothing_meets_is_still_shown(die, database):
    # six bounces that grow: the database has none
    times = [0.2, 0.25, 0.35, 0.55, 0.95, 1.75]
    try:
        solution = ifa.solve(die, ifa.Signature(times), method="graph", database=database)
    except ifa.NoMotionError:
        return
    assert not solution.succeeded
    assert solution.missed_hits > 0 or solution.score < 0.3


def test_takes_differ(die, database, marks):
    for m in marks:
        takes = ifa.solve(die, m, method="graph", database=database, takes=3).takes
        for i, a in enumerate(takes):
            for b in takes[i + 1 :]:
                from_s, to_s = m.times_s[0], m.times_s[-1]
                assert a.motion.difference(b.motion, from_s, to_s) >= ifa.CLEARLY_DIFFERENT


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"method": "graph"}, "database: "),
        ({"method": "graph", "material": "fit"}, "material: "),
        ({"method": "graph", "events": "contact"}, "events: "),
        ({"method": "graph", "rung": 99}, "rung: "),
        ({"method": "graph", "search": "best"}, "search: "),
        ({"method": "forward"}, "database: "),
    ],
)
def test_what_does_not_go_together(die, database, marks, keywords, message):
    given = (
        {} if message == "database: " and keywords["method"] == "graph" else {"database": database}
    )
    with pytest.raises(ifa.IfaValueError, match=f"^{message}"):
        ifa.solve(die, marks[0], **given, **keywords)


def test_another_body_is_refused(database, marks):
    with pytest.raises(ifa.IfaValueError, match="restitution"):
        other = ifa.bodies.get("d6").replace(restitution=0.3)
        ifa.solve(other, marks[0], method="graph", database=database)
    with pytest.raises(ifa.IfaFileError):
        ifa.solve(other, marks[0], method="graph", database="/nowhere/at/all")


def test_on_the_command_line(database, marks, tmp_path, capsys):
    labels, out = tmp_path / "marks.json", tmp_path / "motion.json"
    marks[0].write(labels)
    words = ["solve", "d6", str(labels), "--method", "graph", "--database", str(database.path)]
    code = cli.main([*words, "-o", str(out), "--json"])
    printed = json.loads(capsys.readouterr().out)
    assert code == (0 if printed["succeeded"] else 3)
    assert printed["method"] == "graph"
    assert printed["search"]["kind"] == "exact"
    assert all(math.isfinite(printed["search"][name]) for name in ("score", "bound"))
    assert json.loads(out.read_text())["search"] == printed["search"]
