"""benchmarks/physics: its measures and statistics, its peers, and a run from end to end."""

from __future__ import annotations

import math
from pathlib import Path

import ifa
import numpy as np
import pytest

from benchmarks.physics import __main__ as benchmark
from benchmarks.physics import engines, equivalence, measure, report, starts

ROOT = Path(__file__).resolve().parents[2]
LIBRARIES = ROOT / "build" / "bench" / "benchmarks" / "physics"
G = measure.GRAVITY_M_S2


# --- what is read from a motion -----------------------------------------------------------------


def trace_of(times, heights, speeds):
    """A ball of 1 cm that moves along the vertical, and its trace; heights of its lowest point."""
    n = len(times)
    zero = np.zeros(n)
    return ifa.Body.ball(0.01, mass_kg=0.02), measure.Trace(
        np.array(times),
        np.column_stack([zero, zero, np.array(heights) + 0.01]),
        np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)),
        np.column_stack([zero, zero, speeds]),
        np.zeros((n, 3)),
        True,
    )


HEIGHT_M, RESTITUTION = 0.05, 0.6
FALL_SPEED_M_S = math.sqrt(2.0 * G * HEIGHT_M)
# A ball that is dropped and bounces, case 8 of the hard cases: flights of 2 e^n v / g.
ZENO_S = FALL_SPEED_M_S / G * (1.0 + 2.0 * np.cumsum([0.0, *RESTITUTION ** np.arange(1.0, 4.0)]))


def zeno_nodes():
    """The dropped ball, a row on each side of each of its first four impacts."""
    speeds = FALL_SPEED_M_S * RESTITUTION ** np.arange(5.0)
    both = np.ravel(np.column_stack([-speeds[:-1], speeds[1:]]))
    return trace_of(np.repeat(ZENO_S, 2), np.zeros(8), both)


@pytest.mark.parametrize("early", [False, True])
def test_contacts_of_a_stepped_ball(early):
    """Symplectic Euler; the ball turns once it is below the ground, or before it would be."""
    step_s = 1.0 / 8000
    rows, t, z, v = [], 0.0, HEIGHT_M, 0.0
    while t < 1.1 * ZENO_S[3]:
        rows.append((t, z, v))
        if v < 0.0 and (z + v * step_s if early else z) < 0.0:
            v = -RESTITUTION * v
        v -= G * step_s
        z += v * step_s
        t += step_s
    body, trace = trace_of(*zip(*rows, strict=True))
    errors = np.abs(measure.of_steps(body, trace).contacts_s - ZENO_S)
    # Euler is low by g t step / 2: half a step late at the first contact. A bounce is up to a step
    # late or early; it leaves e times as fast as it came, up to 1 / e steps from the surface, and
    # by up to e g step faster or slower, 2 e steps of flight.
    allowed = 0.5 + np.arange(4) * (1.0 + 1.0 / RESTITUTION + 2.0 * RESTITUTION)
    assert (errors <= 1.01 * allowed * step_s).all()


def test_both_sides_of_impacts_give_their_times():
    body, trace = zeno_nodes()
    assert (measure.of_nodes(body, trace).contacts_s == ZENO_S).all()


def test_an_impact_found_late_is_moved_to_where_the_point_crossed_the_ground():
    body, trace = zeno_nodes()
    late_s = 1e-4
    trace.times_s[:] += late_s
    trace.positions_m[::2, 2] += trace.velocities_m_s[::2, 2] * late_s
    trace.positions_m[1::2, 2] = trace.positions_m[::2, 2]
    # exact but for rounding: the depth is the speed times the delay
    assert measure.of_nodes(body, trace).contacts_s == pytest.approx(ZENO_S, abs=1e-12)


def test_strikes_in_quick_succession_are_one_contact():
    gap = measure.MERGE_GAP_S
    contacts = measure.first_contacts(np.array([1.0 + 0.5 * gap, 1.0, 1.0 + 1.4 * gap, 2.0]))
    assert contacts.tolist() == [1.0, 2.0, np.inf, np.inf]


def test_energy_gain_and_penetration_are_those_put_in():
    body, trace = zeno_nodes()
    speed = abs(trace.velocities_m_s[0, 2])
    trace.velocities_m_s[3:5, 2] = 0.8 * speed, -0.8 * speed  # from the second impact, not 0.36
    trace.positions_m[6:8, 2] -= 2e-4
    outcome = measure.of_nodes(body, trace)
    start_j = 0.5 * speed**2 + G * 0.01  # a kg, at the ground
    gained_j = 0.5 * (0.8**2 - 0.6**2) * speed**2
    # rounding only
    assert outcome.energy_gain == pytest.approx(gained_j / start_j, rel=1e-12)
    assert outcome.penetration_m == pytest.approx(2e-4, abs=1e-15)


