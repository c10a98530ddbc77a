"""`ifa.estimate` against brute force and simulations, and its face: dataclasses, JSON, text."""

from __future__ import annotations

import dataclasses
import json
from itertools import pairwise

import ifa
import numpy as np
import pytest
from ifa import cli, report

G_M_S2 = 9.81


def heard(hits):
    """When audible events begin, by the definitions of CONVENTIONS.md."""
    times_s = np.asarray(hits.time_s)[np.asarray(hits.approach_speed_m_s) >= 0.05]
    first = np.diff(times_s, prepend=-1.0) >= 0.01
    return times_s[first]


def test_ranges_and_energies_are_those_of_all_parabolas():
    body = ifa.bodies.get("eraser")
    times_s = [0.0, 0.03, 0.1, 0.35, 0.5]
    estimate = ifa.estimate(body, ifa.Signature(times_s))
    low_m, high_m = estimate.centre_height_m
    heights_m = np.linspace(low_m, high_m, 41)
    z0_m, z1_m = (z.ravel()[:, None] for z in np.meshgrid(heights_m, heights_m))
    share = np.linspace(0.0, 1.0, 4001)
    for gap, (a_s, b_s) in zip(estimate.gaps, pairwise(times_s), strict=True):
        flight_s = b_s - a_s
        speed_m_s = (z1_m - z0_m) / flight_s + 0.5 * G_M_S2 * flight_s
        t_s = share * flight_s
        rise_m = (speed_m_s * t_s - 0.5 * G_M_S2 * t_s**2).max(axis=1)
        energy_j = body.mass_kg * (0.5 * speed_m_s**2 + G_M_S2 * (z0_m - low_m))
        # the extremes are in corners of the grid, so only rounding differs ...
        assert gap.takeoff_speed_range_m_s == pytest.approx(
            (speed_m_s.min(), speed_m_s.max()), rel=1e-12
        )
        assert gap.energy_j == pytest.approx(energy_j.min(), rel=1e-12)
        assert gap.most_energy_j == pytest.approx(energy_j.max(), rel=1e-12)
        # ... and an apex lies within half a step of 1/4000 of the flight from a sample
        missed_m = 0.5 * G_M_S2 * (flight_s / 8000) ** 2
        assert gap.apex_range_m == pytest.approx((rise_m.min(), rise_m.max()), abs=1.01 * missed_m)


def test_the_energy_budget_by_brute_force():
    rng = np.random.default_rng(5)
    body = ifa.bodies.get("d6")
    times_s = np.cumsum(rng.uniform(0.02, 0.3, 500))
    gaps = ifa.estimate(body, ifa.Signature(times_s)).gaps
    assert len(gaps) == 499
    least_m, most_m = ifa.estimate(body, ifa.Signature(times_s)).centre_height_m
    corners_m = np.array([[a, b] for a in (0, most_m - least_m) for b in (0, most_m - least_m)])

    def energies_j(flight_s):
        speed_m_s = 0.5 * G_M_S2 * flight_s + (corners_m[:, 1] - corners_m[:, 0]) / flight_s
        return body.mass_kg * (0.5 * speed_m_s**2 + G_M_S2 * corners_m[:, 0])

    flights_s = np.diff(times_s)
    for k, gap in enumerate(gaps):
        # rounding: the times are 80 s, the gaps 0.02 s and more
        assert gap.needed_j == pytest.approx(
            max(energies_j(t).min() for t in flights_s[k:]), rel=1e-11
        )
        if k == 0:
            assert gap.surplus_j == 0.0
            continue
        had_j = max(energies_j(flights_s[k - 1] * r).max() for r in np.linspace(1 / 1.07, 1.07, 99))
        surplus_j = max(0.0, energies_j(flights_s[k] / 1.07).min() - had_j)
        assert gap.surplus_j == pytest.approx(surplus_j, rel=1e-9, abs=1e-15)
    assert sum(gap.surplus_j > 0.0 for gap in gaps) > 100


