"""Accuracy against time: the folder that shows the curves, and the command line."""

from __future__ import annotations

import base64
import csv
import json
import math
import re
import signal
import subprocess
import sys
from html.parser import HTMLParser

import ifa
import numpy as np
import pytest
from ifa.tradeoff import picture, table
from ifa.tradeoff.report import check_folder
from scripted_studies import BALL_MARKS, report_of


def test_csv_is_the_points_again(mixed):
    rows = list(csv.DictReader(table.csv_text(mixed).splitlines()))
    points = [(curve, point) for curve in mixed for point in curve.points]
    assert len(rows) == len(points)

    def number(text):
        return float(text) if text else math.nan

    for row, (curve, point) in zip(rows, points, strict=True):
        assert (row["knob"], row["series"], row["setting"]) == (
            curve.study.knob, point.series, point.label,
        )  # fmt: skip
        figures = [number(row[k]) for k in ("time_s", "time_least_s", "time_most_s")]
        np.testing.assert_equal(figures, [point.time_s, *point.time_range_s])
        figures = [number(row[k]) for k in ("error", "error_least", "error_most")]
        np.testing.assert_equal(figures, [point.error, *point.error_range])
        assert int(row["repeats"]) == point.repeats
        assert int(row["not_reached"]) == point.not_reached
        assert bool(int(row["on_front"])) == point.on_front
        assert all(failure in row["failures"] for failure in point.failures)
        assert all(loss in row["losses"] for loss in point.losses)


class Page(HTMLParser):
    """What a page consists of; tags must be closed in order."""

    def __init__(self):
        super().__init__()
        self.open, self.sections, self.images, self.text, self.links = [], [], [], [], []

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.links += [
            v for k, v in attributes if k in ("href", "src") and not v.startswith("data:")
        ]
        if tag == "section":
            self.sections.append(values["id"])
        if tag == "img":
            self.images.append(values["src"])
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def test_a_report_shows_every_study_and_failure(mixed, tmp_path):
    pytest.importorskip("matplotlib")
    out = tmp_path / "report"
    report = report_of(*mixed)
    report.write(out)
    assert not report.complete
    page = Page()
    page.feed((out / "tradeoff.html").read_text("utf-8"))
    assert page.open == [] and page.links == []
    assert page.sections == ["scripted", "empty", "late"]
    text = " ".join(page.text)
    for words in (
        "no motion", 'it, "fell" | <b>', "2 of 9 throws", "0 of 3 repeats run", "a <fast> one",
        "nothing to turn here", "a <note> & more", "the time was up",
    ):  # fmt: skip
        assert words in text, words
    assert len(page.images) == 2
    for image, name in zip(page.images, ("scripted", "late"), strict=True):
        data = base64.b64decode(image.removeprefix("data:image/png;base64,"))
        assert data == (out / f"{name}.png").read_bytes()
        assert data.startswith(b"\x89PNG")
    content = json.loads((out / "tradeoff.json").read_text("utf-8"))
    assert sorted(content["files"]) == sorted(path.name for path in out.iterdir())
    assert [len(curve["points"]) for curve in content["curves"]] == [6, 0, 1]
    assert (out / "tradeoff.csv").read_text("utf-8") == table.csv_text(report.curves)


def test_a_picture_names_what_failed(mixed):
    pytest.importorskip("matplotlib")
    from matplotlib.figure import Figure

    figures = []
    savefig = Figure.savefig
    Figure.savefig = lambda self, *args, **keywords: figures.append(self)
    try:
        picture.png(mixed[0])
        picture.png(mixed[2])
    finally:
        Figure.savefig = savefig
    texts = [[text.get_text() for text in figure.findobj(match=_is_text)] for figure in figures]
    for label in ("good", "exact", "part", "bad", "lossy", "nan", "failed", "in part failed"):
        assert label in texts[0], label
    assert "not reached in time: left out" in texts[1]


def _is_text(artist):
    return hasattr(artist, "get_text")


def test_only_reports_are_replaced(mixed, tmp_path):
    pytest.importorskip("matplotlib")
    out = tmp_path / "report"
    report_of(*mixed).write(out)
    report_of(mixed[1]).write(out)  # an earlier report may be
    assert not (out / "scripted.png").exists()
    (out / "thesis.txt").write_text("mine")
    with pytest.raises(ifa.IfaFileError, match=r"thesis\.txt is not of an earlier report"):
        report_of(*mixed).write(out)
    assert (out / "thesis.txt").read_text() == "mine"
    plain = tmp_path / "file"
    plain.write_text("")
    with pytest.raises(ifa.IfaFileError, match="no folder"):
        check_folder(plain)
    with pytest.raises(ifa.IfaFileError, match="there is no folder"):
        check_folder(tmp_path / "none" / "report")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "report"]


