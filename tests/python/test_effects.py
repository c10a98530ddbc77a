"""Effects: which are on for what, forced ones, what they cost, and how it is all shown."""

from __future__ import annotations

import copy
import json
import pickle
import subprocess
import sys
import zipfile
from pathlib import Path

import ifa
import numpy as np
import pytest
from ifa import cli, effect_costs
from ifa.effect_costs import Cost, CostTable

from benchmarks.effects.measure import Row
from benchmarks.effects.record import cost_table

OPEN = ifa.Signature([0.3, 0.42, 0.5, 0.56], ending="open")
REST = ifa.Signature([0.3, 0.42, 0.5, 0.56])
COST = Cost(ratio=1.25, spread=0.125, scene="a die, six marks")
TABLE = CostTable("2 cores", "2026-11-30", {"ifa": "0.1.0"}, {"friction": COST})


def brick(**changes):
    """A body without symmetry of its moments, with sharp corners."""
    given = {"mass_kg": 0.02, "restitution": 0.5, "friction": 0.3} | changes
    return ifa.Body.box((0.02, 0.03, 0.05), **given)


@pytest.fixture
def with_costs(monkeypatch):
    """As if this had been measured."""
    monkeypatch.setattr(ifa.effects, "recorded", lambda: TABLE)


class TestPlan:
    def test_holds_every_effect_in_order(self):
        plan = ifa.plan(brick(), OPEN)
        assert tuple(plan) == ifa.EFFECTS and len(plan) == len(set(ifa.EFFECTS)) == 14
        assert sorted(plan.on + plan.off) == sorted(ifa.EFFECTS)
        for name, state in plan.items():
            assert state.name == name and bool(state) is state.on is (name in plan.on)
            assert state.because and not state.forced and state.runs is None
        assert plan.plan_s > 0.0 and plan.forced == {}
        with pytest.raises(KeyError):
            plan["gyroscope"]

    @pytest.mark.parametrize(
        ("body", "on"),
        [
            (ifa.Body.ball(0.02, mass_kg=0.03), False),
            # the moments of a cube are equal, those of a brick and of a coin are not
            (ifa.Body.box((0.02, 0.02, 0.02), mass_kg=0.02), False),
            (ifa.bodies.get("d6"), False),
            (brick(), True),
            (ifa.bodies.get("coin"), True),
        ],
        ids=["ball", "cube", "d6", "brick", "coin"],
    )
    def test_spin_couples_where_moments_differ(self, body, on):
        assert ifa.plan(body, OPEN)["spin_coupling"].on is on
        moments = np.linalg.eigvalsh(body.inertia_kg_m2)
        assert (moments[2] - moments[0] > 1e-12 * moments[2]) == on  # rounding of the integrals

    def test_shape_of_the_body(self):
        for name in ("ball", "d6", "coin", "card", "eraser"):
            body = ifa.bodies.get(name)
            plan = ifa.plan(body, OPEN)
            assert plan["circular_edges"].on is (body.rings_m is not None and len(body.rings_m) > 0)
            assert plan["rounding"].on is (body.radius_m > 0.0)
        assert not ifa.plan(brick(), OPEN)["rounding"]

    def test_friction_of_the_material(self):
        none = {"friction": 0.0, "rolling_friction_m": 0.0, "spin_friction_m": 0.0}
        assert not ifa.plan(brick(**none), OPEN)["friction"]
        for name in none:
            assert ifa.plan(brick(**(none | {name: 1e-4})), OPEN)["friction"], name

    def test_what_the_marks_have(self):
        times_s, durations_s = [0.3, 0.5, 0.6], [0.0, 0.05, 0.0]
        changes = {
            "amplitude_matching": ifa.Signature(times_s, amplitudes=[1, 0.5, 0.2], ending="open"),
            "length_matching": ifa.Signature(times_s, durations_s, ending="open"),
            "settling_to_rest": ifa.Signature(times_s),
        }
        bare = ifa.plan(brick(), ifa.Signature(times_s, ending="open"))
        for name, marks in changes.items():
            assert not bare[name] and ifa.plan(brick(), marks)[name], name
            others = set(changes) - {name}
            assert not any(ifa.plan(brick(), marks)[other] for other in others)
        centred = ifa.Signature(times_s, durations_s, centroids_s=[0, 0.01, 0], ending="open")
        assert ifa.plan(brick(), centred)["centroid_matching"]
        assert not bare["centroid_matching"]

    def test_contact_after_impacts(self):
        ball = ifa.bodies.get("ball")
        spans = ifa.Signature([0.3, 0.5], [0.1, 0.0], ending="open")
        # A ball stays on the ground from where it no longer bounces: after the last hit.
        assert not ifa.plan(ball, OPEN)["sustained_contact"]
        assert not ifa.plan(brick(), ifa.Signature([0.3], ending="open"))["sustained_contact"]
        for body, marks in [(ball, REST), (ball, spans), (brick(), OPEN), (brick(), REST)]:
            assert ifa.plan(body, marks)["sustained_contact"]
        assert ifa.plan(ball, OPEN, events="contact")["sustained_contact"]
        with pytest.raises(ifa.IfaValueError, match="sustained_contact: cannot be off where"):
            ifa.plan(ball, REST, effects={"sustained_contact": False})

    def test_the_graph_has_the_physics_of_its_database(self):
        for name in ("spin_coupling", "friction", "sustained_contact"):
            with pytest.raises(ifa.IfaValueError, match=rf"{name}: .*graph"):
                ifa.plan(brick(), REST, method="graph", effects={name: False})
        assert ifa.plan(brick(), REST, method="graph", effects={"friction": True})["friction"].on

    def test_constraints_given_and_of_the_marks(self):
        asked = {
            "orientation_constraints": ifa.Orientation(0, (0, 0, 1)),
            "position_constraints": ifa.Position(1, (0.1, 0.0)),
        }
        assert not any(ifa.plan(brick(), OPEN)[name] for name in asked)
        for name, constraint in asked.items():
            given = ifa.plan(brick(), OPEN, constraints=[constraint])
            assert [other for other in asked if given[other]] == [name]
            assert given == ifa.plan(brick(), OPEN.with_constraints([constraint]))

    def test_material_fit(self):
        assert ifa.plan(brick(), OPEN, material="fit")["material_fit"]
        assert not ifa.plan(brick(), OPEN)["material_fit"]

    @pytest.mark.parametrize("name", ifa.EFFECTS)
    @pytest.mark.parametrize("on", [True, False])
    def test_each_can_be_forced(self, name, on):
        plan = ifa.plan(brick(), OPEN, effects={name: on})
        assert plan[name].on is on and plan[name].forced and plan.forced == {name: on}
        free = ifa.plan(brick(), OPEN)
        assert plan[name].because == free[name].because  # what the scene says does not change
        assert {*plan.on} ^ {*free.on} == ({name} if free[name].on is not on else set())

    def test_says_what_is_wrong(self):
        with pytest.raises(ifa.IfaValueError, match=r"effects: there is no 'gyro'; there are spin"):
            ifa.plan(brick(), OPEN, effects={"gyro": True})
        with pytest.raises(ifa.IfaValueError, match="effects: friction must be True or False"):
            ifa.plan(brick(), OPEN, effects={"friction": "off"})
        with pytest.raises(ifa.IfaValueError, match="effects: must map"):
            ifa.plan(brick(), OPEN, effects=["friction"])
        for changes, field in [
            ({"events": "loud"}, "events"),
            ({"material": "wood"}, "material"),
            ({"method": "magic"}, "method"),
            ({"lead_in_s": -1.0}, "lead_in_s"),
            ({"constraints": [1]}, "constraints"),
        ]:
            with pytest.raises(ifa.IfaValueError, match=f"^{field}: "):
                ifa.plan(brick(), OPEN, **changes)
        with pytest.raises(ifa.IfaValueError, match=r"^body: "):
            ifa.plan("d6", OPEN)
        with pytest.raises(ifa.IfaValueError, match=r"^marks: "):
            ifa.plan(brick(), [0.1])


