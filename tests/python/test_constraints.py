"""Constraints on poses: how they are given, kept in files, refused, met and reported."""

from __future__ import annotations

import copy
import json
import pickle
from itertools import permutations
from pathlib import Path
from typing import Any

import ifa
import numpy as np
import pytest
from ifa import Orientation, Position, Signature
from ifa.cli import main

TIMES_S = [0.1, 0.22, 0.3]
ASKED = [
    Position(0, (0.0, 0.0)),
    Position(2, (0.1, -0.05)),
    Orientation(2, (0, 0, 1), (1, 0, 0)),
    Orientation(2, (0, 1, 0)),
    Orientation("rest", (0, 0, -2.5)),
]


def asked_signature() -> Signature:
    return Signature(TIMES_S, amplitudes=[1, 2, 3], constraints=ASKED)


class TestGiving:
    def test_fields_are_plain_and_frozen(self) -> None:
        one = Orientation(np.int64(3), np.array([0, 0, 2]))
        assert one == Orientation(mark=3, body_direction=(0.0, 0.0, 2.0), direction=(0.0, 0.0, 1.0))
        assert isinstance(one.mark, int) and isinstance(one.body_direction, tuple)
        with pytest.raises(AttributeError):
            one.mark = 4  # type: ignore[misc]
        assert Position(0, [1, 2]).position_m == (1.0, 2.0)
        assert len({one, Position(0, [1, 2]), Position(0, (1.0, 2.0))}) == 2

    @pytest.mark.parametrize(
        ("make", "message"),
        [
            (lambda: Position(-1, (0, 0)), "mark: must be a whole number"),
            (lambda: Position(1.5, (0, 0)), "mark: must be a whole number"),
            (lambda: Position(True, (0, 0)), "mark: must be a whole number"),
            (lambda: Position("rest", (0, 0)), "mark: must be a whole number"),
            (lambda: Position(0, (0, 0, 0)), r"position_m: needs shape \(2,\)"),
            (lambda: Position(0, (0, np.inf)), "position_m: must be finite"),
            (lambda: Position(0, "ab"), "position_m: must be an array of numbers"),
            (lambda: Orientation("end", (0, 0, 1)), 'mark: must be a whole number or "rest"'),
            (lambda: Orientation(None, (0, 0, 1)), "mark: must be a whole number"),
            (lambda: Orientation(0, (0, 0, 0)), "body_direction: is 0 and points nowhere"),
            (lambda: Orientation(0, (0, 0, 1), (0, 0)), r"direction: needs shape \(3,\)"),
            (lambda: Orientation(0, (0, 0, 1), (0, 0, np.nan)), "direction: must be finite"),
        ],
    )
    def test_bad_fields_are_named(self, make: Any, message: str) -> None:
        with pytest.raises(ifa.IfaValueError, match=f"^{message}"):
            make()

    def test_any_order_is_the_same_signature(self) -> None:
        marks = asked_signature()
        assert marks.constraints == tuple(ASKED)
        for order in permutations(range(len(ASKED))):
            if order.index(2) > order.index(3):
                continue  # of one mark orientations keep their order
            other = Signature(TIMES_S, amplitudes=[1, 2, 3], constraints=[ASKED[i] for i in order])
            assert other == marks and hash(other) == hash(marks)
        assert Signature(TIMES_S, amplitudes=[1, 2, 3]) != marks
        assert "5 constraints" in repr(marks)

    def test_refused_by_the_marks(self) -> None:
        with pytest.raises(ifa.IfaValueError, match=r"^constraints: there is no mark 4, only 3"):
            Signature(TIMES_S, constraints=[Position(3, (0, 0))])
        with pytest.raises(ifa.IfaValueError, match=r"^mark 2 \(0.22 s\): has two positions"):
            Signature(TIMES_S, constraints=[Position(1, (0, 0)), Position(1, (0, 1))])
        with pytest.raises(ifa.IfaValueError, match=r'^constraints: .* "rest"'):
            Signature(TIMES_S, ending="open", constraints=[Orientation("rest", (0, 0, 1))])
        with pytest.raises(ifa.IfaValueError, match=r"^constraints: must hold"):
            Signature(TIMES_S, constraints=[(0, 0)])  # type: ignore[list-item]

    def test_refused_by_solve(self) -> None:
        die = ifa.bodies.get("d6")
        marks = Signature(TIMES_S, constraints=[Position(0, (0, 0))])
        for constraints in ([Position(0, (1, 1))], [Position(9, (1, 1))], [3], "up", {}):
            with pytest.raises(ifa.IfaValueError, match=r"^(constraints:|mark 1 )"):
                ifa.solve(die, marks, constraints=constraints, rung=0)


