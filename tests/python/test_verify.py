"""The face of the verifier: what it reads, what it refuses, and what it says.

The C++ tests plant every fault; here the motion is a closed-form bouncing ball, so each expected
time and speed is known without the package.
"""

import json
import math
from types import SimpleNamespace

import ifa
import numpy as np
import pytest

G = 9.81
RADIUS = 0.01
HEIGHT = 0.3
RESTITUTION = 0.6


def bouncing_ball(retime=(1.0, 1.0, 1.0, 1.0)):
    """Poses, impact times and speeds of a dropped ball that sticks at its fourth impact."""
    speed = math.sqrt(2 * G * HEIGHT)
    times, heights = [0.0], [HEIGHT]
    hits, speeds = [], []
    start, up, length = 0.0, 0.0, speed / G
    for ratio in retime:
        n = max(5, math.ceil(length * ratio / 1e-3))
        base = HEIGHT if not hits else 0.0
        for i in range(1, n + 1):
            s = length * i / n
            times.append(start + ratio * s)
            heights.append(0.0 if i == n else base + up * s - 0.5 * G * s * s)
        start = times[-1]
        hits.append(start)
        speeds.append(speed / ratio)
        speed *= RESTITUTION
        up, length = speed, 2 * speed / G
    for i in range(1, 101):
        times.append(start + 1e-3 * i)
        heights.append(0.0)
    n = len(times)
    positions = np.zeros((n, 3))
    positions[:, 2] = np.array(heights) + RADIUS
    quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    fields = {"times_s": np.array(times), "positions_m": positions, "quaternions_wxyz": quaternions}
    return fields, hits, speeds


@pytest.fixture
def ball():
    return ifa.Body.ball(RADIUS, mass_kg=0.005)


@pytest.fixture
def case(ball):
    fields, hits, speeds = bouncing_ball()
    return SimpleNamespace(
        motion=SimpleNamespace(**fields),
        fields=fields,
        body=ball,
        marks=ifa.Signature(hits),
        hits=hits,
        speeds=speeds,
    )


def as_file(path, fields, **more):
    plain = {key: np.asarray(value).tolist() for key, value in fields.items()}
    path.write_text(json.dumps(plain | more))
    return path


def test_clean_motion_passes_with_exact_hits(case):
    certificate = ifa.verify(case.motion, case.body, case.marks)
    assert certificate.passed, certificate.summary()
    assert certificate.failures == ()
    # Impact samples are exact; differences of a parabola are exact up to rounding.
    np.testing.assert_allclose([h.time_s for h in certificate.hits], case.hits, atol=1e-12)
    np.testing.assert_allclose(
        [h.approach_speed_m_s for h in certificate.hits], case.speeds, rtol=1e-8
    )
    assert [m.target_s for m in certificate.marks] == case.hits
    assert certificate.rest_s == pytest.approx(case.hits[-1], abs=1e-12)
    assert len(certificate.flights) == 4
    # The energy of a flight is m g times the height of its apex.
    for k, flight in enumerate(certificate.flights):
        apex = RADIUS + HEIGHT * RESTITUTION ** (2 * k)
        assert flight.energy_j == pytest.approx(0.005 * G * apex, rel=1e-8)


def test_file_mapping_and_object_give_the_same(case, tmp_path):
    from_object = ifa.verify(case.motion, case.body, case.marks)
    path = as_file(tmp_path / "out.json", case.fields, score=0.9)
    assert ifa.verify(path, case.body, case.marks) == from_object
    assert ifa.verify(str(path), case.body, case.marks) == from_object
    assert ifa.verify(json.loads(path.read_text()), case.body, case.marks) == from_object