def test_rotation_counts_as_energy_as_the_core_says():
    body = ifa.Body.box((0.02, 0.03, 0.04), mass_kg=0.05)
    state = ifa.State((0.0, 0.0, 1.0), (0.3, -0.4, 0.5, 0.6), (0.1, 0.2, 0.3), (5.0, -7.0, 9.0))
    flown = ifa.fly(body, state, np.linspace(0.0, 0.2, 50))
    trace = measure.Trace(
        np.linspace(0.0, 0.2, 50), flown.position_m, flown.quaternion_wxyz, flown.velocity_m_s,
        flown.angular_velocity_rad_s, False,
    )  # fmt: skip
    energy = measure.energies(body, trace)
    assert np.ptp(energy) <= 1e-12 * energy[0]  # flight conserves it; rounding
    w = flown.angular_velocity_rad_s[0]  # the box's moments, turned to world axes by the quaternion
    q = flown.quaternion_wxyz[0]
    axes = np.array([_turn(q, axis) for axis in np.eye(3)])
    moments = 0.05 / 12.0 * np.array([0.03**2 + 0.04**2, 0.02**2 + 0.04**2, 0.02**2 + 0.03**2])
    expected = 0.5 * 0.05 * 0.14 + 0.5 * moments @ (axes @ w) ** 2 + 0.05 * G
    assert energy[0] == pytest.approx(expected, rel=1e-12)


def _turn(q, v):
    w, u = q[0], q[1:]
    return v + 2.0 * np.cross(u, np.cross(u, v) + w * v)


def test_starts_are_in_the_air_and_the_same_again():
    body = ifa.bodies.get("eraser")
    states = starts.lifted(body, 50, seed=4)
    assert starts.clearance(body, states).min() > 0.0
    again = starts.lifted(body, 50, seed=4)
    assert states.position_m.tobytes() == again.position_m.tobytes()
    for i in range(50):
        first = ifa.simulate(body, states[i], until_s=0.2).hits.time_s[0]
        assert first <= starts.LEAD_S[1] + 1e-9  # the contact it was sampled in, or one before


# --- the gate ------------------------------------------------------------------------------------


def test_kolmogorov_smirnov_against_its_definition():
    random = np.random.default_rng(1)
    a, b = random.integers(0, 9, 40).astype(float), random.integers(2, 12, 25).astype(float)
    brute = max(abs((a <= x).mean() - (b <= x).mean()) for x in range(-1, 13))  # with ties
    assert equivalence.kolmogorov_smirnov(a, b) == pytest.approx(brute, abs=1e-15)
    assert equivalence.kolmogorov_smirnov(a, a) == 0.0
    assert equivalence.kolmogorov_smirnov(a, a + 100.0) == 1.0


def test_upper_gamma_against_closed_forms():
    for x in (1e-6, 0.1, 0.9, 1.5, 2.1, 5.0, 30.0):  # both branches of each a
        # a few roundings of the sums
        assert equivalence.upper_gamma(1.0, x) == pytest.approx(math.exp(-x), rel=1e-12)
        assert equivalence.upper_gamma(0.5, x) == pytest.approx(math.erfc(math.sqrt(x)), rel=1e-11)
        third = math.exp(-x) * (1.0 + x + 0.5 * x * x)
        assert equivalence.upper_gamma(3.0, x) == pytest.approx(third, rel=1e-12)
    assert equivalence.upper_gamma(2.0, 0.0) == 1.0


def test_chi_squared_of_two_classes_against_its_closed_form():
    a, b, c, d = 60, 40, 45, 55
    n = a + b + c + d
    statistic = n * (a * d - b * c) ** 2 / ((a + b) * (c + d) * (a + c) * (b + d))
    expected = math.erfc(math.sqrt(0.5 * statistic))  # one degree of freedom
    # rounding
    assert equivalence.chi_squared_p(np.array([[a, b], [c, d]])) == pytest.approx(
        expected, rel=1e-10
    )
    assert equivalence.chi_squared_p(np.array([[7, 9], [7, 9]])) == 1.0


def test_rare_classes_are_counted_together():
    counts = np.array([[500, 300, 2, 1, 0], [480, 310, 1, 3, 4]])
    together = np.array([[500, 300, 3], [480, 310, 8]])
    assert equivalence.chi_squared_p(counts) == equivalence.chi_squared_p(together)


