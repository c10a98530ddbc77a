"""Solving: from a body and marks to a motion whose contacts land on the marks."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ifa import _core, arguments
from ifa import accuracy as accuracies
from ifa import constraints as poses
from ifa._core import IfaValueError
from ifa.accuracy import Accuracy
from ifa.body import Body
from ifa.constraints import Constraint
from ifa.database import Database
from ifa.effects import Plan, checked_marks, forced_effects
from ifa.marks import HEARING, Signature
from ifa.solution import Event, Motion, Prediction, Solution, Stage

CLEARLY_DIFFERENT: float = _core.CLEARLY_DIFFERENT
"""How much takes differ at least: `Motion.difference` from the first to the last mark."""

MOST_TAKES = 1000  # of one solve

EXPERT: dict[str, dict[str, int]] = {  # by method: names, and the least value
    "forward": {"roots": 1, "variants": 0},
    "graph": {"states": 1, "neighbours": 1, "children": 1},
}


def solve(
    body: Body,
    marks: Signature,
    *,
    method: str = "forward",
    events: str = "audible",
    seed: int = 0,
    accuracy: str | Accuracy = "good",
    time_budget_s: float | None = None,
    threads: int | None = None,
    material: str = "given",
    energy_gain_j: float = 0.0,
    takes: int = 1,
    constraints: Sequence[Constraint] = (),
    progress: _core.Progress | None = None,
    rung: int | None = None,
    lead_in_s: float = 0.5,
    reuse: Solution | None = None,
    database: Database | str | os.PathLike[str] | None = None,
    search: str = "exact",
    expert: Mapping[str, int] | None = None,
    prediction: Prediction | None = None,
    effects: Mapping[str, bool] | None = None,
) -> Solution:
    """Find a motion of `body` whose audible hits land on `marks`.

    Args:
        body: What moves.
        marks: When its contacts happen.
        method: "forward", which needs no preparation, or "graph", the paper's: it searches a
            `database` of the body.
        events: "audible": marks are hits that sound, between them the body may fly or stay in
            silent contact. "contact": marks are intervals of contact, between them it flies (paper
            section 4).
        seed: Of the random numbers: another one finds another motion.
        accuracy: "draft" climbs until a motion has succeeded, "good" until one is plausible, "best"
            goes on and keeps the best (`ifa.ACCURACIES`); or an `ifa.Accuracy` of one's own. For
            method="forward".
        time_budget_s: The search climbs a ladder of rungs until a motion is as `accuracy` asks; a
            rung that the budget leaves too little time for is not begun, and one begun is finished.
            None: that of `accuracy`.
        threads: 1 or more, None is one for each core; the result does not depend on it.
        material: "given" keeps the body's restitution and friction, "fit" chooses them.
        energy_gain_j: How much a contact may add to the energy, J.
        takes: So many motions are looked for that are clearly different: by CLEARLY_DIFFERENT body
            radii or more. `solution.takes` has them, which may be fewer.
        constraints: `ifa.Orientation` and `ifa.Position`, beside those that the marks have: which
            side of the body points where, and where on the ground it is, at marks or at rest (paper
            section 6). Their factors count in the search like all others; where the best motion is
            plausible but does not meet them, the ladder is climbed on. `solution.constraints` says
            how each was met.
        progress: Read its `fraction` and call its `cancel()` from another thread.
        rung: Run just this one of the ladder of `accuracy`, so that the result depends on no clock:
            the same seed and rung give the same motion, byte for byte.
        lead_in_s: How long the motion flies before the first mark, s; less where an earlier contact
            comes, or the sound begins later than that.
        reuse: An earlier solution of the same body and options. What its marks and these have in
            common from the start is gone on from, so that a nudged mark takes little time. With
            `rung`, on rungs up to that one.
        database: For method="graph": an `ifa.Database`, or its folder, of this body and these
            `events`. Its transitions are made by the first solve, if `Database.prepare` has not.
        search: For method="graph": "exact", the best path of the graph (to a bound that
            `solution.search` states), or "branch_and_bound", the paper's search (section 5.5),
            which looks five events ahead and stops at a Score of 0.3.
        expert: Sizes inside the searches, to measure what they cost (`ifa tradeoff`); None and what
            is left out is what was found best. Of "forward": `roots`, how many changes that meet
            the next mark are sought for each state, and `variants` of each. Of "graph": `states` of
            a layer of the exact search, `neighbours`, the transitions of a node that it looks at,
            and `children` of a node in branch and bound.
        prediction: What `ifa.predict` has said of this solve; the solution carries it.
        effects: Names of `ifa.EFFECTS` that are forced on (True) or off (False). The others are
            planned from body, marks and options, as `ifa.plan` does; `solution.effects` says which
            are on, because of what, and how often each ran.

    The best motion found is returned even if it is not `succeeded`; it may miss marks
    (`missed_hits` above 0) or hit where there is none (`extra_hits`). Raises IfaValueError naming
    the argument or the mark, NoMotionError where not even a first contact was found, Cancelled.
    Method: a beam search forwards from event to event; each impact is changed within the
    plausibility region of the paper (section 5.4) so that the next audible hit comes in time.
    With method="graph", simulated flights of a database are strung together by connections (section
    5); `material="fit"` and `reuse` are not for it, and `seed` plays no part: the database has one.
    """
    marks = checked_marks(
        body, marks, method=method, events=events, material=material, constraints=constraints
    )
    arguments.one_of(search, "search", "exact", "branch_and_bound")
    preset = accuracies.named(accuracy)
    if method == "graph" and accuracy != "good":
        raise IfaValueError('accuracy: is for method="forward"')
    if method == "graph" and prediction is not None:
        raise IfaValueError('prediction: is for method="forward"')
    if prediction is not None and not isinstance(prediction, Prediction):
        raise IfaValueError("prediction: needs an ifa.Prediction")
    if prediction is not None and prediction.accuracy != preset.name:
        raise IfaValueError(f'prediction: is of "{prediction.accuracy}", not "{preset.name}"')
    if reuse is not None and not isinstance(reuse, Solution):
        raise IfaValueError("reuse: needs an ifa.Solution")
    if reuse is not None and reuse.kept is None:
        raise IfaValueError(
            "reuse: needs the solution that ifa.solve returned, not one of its takes"
        )
    arguments.check_progress(progress)
    gain = arguments.number(energy_gain_j, "energy_gain_j")
    if not 0.0 <= gain < np.inf:
        raise IfaValueError(f"energy_gain_j: must be finite and 0 or more, got {gain:g}")
    whole_seed = arguments.whole(seed, "seed", 2**64 - 1)
    common: dict[str, Any] = {
        "time_budget_s": arguments.positive(
            preset.time_budget_s if time_budget_s is None else time_budget_s, "time_budget_s"
        ),
        "energy_gain_j": gain,
        "rung": _rung(rung, len(preset.ladder) if method == "forward" else _core.GRAPH_RUNGS),
        "takes": arguments.whole(takes, "takes", MOST_TAKES, least=1),
        "lead_in_s": arguments.positive(lead_in_s, "lead_in_s"),
        "progress": progress,
        "forced": forced_effects(effects),
        **_expert(expert, method),
    }
    workers = arguments.threads(threads)
    hearing = {**HEARING, "events": events}
    if method == "graph":
        nodes = _database_for(body, events, database)
        hearing["merge_gap_s"] = nodes.merge_gap_s
        if material == "fit":
            raise IfaValueError('material: method="graph" knows that of its database alone')
        if reuse is not None:
            raise IfaValueError('reuse: is for method="forward"')
    elif database is not None:
        raise IfaValueError('database: is for method="graph"')
    began = time.perf_counter()
    if method == "graph":
        found = _core.solve_graph(
            nodes._graph_for(gain, workers, progress),
            marks._marks,
            branch_and_bound=search == "branch_and_bound",
            **common,
        )
    else:
        found = _core.solve_forward(
            body._core,
            marks._marks,
            seed=whole_seed,
            threads=workers,
            fit_material=material == "fit",
            contact=events == "contact",
            reuse=None if reuse is None else reuse.kept,
            ladder=preset.ladder,
            until_succeeded=preset.until == "succeeded",
            least_rung=preset.least_rung,
            **common,
        )
    return _solution(
        found,
        body,
        marks,
        solve_s=time.perf_counter() - began,
        hearing=hearing,
        seed=whole_seed,
        energy_gain_j=gain,
        method=method,
        kind=search if method == "graph" else None,
        accuracy=preset.name if method == "forward" else None,
        prediction=prediction,
    )


def _asked(marks: Signature, effects: Plan) -> list[Constraint]:
    """The constraints that are looked at: those of an effect that is forced off are not."""
    names = {poses.Position: "position_constraints", poses.Orientation: "orientation_constraints"}
    return [
        c
        for c in marks.constraints
        if effects[names[type(c)]] and (c.mark != "rest" or effects["settling_to_rest"])
    ]


def _database_for(
    body: Body, events: str, database: Database | str | os.PathLike[str] | None
) -> Database:
    """The database that a solve of this body is given, open."""
    if database is None:
        raise IfaValueError(
            'database: method="graph" needs one; `ifa.Database.build` or `ifa build` makes it'
        )
    if not isinstance(database, Database):
        return _database_for(body, events, Database.open(database, body))
    database._core.need_body(body._core)
    if database.events != events:
        raise IfaValueError(
            f'events: {database.path} was built with "{database.events}", not "{events}"'
        )
    return database


def _expert(expert: Mapping[str, int] | None, method: str) -> dict[str, int]:
    """The sizes that are given, checked."""
    known = EXPERT[method]
    given = dict(expert or {})
    for name in given:
        if name not in known:
            raise IfaValueError(f'expert: method="{method}" has {", ".join(known)}, got {name!r}')
    return {
        name: arguments.whole(value, f"expert: {name}", 2**31 - 1, least=known[name])
        for name, value in given.items()
    }


def _rung(rung: int | None, rungs: int) -> int:
    return -1 if rung is None else arguments.whole(rung, "rung", rungs - 1)


def _solution(
    found: dict[str, Any],
    body: Body,
    marks: Signature,
    *,
    hearing: Mapping[str, Any],
    energy_gain_j: float,
    kind: str | None,
    **rest: Any,
) -> Solution:
    """A solution of the core, with its takes."""
    rest["energy_gain_j"] = energy_gain_j
    others = tuple(
        _solution(other, body, marks, hearing=hearing, kind=kind, **rest)
        for other in found.pop("others")
    )
    logs = found.pop("search_log_weight"), found.pop("search_log_bound")
    score, bound = (math.exp(min(log, 0.0) / (6 * len(marks))) for log in logs)
    events = [Event(**event) for event in found.pop("events")]
    retime = [event.retime for event in events]
    effects = Plan(found.pop("effects"))
    return Solution(
        motion=Motion(found.pop("motion"), retime, energy_gain_j, hearing),
        body=body.replace(restitution=found["restitution"], friction=found["friction"]),
        marks=marks,
        events=events,
        constraints=poses.reports(_asked(marks, effects), found.pop("constraints")),
        effects=effects,
        others=others,
        history=tuple(Stage(**stage) for stage in found.pop("history")),
        search={} if kind is None else {"kind": kind, "score": score, "bound": bound},
        **found,
        **rest,
    )