def test_simulated_throws_are_not_called_impossible_to_end():
    """No false alarm about rest; and the restitution hint is as good as documented."""
    off = {"ball": [], "others": []}
    for name in ifa.bodies.names():
        for restitution in (0.35, 0.5, 0.65, 0.8):
            body = ifa.bodies.get(name).replace(restitution=restitution)
            batch = ifa.simulate_batch(body, ifa.sample_states(body, 10, seed=9))
            for k in range(10):
                times_s = heard(batch.hits(k))
                if len(times_s) < 3:
                    continue
                estimate = ifa.estimate(body, ifa.Signature(times_s))
                assert estimate.rest_is_near, (name, restitution, k)
                if name == "ball":
                    assert estimate.findings == []
                if estimate.restitution_from_gaps:
                    kind = "ball" if name == "ball" else "others"
                    off[kind].append(abs(estimate.restitution - restitution))
    # a ball's gaps, of 10 ms and more, are known to 1e-15 s
    assert max(off["ball"]) < 1e-12
    # 0.12 over 3,800 throws of another seed, with a standard deviation of 0.12: three times that of
    # a mean over 300 on top. A guess of 0.5 would be off by 0.15.
    assert len(off["others"]) > 300
    assert np.mean(off["others"]) < 0.14


@pytest.mark.parametrize("times_s", [[0.3], [0.3, 0.5], np.arange(500) * 0.11, [0.2, 60.2, 60.3]])
def test_any_number_of_marks(times_s):
    marks = ifa.Signature(times_s)
    estimate = ifa.estimate(ifa.bodies.get("coin"), marks)
    assert len(estimate.gaps) == len(marks) - 1
    assert estimate.restitution_from_gaps == (len(marks) > 2)
    content = json.loads(json.dumps(estimate.to_dict(), allow_nan=False))
    assert len(content["gaps"]) == len(estimate.gaps)
    assert report.estimate_text(estimate, ifa.bodies.get("coin"), marks)


def test_findings_name_the_mark():
    estimate = ifa.estimate(ifa.bodies.get("d6"), ifa.Signature([0.25, 1.25, 1.3]))
    assert [str(finding) for finding in estimate.findings] == [
        "mark 2 (1.25 s): the gap before it needs an apex of 1.2 m if the body flies, and a "
        "take-off at 4.9 m/s"
    ]
    assert estimate.findings[0].mark == 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        estimate.restitution = 1.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("d6", None), "body: needs an ifa.Body"),
        ((None, [0.1]), "marks: needs an ifa.Signature"),
        ((None, None, 0.0), "gravity_m_s2: must be finite and above 0, got 0"),
        ((None, None, [0, 0, 1]), "gravity_m_s2: must point into the ground"),
        ((None, None, [0, 0]), "gravity_m_s2: needs shape (3,), got (2,)"),
    ],
)
def test_bad_arguments(arguments, message):
    body, marks, *gravity = arguments
    body = ifa.bodies.get("d6") if body is None else body
    marks = ifa.Signature([0.1, 0.2]) if marks is None else marks
    with pytest.raises(ifa.IfaValueError) as caught:
        ifa.estimate(body, marks, *gravity)
    assert str(caught.value) == message


def test_the_command_line(tmp_path, capsys):
    marks = tmp_path / "roll.txt"
    marks.write_text("0.30\t0.30\thit\n0.40\t0.40\thit\n0.58\t0.58\thit\n", encoding="utf-8")
    assert cli.main(["estimate", "d6", str(marks), "--json"]) == cli.DONE
    content = json.loads(capsys.readouterr().out)
    expected = ifa.estimate(ifa.bodies.get("d6"), ifa.Signature.read(marks))
    assert content == json.loads(json.dumps(expected.to_dict()))
    assert cli.main(["estimate", "d6", str(marks)]) == cli.DONE
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "d6: 3 marks, 0.28 s"
    assert lines[1].startswith("restitution 0.5 (the body's own), friction 0.25 (the body's own")
    assert lines[-1].startswith("mark 3 (0.58 s): the gap before it is 1.8 times as long as ")
    # the row of mark 3: 180 ms, an apex of g T^2 / 8, needed by nothing later
    assert lines[-3].split()[:6] == ["3", "0.5800", "180.0", "1.80", "0.883", "39.73"]
    assert cli.main(["estimate", "d6", str(tmp_path / "none.txt")]) == cli.BAD_INPUT


def test_a_text_has_ten_findings_at_most():
    marks = ifa.Signature(np.cumsum([0.3, *[0.1, 0.4] * 30]))
    body = ifa.bodies.get("ball")
    estimate = ifa.estimate(body, marks)
    assert len(estimate.findings) == 30 + 1  # each longer gap, and the ending
    lines = report.estimate_text(estimate, body, marks).splitlines()
    assert sum(line.startswith("mark ") and " s): " in line for line in lines) == 10
    assert lines[-1] == "and 21 more (--json has all)"