def test_to_dict_is_json_without_null(case):
    times = [*case.hits[:2], 0.5 * (case.hits[1] + case.hits[2]), *case.hits[2:]]
    certificate = ifa.verify(case.motion, case.body, ifa.Signature(times))
    assert certificate.missed_hits == 1
    plain = certificate.to_dict()
    text = json.dumps(plain, allow_nan=False)
    assert "null" not in text
    assert json.loads(text) == plain
    assert "achieved_s" not in plain["marks"][2]
    assert plain["marks"][3]["error_s"] == pytest.approx(0.0, abs=1e-12)
    assert "FAILED" in certificate.summary()
    assert any("mark 3 " in line for line in certificate.summary().splitlines())


def test_retime_claims_of_a_file_are_checked(ball, tmp_path):
    ratios = (1.0, 0.9, 1.1, 1.0)
    fields, hits, _ = bouncing_ball(ratios)
    marks = ifa.Signature(hits)
    events = [{"retime": r} for r in ratios]
    path = as_file(tmp_path / "out.json", fields, events=events, energy_gain_j=0.0)
    assert ifa.verify(path, ball, marks).passed
    assert ifa.verify(SimpleNamespace(**fields), ball, marks, retime=ratios).passed
    unclaimed = ifa.verify(SimpleNamespace(**fields), ball, marks)
    assert not unclaimed.passed
    # Slowed by 1.1 the flight shows g / 1.21; the parabola is 1 - 1 / 1.21 lower than expected.
    assert unclaimed.flights[2].gravity_error == pytest.approx(1 - 1 / 1.21, rel=1e-4)
    assert unclaimed.flights[1].gravity_error == pytest.approx(1 / 0.81 - 1, rel=1e-4)


def test_claims_for_another_number_of_marks_are_not_relied_on(ball, tmp_path):
    ratios = (1.0, 0.9, 1.1, 1.0)
    fields, hits, _ = bouncing_ball(ratios)
    path = as_file(tmp_path / "out.json", fields, events=[{"retime": r} for r in ratios])
    certificate = ifa.verify(path, ball, ifa.Signature(hits[:3]))
    assert certificate.claimed_retime == (1.0, 1.0, 1.0)
    assert certificate.extra_hits == 1
    np.testing.assert_allclose(certificate.extra_events_s, [hits[3]], atol=1e-12)
    missed = ifa.verify(path, ball, ifa.Signature([*hits, hits[-1] + 0.5]))
    assert missed.missed_hits == 1 and not missed.passed


def test_summary_states_the_claims_it_relies_on(ball, tmp_path):
    ratios = (1.0, 0.8, 1.1, 1.0)
    fields, hits, _ = bouncing_ball(ratios)
    events = [{"retime": r} for r in ratios]
    path = as_file(tmp_path / "out.json", fields, events=events, energy_gain_j=0.002)
    certificate = ifa.verify(path, ball, ifa.Signature(hits))
    claims = [line for line in certificate.summary().splitlines() if "claims" in line]
    assert len(claims) == 1
    assert "25 %" in claims[0]  # 1 / 0.8
    assert "0.002 J" in claims[0]
    assert certificate.claimed_retime == ratios and certificate.claimed_energy_gain_j == 0.002
    plain, hits, _ = bouncing_ball()
    trivial = ifa.verify(SimpleNamespace(**plain), ball, ifa.Signature(hits))
    assert "claims" not in trivial.summary()


def test_faults_are_sentences_that_name_them(case):
    shifted = ifa.Signature([case.hits[0], case.hits[1] - 0.002, *case.hits[2:]])
    certificate = ifa.verify(case.motion, case.body, shifted)
    assert [f for f in certificate.failures if "mark 2" in f and "2 ms late" in f]
    assert certificate.max_abs_error_s == pytest.approx(0.002, abs=1e-9)

    extra = ifa.verify(case.motion, case.body, ifa.Signature([*case.hits[:2], case.hits[3]]))
    assert extra.extra_hits == 1
    np.testing.assert_allclose(extra.extra_events_s, [case.hits[2]], atol=1e-12)

    case.motion.positions_m[:, 2] -= 2e-4
    deep = ifa.verify(case.motion, case.body, case.marks)
    assert deep.max_penetration_m == pytest.approx(2e-4, rel=1e-6)
    assert len(deep.failures) == 1 and "0.2 mm in the ground" in deep.failures[0]