class TestFiles:
    def test_json_as_documented(self, tmp_path: Path) -> None:
        path = tmp_path / "marks.json"
        path.write_text(
            """{"events": [
              {"time_s": 0.1, "position_m": [0.5, -1]},
              {"time_s": 0.2, "orientation": {"body_direction": [1, 0, 0]}},
              {"time_s": 0.3, "position_m": null, "orientation": [
                {"body_direction": [1, 0, 0], "direction": [0, 1, 0]},
                {"body_direction": [0, 0, 1], "direction": [0, 0, -1]}]}],
            "rest_orientation": {"body_direction": [0, 0, 1], "direction": [0, 0, 1]}}"""
        )
        assert Signature.read(path).constraints == (
            Position(0, (0.5, -1)),
            Orientation(1, (1, 0, 0), (0, 0, 1)),
            Orientation(2, (1, 0, 0), (0, 1, 0)),
            Orientation(2, (0, 0, 1), (0, 0, -1)),
            Orientation("rest", (0, 0, 1), (0, 0, 1)),
        )

    def test_round_trips(self, tmp_path: Path) -> None:
        marks = asked_signature()
        marks.write(tmp_path / "marks.json")
        for again in (
            Signature.read(tmp_path / "marks.json"),
            Signature.from_dict(json.loads(json.dumps(marks.to_dict(), allow_nan=False))),
            pickle.loads(pickle.dumps(marks)),
            copy.deepcopy(marks),
        ):
            assert again == marks and again.constraints == marks.constraints

    def test_marks_without_constraints_are_written_as_before(self) -> None:
        plain = Signature(TIMES_S).to_dict()
        assert set(plain) == {"events", "ending"}
        assert set(plain["events"][0]) == {"time_s", "duration_s", "amplitude", "centroid_s"}

    @pytest.mark.parametrize(
        ("event", "message"),
        [
            ({"position_m": [1]}, "mark 1: position_m: needs shape"),
            ({"position_m": "here"}, "mark 1: position_m: must be an array"),
            ({"orientation": [0, 0, 1]}, "mark 1: orientation: must be an object"),
            ({"orientation": {"direction": [0, 0, 1]}}, "mark 1: orientation: must be an object"),
            (
                {"orientation": {"body_direction": [0, 0, 1], "angle": 3}},
                "mark 1: orientation: must be an object",
            ),
            (
                {"orientation": {"body_direction": [0, 0, 0]}},
                "mark 1: body_direction: is 0 and points nowhere",
            ),
        ],
    )
    def test_bad_fields_name_the_mark(self, event: dict[str, Any], message: str) -> None:
        with pytest.raises(ifa.IfaValueError, match=f"^{message}"):
            Signature.from_dict({"events": [{"time_s": 0.1, **event}]})

    def test_a_bad_rest_is_named(self) -> None:
        with pytest.raises(ifa.IfaValueError, match=r"^rest: rest_orientation: must be an object"):
            Signature.from_dict({"events": [{"time_s": 0.1}], "rest_orientation": "up"})


@pytest.fixture(scope="module")
def solved() -> ifa.Solution:
    die = ifa.bodies.get("d6")
    marks = Signature([0.2, 0.35, 0.45, 0.5], constraints=[Position(0, (1.0, 2.0))])
    constraints = [
        Orientation("rest", (0, 0, 1)),
        Position(2, (1.0, 2.1)),
        Orientation(1, (0, 1, 0), (1, 1, 0)),
    ]
    return ifa.solve(die, marks, constraints=constraints, rung=0)