def test_a_failed_write_leaves_nothing(mixed, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    out = tmp_path / "report"
    report_of(mixed[1]).write(out)
    before = {path.name: path.read_bytes() for path in out.iterdir()}

    def full(curve):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(picture, "png", full)
    with pytest.raises(ifa.IfaFileError, match="No space left"):
        report_of(*mixed).write(out)
    assert [path.name for path in tmp_path.iterdir()] == ["report"]
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_without_matplotlib_nothing_runs(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    package = sys.modules["ifa.tradeoff"]  # ifa.tradeoff is its function
    monkeypatch.setattr(package, "measure", lambda *a, **k: pytest.fail("it ran"))
    with pytest.raises(ifa.IfaError, match=r"pip install ifa\[plot\]"):
        ifa.tradeoff(ifa.bodies.get("ball"), BALL_MARKS, tmp_path / "report")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"knobs": ["engine"]}, "knobs: 'engine' is none of engine_step"),
        ({"knobs": "engine_step"}, "knobs: needs a sequence of names"),
        ({"repeats": 0}, "repeats: must be a whole number from 1"),
        ({"seed": -1}, "seed: must be a whole number"),
        ({"threads": 0}, "threads: must be a whole number"),
        ({"progress": 3}, "progress: needs an ifa.Progress"),
    ],
)
def test_bad_arguments_are_named(keywords, words):
    with pytest.raises(ifa.IfaValueError, match=re.escape(words)):
        ifa.tradeoff(ifa.bodies.get("ball"), BALL_MARKS, **keywords)


def test_a_knob_that_cannot_be_measured_says_why():
    hopeless = ifa.Signature([0.2, 0.2001, 0.2002], merge_gap_s=1e-5)
    body = ifa.Body.ball(0.02, mass_kg=0.01, restitution=0.0)
    report = ifa.tradeoff(body, hopeless, knobs=["float_width", "hull_detail"], repeats=1)
    by_knob = {curve.study.knob: curve for curve in report.curves}
    assert "too few vertices" in by_knob["hull_detail_contacts"].study.note
    assert by_knob["hull_detail_contacts"].points == ()


# End to end


def command(*words, **keywords):
    return subprocess.run(
        [sys.executable, "-m", "ifa.cli", "tradeoff", *map(str, words)],
        capture_output=True, text=True, **keywords,
    )  # fmt: skip


@pytest.fixture
def marks_file(tmp_path):
    path = tmp_path / "marks.json"
    BALL_MARKS.write(path)
    return path


def test_the_command_line(marks_file, tmp_path):
    pytest.importorskip("matplotlib")
    out = tmp_path / "report"
    done = command(
        "ball", marks_file, "-o", out, "--quick", "--knobs", "float_width,hull_detail",
        "--repeats", 1, "--json",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    content = json.loads(done.stdout)
    assert [curve["knob"] for curve in content["curves"]] == [
        "hull_detail_contacts", "hull_detail_mass", "float_width",
    ]  # fmt: skip
    assert content["circumstances"]["command"].startswith("ifa tradeoff ball ")
    assert "--knobs float_width,hull_detail" in content["circumstances"]["command"]
    written = json.loads((out / "tradeoff.json").read_text("utf-8"))
    assert written["curves"] == content["curves"]

    refused = command("ball", marks_file, "-o", tmp_path, "--knobs", "float_width")
    assert refused.returncode == 2 and "not of an earlier report" in refused.stderr
    unknown = command("ball", marks_file, "-o", out, "--knobs", "colour")
    assert unknown.returncode == 2 and "knobs: 'colour' is none of" in unknown.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupted_run_leaves_nothing(marks_file, tmp_path):
    pytest.importorskip("matplotlib")
    folder = tmp_path / "place"
    folder.mkdir()
    running = subprocess.Popen(
        [sys.executable, "-m", "ifa.cli", "tradeoff", "d6", marks_file, "-o", folder / "report",
         "--knobs", "engine_step", "--repeats", "500"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    for line in running.stderr:  # the meter's first line: it measures
        if "% after" in line:
            break
    running.send_signal(signal.SIGINT)
    _, errors = running.communicate(timeout=60)
    assert running.returncode == 4, errors
    assert "cancelled: nothing was written" in errors
    assert list(folder.iterdir()) == []
