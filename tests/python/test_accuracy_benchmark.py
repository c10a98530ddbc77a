"""benchmarks/accuracy_presets: outcomes of climbs by hand, shares, and a run from end to end."""

from __future__ import annotations

import argparse
import csv
import dataclasses
import json

import ifa
import pytest
from ifa.prediction import Rung, expected

from benchmarks.accuracy_presets import __main__ as benchmark
from benchmarks.accuracy_presets import candidates, climbs, keys, predictions, section

GOOD = ifa.ACCURACIES["good"]


def climb(*rungs, marks=4):
    return climbs.Measured("case", "kind", marks, "given", tuple(Rung(*rung) for rung in rungs))


HARD = climb((10, 1.0, False, False, 1.0), (30, 2.0, True, False, 0.4), (90, 8.0, True, True, 0.2))
EASY = climb((10, 1.0, True, True, 0.3), (30, 3.0, True, True, 0.1), (90, 9.0, True, True, 0.25))


def preset(**changes):
    return dataclasses.replace(GOOD, **{"ladder": (10, 30, 90)} | changes)


@pytest.mark.parametrize(
    ("changes", "hard", "easy"),
    [
        ({}, (11.0, True, True, 0.2), (1.0, True, True, 0.3)),
        ({"until": "succeeded"}, (3.0, True, False, 0.4), (1.0, True, True, 0.3)),
        ({"least_rung": 2}, (11.0, True, True, 0.2), (13.0, True, True, 0.1)),
        ({"ladder": (30,)}, (2.0, True, False, 0.4), (3.0, True, True, 0.1)),
    ],
)
def test_outcomes_are_those_of_the_rungs(changes, hard, easy):
    own = preset(**changes)
    assert candidates.outcome(own, HARD) == hard
    assert candidates.outcome(own, EASY) == easy
    # and of a climb that was seen to its end a prediction says the same
    for measured, wanted in ((HARD, hard), (EASY, easy)):
        seen = {rung.beam: rung for rung in measured.rungs}
        assert expected(own, seen, 4, []) == (wanted[0], wanted[3])


def test_a_point_counts_failures_as_error_one():
    failed = climb((10, 4.0, False, False, 0.2))
    row = candidates.point(preset(), [EASY, failed])
    assert (row["time_mean_s"], row["error_mean"]) == (2.5, 0.65)
    assert (row["cases"], row["succeeded"], row["plausible"]) == (2, 1, 1)


def test_the_front_is_what_nothing_beats():
    points = ((1, 3), (2, 2), (3, 1), (2, 3), (3, 2))
    rows = [{"cases": 2, "time_mean_s": t, "error_mean": e} for t, e in points]
    rows.append({"cases": 1, "time_mean_s": 0.1, "error_mean": 0.1})  # without its slow case
    candidates.mark_front(rows)
    assert [row["on_front"] for row in rows] == [True, True, True, False, False, False]


def test_shares_count_what_is_within_the_factor():
    def row(name, time_ratio, error_ratio, reached):
        return {
            "accuracy": name, "time_ratio": time_ratio, "error_ratio": error_ratio,
            "reached": reached, "calibration_s": 0.5,
        }  # fmt: skip

    rows = [row(name, 1.0, 1.0, True) for name in ifa.ACCURACIES]
    rows += [row("good", 1.9, 0.4, False), row("good", 2.1, 0.6, False)]
    good = predictions.shares(rows)[1]
    assert (good["time_within"], good["error_within"], good["both_within"]) == (2, 2, 1)
    assert (good["unseen"], good["unseen_time_within"], good["unseen_error_within"]) == (2, 1, 1)


def test_measures_and_records(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(benchmark, "DATA", tmp_path / "accuracy.json")
    monkeypatch.setattr(climbs, "BEAMS", (10, 20, 40))
    out = ["--limit", "1", "--output", str(tmp_path), "--shared", str(tmp_path / "absent")]
    assert benchmark.main([*out, "--record", "--clock", "cpu"]) == 0
    content = json.loads((tmp_path / "accuracy.json").read_text())
    assert len(content["climbs"]) == sum(content["measured"]["cases"].values()) == 2
    assert [rung[0] for rung in content["climbs"][0]["rungs"]] == [10, 20, 40]
    assert {point["preset"] for point in content["points"]} >= set(ifa.ACCURACIES)
    lines = [x for x in (tmp_path / "climbs.csv").read_text().splitlines() if x[0] != "#"]
    assert len(list(csv.DictReader(lines))) == 6
    assert "on the front" in capsys.readouterr().out
    # a rung by itself is the rung of a climb
    for (_, case), measured in zip(
        climbs.cases(benchmark_options(tmp_path)), content["climbs"], strict=True
    ):
        solution = ifa.solve(case.body, case.marks, material=case.material, rung=0)
        assert measured["rungs"][2][2:4] == [solution.succeeded, solution.plausible]
        assert measured["rungs"][2][4] == pytest.approx(solution.error, rel=1e-3)  # four digits

    assert benchmark.main([*out, "--predict"]) == 2  # there are no recordings
    assert "skipped" in capsys.readouterr().out


def benchmark_options(tmp_path):
    return argparse.Namespace(shared=tmp_path / "absent", limit=1)


def test_finer_tolerances_take_more_keys(tmp_path):
    options = benchmark_options(tmp_path)
    options.seed = 0
    rows = keys.rows(options)
    assert [row["preset"] for row in rows if row["preset"]] == list(ifa.ACCURACIES)
    counts = [row["keys_per_s"] for row in rows]
    assert counts == sorted(counts) and counts[0] < counts[-1]


def test_the_section_names_every_preset():
    text = section.markdown()
    for name in ifa.ACCURACIES:
        assert f"| **{name}** |" in text
    assert "1 - Score" in text


@pytest.mark.parametrize("words", [["--limit", "0"], ["--processes", "2"], ["--clock", "sun"]])
def test_bad_options_end_with_2(words):
    with pytest.raises(SystemExit) as caught:
        benchmark.main(words)
    assert caught.value.code == 2
