"""The example of a batch: what it prints."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "batch.py"


def test_a_cube_rests_on_each_face_alike():
    throws = 2000
    command = [sys.executable, EXAMPLE, str(throws)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert f"{throws} throws of a d6, {throws} at rest" in done.stdout
    shares = [float(s) / 100 for s in re.findall(r"up +([0-9.]+)%", done.stdout)]
    assert len(shares) == 6
    # chi-squared of 5 degrees of freedom is above 25.7 once in 10,000; a die that prefers a face
    # by a quarter (0.208 against 0.158) has 30 on average. Rounding to 0.1 % moves it by some 0.1.
    assert throws * sum((share - 1 / 6) ** 2 for share in shares) / (1 / 6) < 25.7
    assert "; 0.00% failed, 0.00% not at rest" in done.stdout


def test_the_face_that_is_up():
    face_up = runpy.run_path(str(EXAMPLE))["face_up"]
    half = np.sqrt(0.5)
    # a quarter turn about x brings y up, about -x brings -y up; about y it is -x, about -y it is x
    turns = [(1, 0, 0, 0), (half, half, 0, 0), (half, -half, 0, 0), (half, 0, half, 0)]
    turns += [(half, 0, -half, 0), (0, 1, 0, 0)]
    names = runpy.run_path(str(EXAMPLE))["FACES"]
    assert [names[i] for i in face_up(np.array(turns))] == ["+z", "+y", "-y", "-x", "+x", "-z"]