def test_a_motion_that_cannot_be_checked_fails_with_the_reason(case):
    case.motion.positions_m[5, 1] = np.nan
    certificate = ifa.verify(case.motion, case.body, case.marks)
    assert certificate.failures == ("sample 5 holds a number that is not finite",)
    assert certificate.missed_hits == len(case.marks)
    json.dumps(certificate.to_dict(), allow_nan=False)


def test_open_ending_asks_nothing_after_the_last_mark(case):
    marks = ifa.Signature(case.hits[:2], ending="open")
    assert ifa.verify(case.motion, case.body, marks).passed


def test_options_are_applied(case):
    shifted = ifa.Signature([case.hits[0] + 0.002, *case.hits[1:]])
    assert ifa.verify(case.motion, case.body, shifted, time_tolerance_s=0.003).passed
    # Only the first two impacts are faster than 1 m/s: 2.43, 1.46, 0.87, 0.52.
    marks = ifa.Signature(case.hits[:2])
    assert ifa.verify(case.motion, case.body, marks, audible_speed_m_s=1.0).passed
    assert not ifa.verify(case.motion, case.body, case.marks, gravity_m_s2=9.7).passed


def soft_last_bounce():
    """Bounces after flights of 0.25 s and 20 ms: the last, at 0.098 m/s, is audible or not.

    The body stays from then on.
    """
    speed, last = 0.125 * G, 0.010 * G
    times, heights = [0.0], [0.5 * speed**2 / G]
    start = 0.0
    for up, height, length in ((0.0, heights[0], 0.125), (speed, 0.0, 0.25), (last, 0.0, 0.020)):
        for i in range(1, 251):
            s = length * i / 250
            times.append(start + s)
            heights.append(0.0 if i == 250 else height + up * s - 0.5 * G * s * s)
        start = times[-1]
    for i in range(1, 101):
        times.append(start + 1e-3 * i)
        heights.append(0.0)
    positions = np.zeros((len(times), 3))
    positions[:, 2] = np.array(heights) + RADIUS
    quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
    fields = {"times_s": np.array(times), "positions_m": positions, "quaternions_wxyz": quaternions}
    return fields, [0.125, 0.375, 0.395]


def test_contact_events_count_what_is_not_heard(ball):
    fields, hits = soft_last_bounce()
    motion = SimpleNamespace(**fields)
    two = ifa.Signature(hits[:2])
    assert ifa.verify(motion, ball, two, audible_speed_m_s=0.15).passed
    contact = ifa.verify(motion, ball, two, events="contact", audible_speed_m_s=0.15)
    assert contact.extra_hits == 1
    np.testing.assert_allclose(contact.extra_events_s, [hits[2]], atol=1e-12)
    assert contact.failures == ("a contact that begins at 0.395 s answers no mark",)
    assert ifa.verify(motion, ball, ifa.Signature(hits), events="contact").passed
    # flights below 30 ms join what they part
    merged = ifa.verify(motion, ball, two, events="contact", merge_gap_s=0.030)
    assert merged.passed
    assert [event.hits for event in merged.events] == [1, 2]
    # from the second impact to where the body comes to rest, not to the end of the motion
    assert merged.events[1].duration_s == pytest.approx(0.020, abs=1e-9)