class TestShown:
    def test_table_has_a_line_for_each(self, with_costs):
        lines = str(ifa.plan(brick(), OPEN, effects={"retiming": False})).splitlines()
        assert lines[0].split() == ["effect", "cost", "because"]
        assert [line.split("  ")[0] for line in lines[1:15]] == [
            name.replace("pre_roll", "pre-roll").replace("_", " ") for name in ifa.EFFECTS
        ]
        friction, retiming = lines[2], lines[13]
        assert " on " in friction and "1.25 +- 0.12" in friction
        assert " forced off " in retiming and "not measured" in retiming
        assert lines[15:] == [
            "cost: time with over time without, median +- quartile spread, on a scene that needs "
            "it (2 cores, ifa 0.1.0, 2026-11-30)"
        ]

    def test_line_has_each_once(self):
        plan = ifa.plan(brick(), OPEN, effects={"friction": False, "rounding": True})
        line = plan.line()
        on, off = line.removeprefix("on: ").split("; off: ")
        assert "rounding (forced)" in on.split(", ") and "sustained contact" in on.split(", ")
        assert "friction (forced)" in off.split(", ")
        assert f"settling to rest ({plan['settling_to_rest'].because})" in off
        assert all(state.title in line for state in plan.values())
        assert "\n" not in line

    def test_json_round_trip(self, with_costs):
        plan = ifa.plan(brick(), OPEN, effects={"friction": False})
        content = json.loads(json.dumps(plan.to_dict(), allow_nan=False))
        assert list(content) == list(ifa.EFFECTS)
        assert content["friction"] == {
            "on": False,
            "forced": True,
            "because": plan["friction"].because,
            "cost": {"ratio": 1.25, "spread": 0.125, "scene": "a die, six marks"},
        }
        assert content["retiming"]["cost"] is None

    def test_is_a_plain_value(self):
        plan = ifa.plan(brick(), OPEN)
        assert copy.deepcopy(plan) == pickle.loads(pickle.dumps(plan)) == plan
        assert plan != ifa.plan(brick(), REST)


