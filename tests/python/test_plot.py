"""Pictures: what they show is where it belongs, and drawing fails with a sentence."""

from __future__ import annotations

import subprocess
import sys

import ifa
import numpy as np
import pytest
from ifa import plot
from ifa.sound import write_wav

TIMES_S = (0.20, 0.29, 0.34, 0.37, 0.402, 0.418, 0.445, 0.465)
MARK_RED = np.array([0xD1, 0x49, 0x5B]) / 255.0


@pytest.fixture(scope="module")
def solution():
    return ifa.solve(ifa.bodies.get("d6", surface="wood"), ifa.Signature(TIMES_S), rung=0)


def red_strokes(picture, rows):
    """How many separate runs of columns are mark red in all of the rows."""
    from matplotlib.image import imread

    pixels = imread(picture)[:, :, :3]
    top, bottom = (round(share * len(pixels)) for share in rows)
    near = np.abs(pixels[top:bottom] - MARK_RED).max(axis=2) < 0.25  # edges are antialiased
    columns = near.all(axis=0)
    return int(np.count_nonzero(np.diff(columns.astype(int), prepend=0) == 1))


def test_a_signature_has_a_stroke_for_each_mark(solution, tmp_path):
    pytest.importorskip("matplotlib")
    plot.plot_solution(solution, path=tmp_path / "signature.png")
    # of the rows, a band in the upper panel
    assert red_strokes(tmp_path / "signature.png", (0.2, 0.3)) == len(TIMES_S)


def test_a_signature_with_sound_shows_it(solution, tmp_path):
    pytest.importorskip("matplotlib")
    rate_hz = 8000
    samples = 0.5 * np.sin(2 * np.pi * 100 * np.arange(rate_hz) / rate_hz)
    write_wav(tmp_path / "tone.wav", samples, rate_hz)
    plot.plot_solution(solution, tmp_path / "tone.wav", tmp_path / "with.png")
    plot.plot_solution(solution, None, tmp_path / "without.png")
    assert (tmp_path / "with.png").read_bytes() != (tmp_path / "without.png").read_bytes()


def test_a_strobe_has_a_stroke_for_each_mark(solution, tmp_path):
    pytest.importorskip("matplotlib")
    plot.plot_strobe(solution, tmp_path / "strobe.png")
    # a band of the lower panel, below the legend and above the curves' last part
    assert red_strokes(tmp_path / "strobe.png", (0.69, 0.72)) == len(TIMES_S)


def test_the_lowest_point_touches_the_ground_at_each_hit(solution):
    at_s = [event.achieved_s for event in solution.events]
    _, lowest_m, _ = plot._heights(solution.body, *solution.motion.sample(at_s))
    # a hit is where the gap is 0; succeeded motions go no deeper than 0.1 mm
    assert np.abs(lowest_m).max() < 1e-4


def test_outlines_of_a_ball_and_a_box_are_a_circle_and_a_rectangle():
    along = np.array([1.0, 0.0])
    turned = np.array([np.cos(0.4), 0.0, np.sin(0.4), 0.0])
    ball = ifa.Body.ball(0.02, mass_kg=0.1)
    circle = plot._outline(ball, np.array([1.0, 2.0, 3.0]), turned, along)
    distances = np.linalg.norm(circle - [1.0, 3.0], axis=1)
    np.testing.assert_allclose(distances, 0.02, rtol=1e-12)
    box = ifa.Body.box([0.1, 0.2, 0.3], mass_kg=0.1)
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    outline = plot._outline(box, np.zeros(3), upright, along)
    corners = {(x, z) for x in (-0.05, 0.05) for z in (-0.15, 0.15)}
    assert {tuple(np.round(point, 12)) for point in outline} == corners


def test_rotations_turn_as_the_quaternion_does():
    # a quarter turn about z takes x to y, then one about x takes y to z
    half = np.sqrt(0.5)
    about_z, about_x = plot._rotations(np.array([[half, 0, 0, half], [half, half, 0, 0]]))
    np.testing.assert_allclose(about_z @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(about_x @ [0, 1, 0], [0, 0, 1], atol=1e-15)


@pytest.mark.parametrize("name", ["gone/picture.png", "picture.abc"])
def test_a_picture_that_cannot_be_written_is_named(name, solution, tmp_path):
    pytest.importorskip("matplotlib")
    with pytest.raises(ifa.IfaFileError, match=name.replace("/", ".")):
        plot.plot_strobe(solution, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_without_matplotlib_the_error_says_what_to_install(solution, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(ifa.IfaError, match="matplotlib"):
        plot.plot_solution(solution, path=tmp_path / "picture.png")


def test_matplotlib_is_loaded_only_to_draw():
    code = "import sys, ifa.cli, ifa.plot; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
