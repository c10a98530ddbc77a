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
# Which body calls for the effect, and until when: a few impacts, but for what follows them.
_SCENES = {
    "spin_coupling": ("eraser", 0.5),
    "friction": ("d6", 0.5),
    "sustained_contact": ("d6", 10.0),
    "rounding": ("d6", 0.5),
    "circular_edges": ("coin", 0.5),
}


def rows(simulations: int, repeats: int, seed: int) -> Iterator[Row]:
    """One for each effect of the engine."""
    for effect, (name, until_s) in _SCENES.items():
        body = ifa.bodies.get(name)
        states = ifa.sample_states(body, simulations, seed)
        effects = {each: each != effect for each in _OF_BODY}
        with_it = partial(_run, body._core, states, until_s, True)
        without_it = partial(
            _run, body._core.with_effects(**effects), states, until_s, effect != "sustained_contact"
        )
        times = in_turns(with_it, without_it, repeats)
        scene = f"{name}, {simulations} throws, {until_s:g} s"
        yield Row(effect, scene, *times, *_error(effect, with_it(), without_it()))


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