TIMES_S = [0.3, 0.55, 0.7]
SPAN = ifa.Signature(TIMES_S, [0, 0, 0.15], centroids_s=[np.nan, np.nan, 0.05])
PLACED = ifa.Signature(TIMES_S, ending="open", constraints=[ifa.Position(1, (0.04, 0.0))])
POSED = ifa.Signature(TIMES_S, ending="open", constraints=[ifa.Orientation(2, (0, 0, 1))])
NEEDED_BY = {  # scenes that call for an effect: a body of the library, and marks
    "spin_coupling": ("eraser", OPEN),
    "friction": ("d6", OPEN),
    "sustained_contact": ("d6", OPEN),
    "rounding": ("d6", OPEN),
    "circular_edges": ("coin", OPEN),
    "pre_roll_flight": ("d6", OPEN),
    "settling_to_rest": ("d6", REST),
    "amplitude_matching": ("d6", ifa.Signature(TIMES_S, amplitudes=[1, 0.6, 0.4], ending="open")),
    "length_matching": ("d6", SPAN),
    "centroid_matching": ("d6", SPAN),
    "orientation_constraints": ("d6", POSED),
    "position_constraints": ("d6", PLACED),
    "retiming": ("d6", OPEN),
    "material_fit": ("d6", OPEN),
}

NOTHING_TO_RUN = (
    "rounding",
    "circular_edges",
    "length_matching",
    "orientation_constraints",
    "position_constraints",
)


