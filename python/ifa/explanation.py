"""Why marks cannot be met as asked, and which changes would help, each tried beforehand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ifa import _core, arguments, constraints
from ifa._core import IfaValueError
from ifa.body import Body
from ifa.marks import Signature
from ifa.solution import Solution


@dataclass(frozen=True)
class Conflict:
    """A mark that the best motion does not meet as it should.

    mark: its index, from 0. name: as messages call it, "mark 7 (1.25 s)". kind: "missed" (no motion
    got there), "implausible" (an impact is changed beyond the plausible region), "retimed" (by more
    than 7 %), "unrest" (the body does not come to rest after it), "sound" (it lowers the Score too
    much) or "penetration". text: the reason, without the name; `str()` gives both. finding: what
    `ifa.estimate` says about the same mark, once; else None.
    """

    mark: int
    name: str
    kind: str
    text: str
    finding: str | None

    def __str__(self) -> str:
        return f"{self.name}: {self.text}"


@dataclass(frozen=True)
class Repair:
    """A change that works: `ifa.solve(r.body, r.marks, **r.options)` is the solve that says so.

    kind: "shift", "drop", "energy", "restitution", "friction" or "ending". mark: the index, from 0,
    of the mark that is shifted or dropped, after which nothing is asked, or at which energy lacks;
    None for a material. amount, unit: the change, in "s", "J" or "mark", or a plain number (unit
    "") for a material; 1 for a drop or an ending. cost: CONVENTIONS.md defines it; 1 is about what
    retiming could hide. text: a sentence; `str()` adds how good the motion is. plausible: else it
    just succeeded. score: of that motion. body, marks, energy_gain_j, material, seed, rung: what
    was solved.
    """

    kind: str
    mark: int | None
    amount: float
    unit: str
    cost: float
    text: str
    plausible: bool
    score: float
    body: Body
    marks: Signature
    energy_gain_j: float
    material: str
    events: str
    seed: int
    rung: int

    @property
    def options(self) -> dict[str, Any]:
        """The keywords of `ifa.solve` that reproduce the motion."""
        return {
            "energy_gain_j": self.energy_gain_j,
            "material": self.material,
            "events": self.events,
            "seed": self.seed,
            "rung": self.rung,
        }

    def to_dict(self) -> dict[str, Any]:
        """Everything, JSON-ready; of the body its restitution and friction."""
        out = dict(vars(self))
        del out["body"]
        out["restitution"] = self.body.restitution
        out["friction"] = self.body.friction
        out["marks"] = self.marks.to_dict()
        return out

    def __str__(self) -> str:
        verdict = "plausible" if self.plausible else "succeeds, not plausible"
        return f"{self.text} ({verdict}, score {self.score:.2f})"


@dataclass(frozen=True)
class Explanation:
    """What is wrong with marks, and the repairs that were tried and work.

    succeeded, plausible: of the best motion as asked. conflicts: in the order of the marks, empty
    if it is plausible. repairs: plausible ones first, then by cost. trials: how many solves of
    repairs were made. complete: False where the time budget ended them, so that there may be more
    and smaller repairs.
    """

    succeeded: bool
    plausible: bool
    conflicts: list[Conflict]
    repairs: list[Repair]
    trials: int
    complete: bool

    def to_dict(self) -> dict[str, Any]:
        """What `ifa explain --json` prints: everything, JSON-ready."""
        out = dict(vars(self))
        out["conflicts"] = [vars(conflict) for conflict in self.conflicts]
        out["repairs"] = [repair.to_dict() for repair in self.repairs]
        out["version"] = _core.__version__
        return out


def explain(
    body: Body,
    marks: Signature,
    *,
    solution: Solution | None = None,
    material: str = "given",
    energy_gain_j: float = 0.0,
    seed: int = 0,
    time_budget_s: float = 10.0,
    threads: int | None = None,
    events: str = "audible",
    progress: _core.Progress | None = None,
) -> Explanation:
    """Say which marks keep a motion of `body` from being plausible, and what changes would help.

    The repairs: shift a conflicting mark or a neighbour of it, by whole milliseconds (amplitude and
    duration go with it), drop one, let a contact add energy, another restitution or friction
    (unless material="fit"), an open ending where the body does not come to rest. Each kind is tried
    from small to large, and the smallest size that gives a plausible motion, or else one that
    succeeds where none did as asked, is then narrowed down: to 1 ms, a tenth of the energy, 0.01 of
    a material's number. All are solved on rung 0, and on
    rung 1 if none was plausible there: a harder search may do with less.

    solution: of the same marks and options, no effect forced, where there is one; else rungs 0 to 2
    say how well they can be met. time_budget_s: once it is over no further trial begins, and none
    of those rungs after a tenth of it; what has begun is finished. The other arguments are those of
    `ifa.solve`. The same arguments give the same explanation for any
    number of threads, as long as it is `complete`. Raises IfaValueError naming the argument or the
    mark, Cancelled.

    Example:
        >>> ball = Body.ball(0.02, mass_kg=0.01, restitution=0.4)
        >>> marks = Signature([0.2, 0.3, 0.35], ending="open")
        >>> explanation = explain(ball, marks, time_budget_s=60.0)
        >>> explanation.plausible, [str(conflict) for conflict in explanation.conflicts]
        (True, [])
    """
    if not isinstance(body, Body):
        raise IfaValueError("body: needs an ifa.Body")
    if not isinstance(marks, Signature):
        raise IfaValueError("marks: needs an ifa.Signature")
    arguments.one_of(events, "events", "audible", "contact")
    arguments.one_of(material, "material", "given", "fit")
    arguments.check_progress(progress)
    gain_j = arguments.number(energy_gain_j, "energy_gain_j")
    if not 0.0 <= gain_j < float("inf"):
        raise IfaValueError(f"energy_gain_j: must be finite and 0 or more, got {gain_j:g}")
    if solution is not None:
        _check_solution(solution, body, marks, gain_j, events, material)
    seed = arguments.whole(seed, "seed", 2**64 - 1)
    found = _core.explain(
        body._core,
        marks._marks,
        solution=None if solution is None else solution.to_dict(),
        merge_gap_s=marks._merge_gap_s,
        seed=seed,
        time_budget_s=arguments.positive(time_budget_s, "time_budget_s"),
        threads=arguments.threads(threads),
        fit_material=material == "fit",
        energy_gain_j=gain_j,
        contact=events == "contact",
        progress=progress,
    )
    repairs = []
    for repair in found.pop("repairs"):
        restitution, friction = repair.pop("restitution"), repair.pop("friction")
        repaired = body.replace(restitution=restitution, friction=friction)
        new = repair.pop("marks")
        new_marks = Signature(
            new.times_s,
            new.durations_s,
            new.amplitudes,
            new.centroids_s,
            new.ending,
            merge_gap_s=marks._merge_gap_s,
            constraints=constraints.from_core(new),
        )
        repairs.append(
            Repair(
                body=repaired,
                marks=new_marks,
                material=material,
                events=events,
                seed=seed,
                **repair,
            )
        )
    conflicts = [Conflict(**conflict) for conflict in found.pop("conflicts")]
    return Explanation(conflicts=conflicts, repairs=repairs, **found)


def _check_solution(
    solution: Any, body: Body, marks: Signature, gain_j: float, events: str, material: str
) -> None:
    if not isinstance(solution, Solution):
        raise IfaValueError(f"solution: needs an ifa.Solution or None, got {solution!r}")
    fitted = material == "fit"
    if solution.effects.forced:
        raise IfaValueError("solution: was made with effects forced, which repairs are not")
    if solution.effects["material_fit"].on != fitted:
        raise IfaValueError(f'solution: was not made with material "{material}"')
    given = {"restitution": body.restitution, "friction": body.friction} if fitted else {}
    if solution.body.replace(**given).to_dict() != body.to_dict():
        raise IfaValueError("solution: was made for another body")
    if solution.marks != marks:
        raise IfaValueError("solution: was made for other marks")
    if solution.energy_gain_j != gain_j:
        raise IfaValueError(
            f"solution: was made with energy_gain_j {solution.energy_gain_j:g}, not {gain_j:g}"
        )
    if solution.motion.hearing["events"] != events:
        raise IfaValueError(
            f'solution: was made with events "{solution.motion.hearing["events"]}", not "{events}"'
        )
