"""The engine's effects, on batches of random throws of a body that calls for each."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import ifa
import numpy as np
from ifa import _core
from ifa.simulation import GRAVITY_M_S2, state_arrays

from .measure import Row, in_turns

_OF_BODY = ("spin_coupling", "friction", "rounding", "circular_edges")
_FEW_IMPACTS_S, _TO_REST_S = 0.5, 10.0
# Which body calls for the effect, and what is timed. Of friction the first impact alone, with which
# the throws begin: the flights that follow without it are others, and may take longer.
_SCENES = {
    "spin_coupling": ("eraser", _FEW_IMPACTS_S),
    "friction": ("d6", 1e-6),
    "sustained_contact": ("d6", _TO_REST_S),
    "rounding": ("d6", _FEW_IMPACTS_S),
    "circular_edges": ("coin", _FEW_IMPACTS_S),
}


def rows(simulations: int, repeats: int, seed: int) -> Iterator[Row]:
    """One for each effect of the engine."""
    for effect, (name, until_s) in _SCENES.items():
        body = ifa.bodies.get(name)
        states = ifa.sample_states(body, simulations, seed)
        effects = {each: each != effect for each in _OF_BODY}
        reduced, steps = body._core.with_effects(**effects), effect != "sustained_contact"
        times = in_turns(
            partial(_run, body._core, states, until_s, True),
            partial(_run, reduced, states, until_s, steps),
            repeats,
        )
        compared_s = max(until_s, _FEW_IMPACTS_S)
        full = _run(body._core, states, compared_s, True)
        without = _run(reduced, states, compared_s, steps)
        scene = f"{name}, {simulations} throws, {until_s:g} s"
        yield Row(effect, scene, *times, *_error(effect, full, without))


def _run(core: Any, states: ifa.State, until_s: float, sustained_contact: bool) -> ifa.Batch:
    out = ifa.Batch.allocate(len(states), 8)
    _core.simulate_batch(
        [core],
        *state_arrays(states),
        step_s=1e-3,
        until_s=until_s,
        gravity_m_s2=np.array([0.0, 0.0, -GRAVITY_M_S2]),
        hits=8,
        threads=1,
        instruction_set="",
        out=vars(out),
        progress=None,
        sustained_contact=sustained_contact,
    )
    return out


def _error(effect: str, full: ifa.Batch, without: ifa.Batch) -> tuple[float, str]:
    if effect == "sustained_contact":
        missing = np.median(full.end_time_s - without.end_time_s)
        return 1e3 * float(missing), "ms of motion are missing (median)"
    third = (full.hit_count >= 3) & (without.hit_count >= 3)
    if not third.any():
        return float("nan"), "ms: no throw has three hits"
    apart = np.abs(full.hit_time_s[third, 2] - without.hit_time_s[third, 2])
    return 1e3 * float(np.median(apart)), "ms at the third hit (median)"