class TestSolve:
    @pytest.mark.parametrize("name", ifa.EFFECTS)
    def test_each_runs_where_it_is_needed_and_not_where_it_is_off(self, name):
        body, marks = NEEDED_BY[name]
        options = {"rung": 0, "material": "fit" if name == "material_fit" else "given"}
        needed = ifa.solve(ifa.bodies.get(body), marks, **options).effects[name]
        assert needed.on and not needed.forced and needed.runs > 0
        forced = {"effects": {name: False}} | options
        off = ifa.solve(ifa.bodies.get(body), marks, **forced).effects
        assert not off[name].on and off[name].forced and off[name].runs == 0
        assert all(state.runs == 0 for state in off.values() if not state.on)

    # Without a rounding, edges, a span or constraints there is nothing of these to run.
    @pytest.mark.parametrize("name", [e for e in ifa.EFFECTS if e not in NOTHING_TO_RUN])
    def test_each_can_be_made_to_run(self, name):
        # A cube without friction: no moments that differ, no sound, no poses, an open ending.
        none = {"friction": 0.0, "rolling_friction_m": 0.0, "spin_friction_m": 0.0}
        body = ifa.Body.box((0.02, 0.02, 0.02), mass_kg=0.02, restitution=0.6, **none)
        marks = ifa.Signature(TIMES_S, ending="open")
        state = ifa.solve(body, marks, rung=0, effects={name: True}).effects[name]
        assert state.on and state.forced and state.runs > 0

    def test_poses_at_rest_are_not_asked_of_what_does_not_settle(self):
        up = ifa.Orientation("rest", (0.0, 0.0, 1.0))
        marks = ifa.Signature(TIMES_S, ending="rest", constraints=[up])
        solution = ifa.solve(brick(), marks, rung=0, effects={"settling_to_rest": False})
        assert solution.constraints == () and solution.constraints_met

    @pytest.mark.parametrize("body", ["d4", "card"])
    def test_a_rung_of_a_single_mark_is_the_same_alone_and_in_a_climb(self, body):
        """It stops at its first perfect start, so what earlier rungs found must not matter."""
        marks = ifa.Signature([0.4], ending="rest")
        climbed = ifa.solve(ifa.bodies.get(body), marks, accuracy="best", time_budget_s=30.0)
        alone = ifa.solve(ifa.bodies.get(body), marks, accuracy="best", rung=climbed.rung)
        np.testing.assert_array_equal(climbed.motion.positions_m, alone.motion.positions_m)
        assert climbed.score == alone.score == 1.0

    def test_says_what_ran(self):
        solution = ifa.solve(brick(), REST, rung=0, takes=2)
        planned = ifa.plan(brick(), REST)
        for take in solution.takes:
            assert (take.effects.on, take.effects.off) == (planned.on, planned.off)
            assert {s.name for s in take.effects.values() if s.runs == 0} == set(planned.off)
            assert [s.because for s in take.effects.values()] == [
                s.because for s in planned.values()
            ]

    def test_out_holds_it(self, tmp_path):
        solution = ifa.solve(brick(), OPEN, rung=0, effects={"rounding": False})
        solution.write(tmp_path / "out.json")
        written = json.loads((tmp_path / "out.json").read_text())["effects"]
        assert written == solution.effects.to_dict()
        assert written["rounding"]["forced"] is True and written["rounding"]["runs"] == 0
        assert all(state["runs"] > 0 for state in written.values() if state["on"])

    def test_unknown_effects_are_refused_before_the_search(self):
        with pytest.raises(ifa.IfaValueError, match="effects: there is no 'gyro'"):
            ifa.solve(brick(), OPEN, effects={"gyro": True})

    def test_repairs_are_not_for_forced_effects(self):
        solution = ifa.solve(brick(), OPEN, rung=0, effects={"retiming": False})
        with pytest.raises(ifa.IfaValueError, match="solution: was made with effects forced"):
            ifa.explain(brick(), OPEN, solution=solution)


class TestCommandLine:
    @pytest.fixture
    def folder(self, tmp_path, monkeypatch):
        (tmp_path / "marks.txt").write_text("".join(f"{t}\t{t}\t\n" for t in OPEN.times_s))
        monkeypatch.chdir(tmp_path)
        return tmp_path

    def solve(self, *more):
        return cli.main(["solve", "coin", "marks.txt", "--ending", "open", "--rung", "0", *more])

    def test_explain_shows_the_plan_before_and_what_ran_after(self, folder, capsys):
        assert self.solve("--explain") == 0
        out, err = capsys.readouterr()
        assert err.startswith("ifa: on: spin coupling, friction, ")
        (head,) = [line for line in out.splitlines() if line.startswith("effect ")]
        assert head.split() == ["effect", "runs", "cost", "because"]
        table = out.splitlines()[out.splitlines().index(head) + 1 :]
        assert table[0].startswith("spin coupling") and " on " in table[0]

    def test_without_it_nothing_is_said(self, folder, capsys):
        assert self.solve() == 0
        out, err = capsys.readouterr()
        assert "spin coupling" not in out + err

    def test_effects_are_forced(self, folder, capsys):
        forced = ["--effect", "friction=off", "--effect", "rounding=on"]
        self.solve(*forced, "--json")
        effects = json.loads(capsys.readouterr().out)["effects"]
        assert {n: e["on"] for n, e in effects.items() if e["forced"]} == {
            "friction": False,
            "rounding": True,
        }

    @pytest.mark.parametrize(
        ("words", "message"),
        [
            ("gyro=on", "argument --effect: 'gyro' is no effect; there are spin_coupling, "),
            ("friction", "must be friction=on or friction=off, got 'friction'"),
            ("friction=1", "must be friction=on or friction=off, got 'friction=1'"),
        ],
    )
    def test_bad_ones_are_bad_input(self, folder, capsys, words, message):
        with pytest.raises(SystemExit) as exit_:
            self.solve("--effect", words)
        assert exit_.value.code == 2
        out, err = capsys.readouterr()
        assert not out and message in err and len(err.splitlines()) == 1


