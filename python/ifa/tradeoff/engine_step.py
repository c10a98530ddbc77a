"""The engines and their steps: how early or late a throw's later contact comes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from statistics import fmean

from ifa.tradeoff.curve import Scene, Setting, Study
from ifa.tradeoff.throws import (
    UNTIL_S,
    Reference,
    Simulation,
    Throws,
    event_simulation,
    measured,
    ode_simulation,
)

Engine = Callable[[float], Simulation]  # by its step, s

_CONTACT = 4  # errors have grown by then, and most throws have one
_STEPS_S = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
_QUICK_STEPS_S = (2e-3, 1e-3, 2e-4)
# By how much finer than the finest step the reference of each engine is.
_FINEST = {"event engine": 10, "ODE, flight exact": 4, "ODE, flight stepped": 4}
_EVENT = next(iter(_FINEST))


def engine_step(scene: Scene, *, quick: bool) -> Study:
    """Contact-time error of the event engine and of ODE against the converged event engine."""
    throws, steps_s, engines = _engines(scene, quick)
    finest_s = min(steps_s) / _FINEST[_EVENT]
    reference = Reference(throws, engines[_EVENT](finest_s))
    return _study(
        "engine_step",
        "Engine and step",
        steps_s,
        engines,
        dict.fromkeys(engines, reference),
        f"The reference is the event engine at {_step_name(finest_s)}"
        f"{_convergence(throws, reference, engines[_EVENT], finest_s)}. ODE solves impacts in "
        "another way, with friction in a box in place of a cone, which no step takes away.",
    )


def engine_step_own(scene: Scene, *, quick: bool) -> Study:
    """Contact-time error of each engine against itself at a much finer step."""
    throws, steps_s, engines = _engines(scene, quick)
    references = {
        name: Reference(throws, engine(min(steps_s) / _FINEST[name]))
        for name, engine in engines.items()
    }
    finest = ", ".join(
        f"{name} {_step_name(min(steps_s) / parts)}" for name, parts in _FINEST.items()
    )
    return _study(
        "engine_step_own",
        "Engine and step, each engine against itself",
        steps_s,
        engines,
        references,
        f"The reference is the same engine at a finer step: {finest}.",
    )


def _engines(scene: Scene, quick: bool) -> tuple[Throws, Sequence[float], dict[str, Engine]]:
    body = scene.body
    makers: tuple[Engine, ...] = (
        partial(event_simulation, body),
        partial(ode_simulation, body, flight="exact"),
        partial(ode_simulation, body, flight="stepped"),
    )
    engines = dict(zip(_FINEST, makers, strict=True))
    return (
        Throws(scene, 8 if quick else 40, _CONTACT),
        _QUICK_STEPS_S if quick else _STEPS_S,
        engines,
    )


def _study(
    knob: str,
    title: str,
    steps_s: Sequence[float],
    engines: Mapping[str, Engine],
    references: Mapping[str, Reference],
    note: str,
) -> Study:
    return Study(
        knob,
        title,
        f"error of contact {_CONTACT}, ms",
        tuple(
            Setting(_step_name(step_s), measured(references[name], engine(step_s)), name)
            for step_s in steps_s
            for name, engine in engines.items()
        ),
        "Mean over random throws, another set for each repeat, of how early or late audible "
        f"contact {_CONTACT} comes. The time is that of one simulation, to rest or {UNTIL_S:g} s. "
        + note,
    )


def _step_name(step_s: float) -> str:
    return f"{1e3 * step_s:g} ms"


def _convergence(throws: Throws, reference: Reference, engine: Engine, finest_s: float) -> str:
    """What the reference itself may be off by: its distance from the halvings that lead to it."""
    distances_ms = []
    for halvings in (1, 2):
        coarser = engine(finest_s * 2**halvings)
        pairs = zip(reference.of(0), Reference(throws, coarser).of(0), strict=True)
        errors_ms = [1e3 * abs(a - b) for a, b in pairs if a is not None and b is not None]
        if not errors_ms:
            return ""
        distances_ms.append(fmean(errors_ms))
    return (
        f", from which twice that step differs by {distances_ms[0]:.2g} ms and four times that "
        f"step by {distances_ms[1]:.2g} ms"
    )