def test_a_die_has_its_faces():
    for name, faces in (("d4", 4), ("d6", 6), ("d12", 12), ("d20", 20)):
        assert len(equivalence.face_normals(ifa.bodies.get(name))) == faces


def sampled(body, states):
    def simulate(some, out):
        ifa.simulate_batch(body, some, until_s=3.0, out=out)

    return equivalence.simulated(body, states, simulate)


def test_the_gate_passes_the_same_and_stops_another_physics():
    body = ifa.bodies.get("d20")
    states = starts.lifted(body, 1200, seed=2)  # more than a chunk
    reference = sampled(body, states)
    assert (reference.faces >= 0).mean() > 0.9
    assert len(np.unique(reference.faces)) >= 20
    assert equivalence.compare(reference, reference).passed
    other = equivalence.compare(sampled(body.replace(restitution=0.55), states), reference)
    assert not other.passed
    # more restitution: more hits, and the second contact of all comes at another time
    assert other.count_d > equivalence.LARGEST_D
    assert other.first_two_exact < 0.01


# --- the engines ---------------------------------------------------------------------------------

KINDS, MISSING = engines.available(LIBRARIES)


@pytest.mark.parametrize("name", ["ode", "ode_flight", "bullet", "mujoco"])
def test_a_peer_flies_and_meets_the_ground_when_its_step_allows(name):
    if name in MISSING:
        pytest.skip(f"{name}: {MISSING[name]}; make bench-physics has it")
    kind = next(kind for kind in KINDS if kind.name == name)
    body = ifa.bodies.get("d20").replace(rolling_friction_m=0.0, spin_friction_m=0.0)
    states = starts.lifted(body, 10, seed=3)
    step_s = 1.0 / 2000
    engine = kind.make(body, step_s)
    exact = engines.Event(body, step_s)
    for i in range(len(states)):
        first = engine.trace(states[i])
        # conversion to the engine's own axes, units and back: rounding
        assert np.abs(first.positions_m[0] - states[i].position_m).max() <= 1e-12
        assert abs(abs(first.quaternions_wxyz[0] @ states[i].quaternion_wxyz) - 1.0) <= 1e-12
        assert np.abs(first.velocities_m_s[0] - states[i].velocity_m_s).max() <= 1e-12
        assert np.abs(first.spins_rad_s[0] - states[i].angular_velocity_rad_s).max() <= 1e-10
        own, other = engine.outcome(states[i]), exact.outcome(states[i])
        # A d20's spin is constant in flight, so the error is that of the parabola: symplectic Euler
        # is low by g t step / 2 (closed-form flight: not at all). The turning within a step adds
        # its curvature, r w^2 step^2 / 8: 1e-7 m at 20 rad/s. Over the approach of 0.5 m/s or more.
        approach = ifa.simulate(body, states[i], until_s=0.2).hits.approach_speed_m_s[0]
        low_m = 0.5 * G * other.contacts_s[0] * step_s + 1e-6
        assert abs(own.contacts_s[0] - other.contacts_s[0]) <= low_m / approach * 1.1


def test_a_small_run_from_end_to_end(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    arguments = ["--quick", "--bodies", "d6", "--simulations", "3", "--seed", "5"]
    arguments += ["--engines", "event", "--output", str(tmp_path), "--only", "peers"]
    assert benchmark.main(arguments) == 0
    assert "seed 5" in capsys.readouterr().out
    text = (tmp_path / "comparison.csv").read_text(encoding="utf-8")
    assert "# seed 5" in text and "# processor: " in text
    rows = report.read_csv(tmp_path / "comparison.csv")
    assert [row["steps_per_s"] for row in rows] == [240.0, 2000.0, 16000.0]
    for row in rows:
        assert row["contact_1_median_ms"] <= 1e-9  # exact at any step; rounding
        assert row["rest_share"] == 1.0
    assert (tmp_path / "work_precision.png").read_bytes().startswith(b"\x89PNG")


def test_a_small_run_of_the_speed_table(tmp_path, capsys):
    arguments = ["--quick", "--bodies", "d20", "--simulations", "30", "--only", "speed"]
    arguments += ["--output", str(tmp_path), "--libraries", str(tmp_path)]  # without ODE: no bar
    benchmark.main(arguments)
    assert "first two impacts" in capsys.readouterr().out
    rows = report.read_csv(tmp_path / "speed.csv")
    assert all(row["first_impacts_s"] <= equivalence.LARGEST_ERROR_S for row in rows)
