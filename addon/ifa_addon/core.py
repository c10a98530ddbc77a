# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the core package `ifa` and hands one solve to it. No bpy: it runs in a worker thread."""

from __future__ import annotations

import hashlib
import importlib
import os
import re
import sys
import tempfile
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

BUNDLED = Path(__file__).with_name("wheels_unpacked")  # of the zip for Blender before 4.2

EXPLAIN_BUDGET_S = 10.0  # for repairs, where no time is given

_added_paths: list[str] = []


class CoreMissing(Exception):
    """The package `ifa` cannot be imported; the message says why and what to do."""


def add_path(path: str) -> None:
    """Let Python look for `ifa` in `path` last of all: Blender's own numpy must win."""
    if path and path not in sys.path:
        sys.path.append(path)
        _added_paths.append(path)
        importlib.invalidate_caches()


def remove_paths() -> None:
    while _added_paths:
        path = _added_paths.pop()
        if path in sys.path:
            sys.path.remove(path)


def load(extra_path: str = "") -> ModuleType:
    """The package `ifa`, looked for in IFA_PYTHONPATH, `extra_path` and BUNDLED last.

    Raises CoreMissing.
    """
    for entry in [*os.environ.get("IFA_PYTHONPATH", "").split(os.pathsep), extra_path]:
        add_path(entry)
    if BUNDLED.is_dir():
        add_path(str(BUNDLED))
    try:
        module = importlib.import_module("ifa")
        # A folder of that name on the path would import as an empty namespace package.
        for name in ("solve", "Body", "Signature", "Progress"):
            getattr(module, name)
    except Exception as error:  # whatever a broken package raises, the panel must still draw
        raise CoreMissing(
            "The package ifa is not installed for Blender's Python "
            f"{sys.version_info.major}.{sys.version_info.minor}: set its folder in the add-on's "
            f"preferences or in IFA_PYTHONPATH ({error})"
        ) from error
    return module


@dataclass(frozen=True)
class Inputs:
    """Everything one solve depends on, as plain data read from the scene on the main thread."""

    name: str
    vertices_m: np.ndarray  # (n, 3), in the object's axes with its world scale applied
    triangles: np.ndarray  # (m, 3) int
    material_keywords: dict[str, float]  # density or mass_kg, restitution, friction
    mark_names: tuple[str, ...]
    mark_times_s: tuple[float, ...]  # from the time origin (the sound's start where there is one)
    ending: str
    material: str
    seed: int
    time_budget_s: float | None  # None: that of the accuracy
    accuracy: str = "good"
    takes: int = 1
    energy_gain_j: float = 0.0
    sound_path: str = ""
    sound_bytes: bytes = field(default=b"", repr=False)  # of a sound packed into the .blend

    def digest(self) -> str:
        """Changes with anything that would change the motion: no stale one is written."""
        state = hashlib.sha256()
        for entry in fields(self):
            value = getattr(self, entry.name)
            state.update(entry.name.encode())
            if isinstance(value, np.ndarray):
                state.update(np.ascontiguousarray(value).tobytes())
            else:
                state.update(value if isinstance(value, bytes) else repr(value).encode())
        return state.hexdigest()

    def but_for_marks(self) -> str:
        """A digest of all else: an earlier solve can be gone on from where it agrees."""
        return replace(self, mark_names=(), mark_times_s=()).digest()


@dataclass(frozen=True)
class Outcome:
    """A solved motion with what is needed to write and report it."""

    solution: Any
    centre_of_mass_m: np.ndarray  # in the object's scaled axes
    mark_names: tuple[str, ...]
    notes: tuple[str, ...] = ()


def problem(ifa: ModuleType, inputs: Inputs) -> tuple[Any, Any]:
    """The body and the marks of the core; raises ifa.IfaError."""
    body = ifa.Body.from_triangles(
        inputs.vertices_m, inputs.triangles, name=inputs.name, **inputs.material_keywords
    )
    marks = ifa.Signature(np.array(inputs.mark_times_s, dtype=np.float64), ending=inputs.ending)
    if inputs.sound_bytes:
        with tempfile.TemporaryDirectory(prefix="ifa-") as folder:
            path = Path(folder) / Path(inputs.sound_path).name
            path.write_bytes(inputs.sound_bytes)
            marks = marks.with_sound(str(path))
    elif inputs.sound_path:
        marks = marks.with_sound(inputs.sound_path)
    return body, marks


def solve(ifa: ModuleType, inputs: Inputs, progress: object, reuse: Any = None) -> Outcome:
    """Blocks until solved; raises ifa.IfaError (ifa.Cancelled after progress.cancel()).

    `reuse`: the solution of the same body and options whose marks have moved a little since.
    """
    body, marks = problem(ifa, inputs)
    solution = ifa.solve(
        body,
        marks,
        seed=inputs.seed,
        time_budget_s=inputs.time_budget_s,
        material=inputs.material,
        accuracy=inputs.accuracy,
        energy_gain_j=inputs.energy_gain_j,
        takes=inputs.takes,
        progress=progress,
        reuse=reuse,
    )
    return Outcome(
        solution,
        np.asarray(body.centre_of_mass_m, dtype=np.float64),
        inputs.mark_names,
        tuple(str(note) for note in body.notes),
    )


def predict(ifa: ModuleType, inputs: Inputs, progress: object) -> dict[str, Any]:
    """An ifa.Prediction for each accuracy, from one calibration of a second at most."""
    body, marks = problem(ifa, inputs)
    options = {} if inputs.time_budget_s is None else {"time_budget_s": inputs.time_budget_s}
    return ifa.predict_all(
        body,
        marks,
        material=inputs.material,
        energy_gain_j=inputs.energy_gain_j,
        seed=inputs.seed,
        progress=progress,
        **options,
    )


def explain(ifa: ModuleType, inputs: Inputs, progress: object) -> Any:
    """The ifa.Explanation of why these marks are not met, and the repairs that work."""
    body, marks = problem(ifa, inputs)
    return ifa.explain(
        body,
        marks,
        material=inputs.material,
        energy_gain_j=inputs.energy_gain_j,
        seed=inputs.seed,
        time_budget_s=inputs.time_budget_s or EXPLAIN_BUDGET_S,
        progress=progress,
    )


def readable(error: Exception, mark_names: tuple[str, ...]) -> str:
    """The core's sentence, with the markers' names for its numbers of marks (from 1)."""

    def name(match: re.Match) -> str:
        number = int(match.group(1))
        return f"mark '{mark_names[number - 1]}'" if 1 <= number <= len(mark_names) else match[0]

    return re.sub(r"\bmark (\d+)\b", name, str(error)) or type(error).__name__


def describe(solution: Any, mark_names: tuple[str, ...]) -> str:
    """One sentence for the panel and the report; a failure names its marks."""
    worst_ms = 1e3 * float(solution.max_abs_error_s)
    figures = f"score {solution.score:.2f}, worst error {worst_ms:.2f} ms"
    if solution.succeeded:
        return f"Solved: {figures}, {'plausible' if solution.plausible else 'not plausible'}"
    report = importlib.import_module("ifa.report")
    reasons = report.shortcomings(solution, mark_names, open_ending="Ending: Open")
    return f"No acceptable motion: {'; '.join(reasons)} ({figures}); the best one found is keyed"
