"""Which effects a solve simulates and weighs: planned from marks, body and options before it."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ifa import _core, arguments
from ifa import constraints as poses
from ifa._core import IfaValueError
from ifa.body import Body
from ifa.constraints import Constraint
from ifa.effect_costs import Cost, recorded
from ifa.marks import Signature
from ifa.table import table

EFFECTS: tuple[str, ...] = tuple(_core.EFFECTS)
"""The names of all effects, in the order of every plan; CONVENTIONS.md says what each is."""


@dataclass(frozen=True)
class EffectState:
    """Whether one effect is on, and because of what; it counts as true where it is on.

    forced: the caller decided that. because: what the scene says of it, a clause, also where it is
    forced. cost: what it costs where a scene needs it; None where that was not measured. runs: how
    often its code ran in the whole solve, 0 where it is off; None before a solve.
    """

    name: str
    on: bool
    forced: bool
    because: str
    cost: Cost | None = None
    runs: int | None = None

    def __bool__(self) -> bool:
        return self.on

    @property
    def title(self) -> str:
        """The name in words."""
        return self.name.replace("pre_roll", "pre-roll").replace("_", " ")

    @property
    def decision(self) -> str:
        """One of "on", "off", "forced on" and "forced off"."""
        return ("forced " if self.forced else "") + ("on" if self.on else "off")

    def to_dict(self) -> dict[str, Any]:
        """`on`, `forced`, `because`, `cost` (null: not measured), `runs` after a solve."""
        out: dict[str, Any] = {"on": self.on, "forced": self.forced, "because": self.because}
        if self.runs is not None:
            out["runs"] = self.runs
        out["cost"] = None if self.cost is None else dict(vars(self.cost))
        return out


class Plan(Mapping[str, EffectState]):
    """Every effect by its name, in the order of `ifa.EFFECTS`: which are on, and which are off.

    `str()` gives a table, `line()` one line.
    """

    def __init__(self, found: Iterable[Mapping[str, Any]], plan_s: float | None = None) -> None:
        """Wrap what the core planned; plans come from `ifa.plan` and `solution.effects`."""
        costs = recorded().costs
        self._states = {e["name"]: EffectState(cost=costs.get(e["name"]), **e) for e in found}
        #: How long `ifa.plan` took, s; None of a solve, whose `solve_s` holds it.
        self.plan_s = plan_s

    def __getitem__(self, name: str) -> EffectState:
        return self._states[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._states)

    def __len__(self) -> int:
        return len(self._states)

    @property
    def on(self) -> tuple[str, ...]:
        """The names of those that are on."""
        return tuple(name for name, state in self.items() if state.on)

    @property
    def off(self) -> tuple[str, ...]:
        """The names of those that are off."""
        return tuple(name for name, state in self.items() if not state.on)

    @property
    def forced(self) -> dict[str, bool]:
        """Those that the caller forced: what `effects=` was."""
        return {name: state.on for name, state in self.items() if state.forced}

    def to_dict(self) -> dict[str, dict[str, Any]]:
        """Of each effect `on`, `forced`, `because`, `cost`, `runs`; JSON-ready.

        `plan_s` is not there: like all else but `solve_s`, it is the same in every run.
        """
        return {name: state.to_dict() for name, state in self.items()}

    def line(self) -> str:
        """One line: "on: friction, retiming; off: spin coupling (its moments are equal)"."""
        on = ", ".join(f"{e.title} (forced)" if e.forced else e.title for e in self.values() if e)
        off = ", ".join(
            f"{e.title} ({'forced' if e.forced else e.because})" for e in self.values() if not e
        )
        return f"on: {on or 'none'}; off: {off or 'none'}"

    def __str__(self) -> str:
        ran = any(state.runs is not None for state in self.values())
        rows = [("effect", "", *(["runs"] if ran else []), "cost", "because")]
        for e in self.values():
            runs = [f"{e.runs or 0:,}"] if ran else []
            cost = "not measured" if e.cost is None else str(e.cost)
            rows.append((e.title, e.decision, *runs, cost, e.because))
        lines = table(rows, align="<<><<" if ran else "<<<<")
        if source := recorded().source:
            lines += [
                "cost: time with over time without, median +- quartile spread, on a scene that "
                f"needs it ({source})"
            ]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<ifa.Plan {self.line()}>"


def plan(
    body: Body,
    marks: Signature,
    *,
    events: str = "audible",
    material: str = "given",
    lead_in_s: float = 0.5,
    constraints: Sequence[Constraint] = (),
    method: str = "forward",
    effects: Mapping[str, bool] | None = None,
) -> Plan:
    """Say which effects a solve with these arguments simulates and weighs, and because of what.

    The arguments are those of `ifa.solve`, which plans the same. It searches nothing and takes well
    below a millisecond. Raises IfaValueError naming the argument or the mark.

    Example:
        >>> ball = Body.ball(0.02, mass_kg=0.01)
        >>> plan(ball, Signature([0.2, 0.3, 0.35], ending="open"))["spin_coupling"].on
        False
    """
    began = time.perf_counter()
    marks = checked_marks(
        body, marks, method=method, events=events, material=material, constraints=constraints
    )
    found = _core.plan(
        body._core,
        marks._marks,
        contact=events == "contact",
        fit_material=material == "fit",
        lead_in_s=arguments.positive(lead_in_s, "lead_in_s"),
        method_graph=method == "graph",
        forced=forced_effects(effects),
    )
    return Plan(found, time.perf_counter() - began)


def checked_marks(
    body: Any,
    marks: Any,
    *,
    method: Any,
    events: Any,
    material: Any,
    constraints: Any,
) -> Signature:
    """`marks` with `constraints` beside their own, once all of these are what a solve takes."""
    if not isinstance(body, Body):
        raise IfaValueError("body: needs an ifa.Body")
    if not isinstance(marks, Signature):
        raise IfaValueError("marks: needs an ifa.Signature")
    arguments.one_of(method, "method", "forward", "graph")
    arguments.one_of(events, "events", "audible", "contact")
    arguments.one_of(material, "material", "given", "fit")
    asked = poses.sequence(constraints)
    return marks.with_constraints(asked) if asked else marks


def forced_effects(effects: Any) -> dict[str, bool]:
    """The argument `effects`: names of effects that the caller forces on or off."""
    if effects is None:
        return {}
    if not isinstance(effects, Mapping):
        raise IfaValueError(f"effects: must map names of effects to True or False, got {effects!r}")
    for name, on in effects.items():
        if name not in EFFECTS:
            raise IfaValueError(f"effects: there is no {name!r}; there are {', '.join(EFFECTS)}")
        if not isinstance(on, bool | np.bool_):
            raise IfaValueError(f"effects: {name} must be True or False, got {on!r}")
    return {name: bool(on) for name, on in effects.items()}
