"""The effects of marks and of the search, on whole solves of scenes that call for each."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import ifa
from ifa import _core

from .measure import Row, in_turns

SEEDS = 5
ALL = "all of them"
# Near a ball's bounces, off by a few ms each, as marks set by ear are.
_BOUNCES = [0.30, 0.70, 1.02, 1.275, 1.48, 1.645]


@dataclass(frozen=True)
class _Scene:
    name: str
    body: str
    marks: ifa.Signature
    fit: bool = False


def _scenes() -> dict[str, _Scene]:
    times = [0.3, 0.55, 0.7]
    plain = ifa.Signature(times, ending="open")
    heard = ifa.Signature(times, amplitudes=[1.0, 0.6, 0.4], ending="open")
    span = ifa.Signature(times, durations_s=[0, 0, 0.15], centroids_s=[float("nan")] * 2 + [0.05])
    placed = [ifa.Position(k, (0.04 * k, 0.0)) for k in range(3)]
    posed = [ifa.Orientation(2, (0.0, 0.0, 1.0), (0.0, 0.0, 1.0))]
    open_d6 = _Scene("d6, 3 marks, open", "d6", plain)
    span_d6 = _Scene("d6, 3 marks, one a span", "d6", span)
    return {
        "sustained_contact": open_d6,
        "pre_roll_flight": open_d6,
        "settling_to_rest": _Scene("d6, 3 marks, rest", "d6", ifa.Signature(times)),
        "amplitude_matching": _Scene("d6, 3 marks with loudness, open", "d6", heard),
        "length_matching": span_d6,
        "centroid_matching": span_d6,
        "orientation_constraints": _Scene(
            "d6, 3 marks, one posed, open", "d6", plain.with_constraints(posed)
        ),
        "position_constraints": _Scene(
            "d6, 3 marks, all placed, open", "d6", plain.with_constraints(placed)
        ),
        "retiming": open_d6,
        "material_fit": _Scene("d6, 3 marks, fitted, open", "d6", plain, fit=True),
    }


def _solve(scene: _Scene, seed: int, forced: dict[str, bool]) -> dict[str, Any]:
    found: dict[str, Any] = _core.solve_forward(
        ifa.bodies.get(scene.body)._core,
        scene.marks._marks,
        seed=seed,
        time_budget_s=10.0,
        threads=1,
        fit_material=scene.fit,
        energy_gain_j=0.0,
        rung=0,
        contact=False,
        takes=1,
        lead_in_s=0.5,
        reuse=None,
        progress=None,
        forced=forced,
    )
    return found


def rows(repeats: int, seed: int) -> Iterator[Row]:
    """A scene that calls for few effects against all forced on, then one for each effect."""
    ball = _Scene("ball, 6 marks, open, no sound", "ball", ifa.Signature(_BOUNCES, ending="open"))
    every = dict.fromkeys(_core.EFFECTS, True)
    # A ball rolls for a minute before it rests; without that, what the others cost.
    unsettled = {name: on for name, on in every.items() if name != "settling_to_rest"}
    yield _row(ALL, ball, every, {}, repeats, seed)
    yield _row("all but settling", ball, unsettled, {}, repeats, seed)
    for effect, scene in _scenes().items():
        yield _row(effect, scene, {}, {effect: False}, repeats, seed)


def _row(
    effect: str,
    scene: _Scene,
    with_it: dict[str, bool],
    without_it: dict[str, bool],
    repeats: int,
    seed: int,
) -> Row:
    """Over several seeds: forcing an effect changes what a search happens to find."""
    times, scores, plausible = [], [], [0, 0]
    for s in range(seed, seed + SEEDS):
        found = [_solve(scene, s, forced) for forced in (with_it, without_it)]
        scores.append(found[0]["score"] - found[1]["score"])
        plausible = [n + f["plausible"] for n, f in zip(plausible, found, strict=True)]
        turns = [partial(_solve, scene, s, forced) for forced in (with_it, without_it)]
        times.append(in_turns(*turns, max(1, repeats // SEEDS)))
    with_s, without_s, ratios, _ = zip(*times, strict=True)
    quartiles = statistics.quantiles(ratios, n=4)
    return Row(
        effect,
        scene.name,
        statistics.median(with_s),
        statistics.median(without_s),
        statistics.median(ratios),
        quartiles[2] - quartiles[0],
        statistics.median(scores),
        f"of the Score (plausible {plausible[0]} of {SEEDS}, without it {plausible[1]})",
    )