class TestSolving:
    def test_reports_are_what_the_motion_shows(self, solved: ifa.Solution) -> None:
        assert [report.constraint for report in solved.constraints] == list(
            solved.marks.constraints
        )
        assert [report.constraint.mark for report in solved.constraints] == [0, 1, 2, "rest"]
        for report in solved.constraints:
            asked = report.constraint
            time_s = (
                solved.motion.end_s if asked.mark == "rest" else solved.marks.times_s[asked.mark]
            )
            (position,), (q,) = solved.motion.sample([time_s])
            if isinstance(asked, Position):
                error = np.hypot(*(position[:2] - asked.position_m))
                assert report.error_m == pytest.approx(error, abs=1e-12)
                assert report.error_deg is None
                assert report.factor == pytest.approx(np.exp(-7000 * error**2), rel=1e-9)
                assert report.met == (error <= np.sqrt(np.log(2) / 7000))
            else:
                n = np.array(asked.body_direction)
                now = n + 2 * np.cross(q[1:], np.cross(q[1:], n) + q[0] * n)
                cosine = now @ asked.direction / np.linalg.norm(now)
                cosine /= np.linalg.norm(asked.direction)
                angle = np.arccos(np.clip(cosine, -1, 1))
                # the arc cosine is good to 1e-8 near 0
                assert report.error_deg == pytest.approx(np.degrees(angle), abs=1e-5)
                assert report.error_m is None
                assert report.factor == pytest.approx(np.exp(-140 * angle**2), rel=1e-5)
        assert solved.constraints_met == all(report.met for report in solved.constraints)

    def test_the_score_knows_nothing_of_them(self, solved: ifa.Solution) -> None:
        factors = [f for event in solved.events for f in event.factors.values()]
        expected = np.exp(np.log(np.maximum(factors, 1e-300)).sum() / len(factors))
        assert solved.score == pytest.approx(expected, rel=1e-12)

    def test_json_has_them(self, solved: ifa.Solution, tmp_path: Path) -> None:
        solved.write(tmp_path / "out.json")
        out = json.loads((tmp_path / "out.json").read_text())
        assert out["constraints_met"] == solved.constraints_met
        assert [c["mark"] for c in out["constraints"]] == [0, 1, 2, "rest"]
        assert set(out["constraints"][0]) == {"mark", "position_m", "error_m", "factor", "met"}
        assert set(out["constraints"][1]) == {
            "mark", "body_direction", "direction", "error_deg", "factor", "met",
        }  # fmt: skip
        assert Signature.from_dict(out["marks"]) == solved.marks
        assert ifa.verify(tmp_path / "out.json", solved.body, solved.marks).passed == (
            solved.succeeded
        )

    def test_without_them_nothing_is_said(self) -> None:
        solution = ifa.solve(ifa.bodies.get("ball"), Signature([0.2, 0.5], ending="open"), rung=0)
        assert solution.constraints == () and solution.constraints_met
        assert not {"constraints", "constraints_met"} & set(solution.to_dict())

    def test_repairs_keep_what_still_applies(self) -> None:
        body = ifa.Body.ball(0.02, mass_kg=0.01, restitution=0.5)
        marks = Signature(
            [0.2, 0.4, 0.43, 0.5],
            ending="open",
            constraints=[Position(1, (0, 0)), Position(3, (0.05, 0))],
        )
        for repair in ifa.explain(body, marks, time_budget_s=30.0).repairs:
            positions = {c.position_m: c.mark for c in repair.marks.constraints}
            if repair.kind == "drop":
                gone = repair.mark
                expected = {
                    c.position_m: c.mark - (c.mark > gone)
                    for c in marks.constraints
                    if c.mark != gone
                }
                assert positions == expected
            else:
                assert repair.marks.constraints == marks.constraints

    def test_on_the_command_line(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        marks = Signature([0.2, 0.5], ending="open", constraints=[Position(1, (3.0, 4.0))])
        marks.write(tmp_path / "marks.json")
        main(["solve", "ball", str(tmp_path / "marks.json")])
        assert "mark 2: 0.0 mm off its position" in capsys.readouterr().out


def test_measured_tosses_are_followed(shared: Path) -> None:
    """Table 2 of the paper: 3 to 18 % of the longest edge on average, 4 to 28 % at most.

    Of thirty tosses spread over the data the largest were 4 and 7 % with the default budget; one
    rung of the search, as here, is not quite as good.
    """
    data = json.loads((shared / "tosses" / "cube_tosses.json").read_text(encoding="utf-8"))
    half = 0.5 * data["object"]["side_m"]
    corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    cube = ifa.Body.from_vertices(
        corners,
        mass_kg=data["object"]["mass_kg"],
        inertia_kg_m2=data["object"]["inertia_kgm2"],
        restitution=data["object"]["restitution"],
        friction=data["object"]["mu"],
    )
    tosses = [t for t in data["tosses"] if t["duplicate_of"] is None and len(t["hits"]) >= 3]
    means, largest = [], []
    for toss in tosses[:: len(tosses) // 3][:3]:
        hits = toss["hits"]
        marks = Signature(
            [hit["t"] for hit in hits],
            amplitudes=[hit["amp"] for hit in hits],
            ending="rest" if toss["terminal"] else "open",
            constraints=[Position(k, (hit["x"], hit["y"])) for k, hit in enumerate(hits)],
        )
        errors_m = [c.error_m for c in ifa.solve(cube, marks, rung=2).constraints]
        edge_m = max(np.ptp([(hit["x"], hit["y"]) for hit in hits], axis=0))
        means.append(np.mean(errors_m) / edge_m)
        largest.append(np.max(errors_m) / edge_m)
    assert max(means) < 0.09 and max(largest) < 0.14  # half of the paper's largest