class TestCosts:
    def test_the_packaged_file_is_good(self):
        table = effect_costs.recorded()
        assert CostTable.read(effect_costs.RECORDED) == table
        for name, cost in table.costs.items():
            assert ifa.plan(brick(), OPEN)[name].cost == cost

    def test_round_trip(self, tmp_path):
        TABLE.write(tmp_path / "effects.json")
        assert CostTable.read(tmp_path / "effects.json") == TABLE
        assert TABLE.source == "2 cores, ifa 0.1.0, 2026-11-30" and CostTable().source == ""

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"ratio": 0.0}, "friction: ratio: must be finite and above 0, got 0.0"),
            ({"ratio": True}, "friction: ratio: must be finite and above 0, got True"),
            ({"ratio": "fast"}, "friction: ratio: must be finite and above 0, got 'fast'"),
            ({"spread": -0.1}, "friction: spread: must be finite and 0 or more, got -0.1"),
            ({"spread": None}, "friction: spread: must be finite and 0 or more, got None"),
            ({"scene": ""}, "friction: scene: must say what was timed"),
            ({"more": 1}, "friction: needs exactly ratio, spread, scene"),
        ],
    )
    def test_bad_costs_are_named(self, tmp_path, change, message):
        path = tmp_path / "effects.json"
        TABLE.write(path)
        fields = json.loads(path.read_text())
        fields["costs"]["friction"] |= change
        path.write_text(json.dumps(fields))
        with pytest.raises(ifa.IfaFileError) as error:
            CostTable.read(path)
        assert str(error.value) == f"{path}: {message}"

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"machine": ""}, "costs: need the machine, the date and the version of ifa"),
            ({"versions": {}}, "costs: need the machine, the date and the version of ifa"),
            ({"date": 3}, "date: is of the wrong kind"),
            ({"more": 1}, "needs exactly machine, date, versions, costs"),
            ({"costs": {"gyro": vars(COST)}}, "costs: there is no effect 'gyro'"),
        ],
    )
    def test_bad_files_are_named(self, tmp_path, change, message):
        path = tmp_path / "effects.json"
        TABLE.write(path)
        path.write_text(json.dumps(json.loads(path.read_text()) | change))
        with pytest.raises(ifa.IfaFileError) as error:
            CostTable.read(path)
        assert str(error.value) == f"{path}: {message}"

    def test_the_benchmark_records_what_it_measured(self):
        row = Row("friction", "d6, 9 throws", 0.3, 0.2, 1.5, 0.1, 2.0, "ms")
        second = Row("friction", "another", 0.3, 0.2, 1.6, 0.1, 2.0, "ms")
        together = Row("all of them", "ball", 0.3, 0.1, 3.0, 0.1, 0.0, "of the Score")
        table = cost_table([together, row, second])
        assert table.costs == {"friction": Cost(1.5, 0.1, "d6, 9 throws")}
        assert table.versions["ifa"] == ifa.__version__ and "cores" in table.machine

    def test_a_wheel_holds_the_file(self, tmp_path):
        root = Path(__file__).resolve().parents[2]
        pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "-q"]
        kept_from_the_net = ["--no-deps", "--no-index", "--no-build-isolation"]
        without_core = ["--config-settings", "wheel.cmake=false"]  # it takes minutes to compile
        command = [*pip, *kept_from_the_net, *without_core, "-w", tmp_path, root]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        (wheel,) = tmp_path.glob("ifa-*.whl")
        packed = zipfile.ZipFile(wheel).read("ifa/data/effects.json")
        assert packed == effect_costs.RECORDED.read_bytes()