def test_a_motion_is_checked_for_the_events_it_was_made_for(ball, tmp_path):
    fields, hits = soft_last_bounce()
    two = ifa.Signature(hits[:2])
    hearing = {"events": "contact", "audible_speed_m_s": 0.15, "merge_gap_s": 0.010}
    path = as_file(tmp_path / "out.json", fields, hearing=hearing)
    for motion in (path, SimpleNamespace(**fields, hearing=hearing)):
        found = ifa.verify(motion, ball, two)
        assert found.extra_hits == 1
        assert found.options["events"] == "contact"
        assert found.options["audible_speed_m_s"] == 0.15
        assert "events: intervals of contact" in found.summary()
        asked = ifa.verify(motion, ball, two, events="audible")  # the caller's word counts more
        assert asked.passed and asked.options["audible_speed_m_s"] == 0.15
        assert "events: hits from 0.15 m/s on" in asked.summary()
    part = as_file(tmp_path / "part.json", fields, hearing={"merge_gap_s": 0.030})
    assert ifa.verify(part, ball, two).options["events"] == "audible"
    assert ifa.verify(part, ball, two).passed


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f.pop("positions_m"), "positions_m: is missing"),
        (lambda f: f.update(times_s="soon"), "times_s: must be an array of numbers"),
        (lambda f: f.update(times_s=f["times_s"][:-1]), "one row for each"),
        (lambda f: f.update(quaternions_wxyz=[[1, 0, 0]]), "quaternions_wxyz: needs shape"),
        (lambda f: f.update(events=3), "events: must be a list"),
        (lambda f: f.update(events=[{"retime": "x"}] * 4), r"events\[0\].retime"),
        (lambda f: f.update(events=[{"retime": -1}] * 4), "retime: the ratio of mark 1"),
        (lambda f: f.update(hearing=3), "hearing: must be an object"),
        (lambda f: f.update(hearing={"events": "heard"}), r"hearing\.events: must be"),
        (lambda f: f.update(hearing={"events": ["contact"]}), r"hearing\.events: must be"),
        (lambda f: f.update(hearing={"merge_gap_s": None}), r"hearing\.merge_gap_s: must be"),
        (lambda f: f.update(hearing={"merge_gap_s": -1}), "merge_gap_s: must be above 0"),
        (lambda f: f.update(energy_gain_j=None), "energy_gain_j"),
        (lambda f: f.update(energy_gain_j=-1.0), "energy_gain_j"),
    ],
)
def test_malformed_files_name_file_and_field(case, tmp_path, change, words):
    fields = {key: value.tolist() for key, value in case.fields.items()}
    change(fields)
    path = tmp_path / "out.json"
    path.write_text(json.dumps(fields))
    with pytest.raises(ifa.IfaValueError, match=words) as error:
        ifa.verify(path, case.body, case.marks)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", '{"times_s": [NaN]}', "\ufffd\0"])
def test_files_that_hold_no_motion(case, tmp_path, text):
    path = tmp_path / "out.json"
    path.write_text(text)
    with pytest.raises(ifa.IfaFileError, match=r"out\.json"):
        ifa.verify(path, case.body, case.marks)
    with pytest.raises(ifa.IfaFileError, match=r"absent\.json"):
        ifa.verify(tmp_path / "absent.json", case.body, case.marks)


def test_arguments_of_the_wrong_kind(case):
    with pytest.raises(ifa.IfaValueError, match="motion"):
        ifa.verify(object(), case.body, case.marks)
    with pytest.raises(ifa.IfaValueError, match="body"):
        ifa.verify(case.motion, "d6", case.marks)
    with pytest.raises(ifa.IfaValueError, match="marks"):
        ifa.verify(case.motion, case.body, [0.1, 0.2])
    with pytest.raises(ifa.IfaValueError, match="gravity_m_s2"):
        ifa.verify(case.motion, case.body, case.marks, gravity_m_s2=-9.81)
    with pytest.raises(ifa.IfaValueError, match="retime"):
        ifa.verify(case.motion, case.body, case.marks, retime=[1.0])
    with pytest.raises(ifa.IfaValueError, match='events: must be "audible" or "contact"'):
        ifa.verify(case.motion, case.body, case.marks, events="heard")
