"""The demo from end to end: a recording, its motion, pictures and a .blend."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import wave
from pathlib import Path

import ifa
import numpy as np
import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """The folder that the demo wrote, and what it printed."""
    pytest.importorskip("matplotlib")
    folder = tmp_path_factory.mktemp("demo")
    command = [sys.executable, EXAMPLES / "first_light.py", folder]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder, done.stdout


def test_it_writes_what_it_says(demo):
    folder, printed = demo
    written = {path.name for path in folder.iterdir()}
    named = {Path(line.split()[0]).name for line in printed.splitlines() if str(folder) in line}
    expected = {
        "roll.wav", "roll.txt", "motion.json", "certificate.json", "signature.png", "strobe.png",
    }  # fmt: skip
    assert expected <= written
    assert named - {"first_light.blend"} == expected
    assert not [name for name in written if name.endswith((".part", ".log"))]


def test_every_mark_stands_at_a_click_of_the_recording(demo):
    folder, _ = demo
    with wave.open(str(folder / "roll.wav")) as file:
        rate_hz = file.getframerate()
        samples = np.frombuffer(file.readframes(file.getnframes()), dtype="<i2") / 32768.0
    marks = ifa.Signature.read(folder / "roll.txt")
    assert np.abs(samples[: round(marks.times_s[0] * rate_hz) - 1]).max() == 0.0  # silence
    # A click begins sharply: the 2 ms after it hold more high frequency than those before.
    high = np.abs(np.diff(samples, 2))
    for time_s in marks.times_s:
        at, width = round(time_s * rate_hz), round(0.002 * rate_hz)
        assert high[at : at + width].max() > high[at - width : at - 2].max()


def test_the_motion_is_good_by_its_own_figures_and_by_the_verifier(demo):
    folder, _ = demo
    motion = json.loads((folder / "motion.json").read_text())
    assert motion["succeeded"] is True
    assert motion["score"] >= 0.5
    certificate = json.loads((folder / "certificate.json").read_text())
    assert certificate["passed"] is True
    again = ifa.verify(
        folder / "motion.json",
        ifa.bodies.get("d6", surface="wood"),
        ifa.Signature.read(folder / "roll.txt"),
    )
    assert again.passed


def test_with_a_blender_there_is_a_blend(demo):
    folder, printed = demo
    if shutil.which("blender") is None:
        pytest.skip("no blender on the PATH")
    assert (folder / "first_light.blend").stat().st_size > 100_000, printed
