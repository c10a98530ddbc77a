"""What accuracy costs in time, knob by knob, for one scene on one machine in one run."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

from ifa import arguments
from ifa._core import Cancelled, IfaError, IfaValueError, Progress
from ifa.body import Body
from ifa.marks import Signature
from ifa.sound import FilePath
from ifa.tradeoff import knobs as all_knobs
from ifa.tradeoff import picture
from ifa.tradeoff.curve import Curve, Outcome, Point, Scene, Setting, Study
from ifa.tradeoff.machine import load, machine
from ifa.tradeoff.measure import measure
from ifa.tradeoff.report import TradeoffReport, check_folder

__all__ = [
    "Curve",
    "Outcome",
    "Point",
    "Scene",
    "Setting",
    "Study",
    "TradeoffReport",
    "tradeoff",
]

REPEATS = 5
QUICK_REPEATS = 3
QUICK_S = 60.0  # for everything, drawing included
_SLACK = 0.05  # share of a time limit: the page, a last run that takes longer than expected
_DRAWING = 1.4  # how much longer pictures may take than the one that is drawn to find out
_MOST_DRAWING = 0.3  # share of a time limit that drawing may claim beforehand
_PREPARING = 0.4  # share of a time limit after which no further study is prepared
_MOST_REPEATS = 1000


def tradeoff(
    body: Body,
    marks: Signature,
    out: FilePath | None = None,
    *,
    quick: bool = False,
    knobs: Sequence[str] | None = None,
    repeats: int | None = None,
    time_limit_s: float | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
    command: str = "ifa.tradeoff",
) -> TradeoffReport:
    """Measure what every accuracy knob costs in time and what it buys, on this scene and machine.

    Args:
        body: What moves.
        marks: What a motion is solved for, where a knob needs one.
        out: A folder to write the report to: one HTML page, and PNG and CSV of each curve. Needs
            matplotlib. What stands there is replaced if it is an earlier report.
        quick: Fewer and smaller settings.
        knobs: Names of knobs, as `ifa tradeoff --help` lists them; None measures all.
        repeats: How often each setting is run: 5, or 3 with `quick`.
        time_limit_s: For all of it, drawing included: a run that would end later is not begun, and
            the report says what was left out. None is no limit, or a minute with `quick`.
        seed: Of throws and searches; repeat k of a search has seed `seed` + k.
        threads: For searches: 1 or more, None is one for each core.
        progress: Read its `fraction` and call its `cancel()` from another thread.
        command: What the report says it was made by.

    Raises:
        IfaValueError: Names the argument.
        IfaFileError: The folder cannot be written, or holds something else.
        IfaError: `out` is given and matplotlib is not installed; found before anything runs.
        Cancelled: Nothing was written.

    Example:
        >>> import ifa
        >>> marks = ifa.Signature([0.2, 0.3], ending="open")
        >>> ball = ifa.bodies.get("ball")
        >>> report = ifa.tradeoff(ball, marks, knobs=["float_width"], repeats=1)
        >>> [point.label for point in report.curves[0].points]
        ['float16', 'float32', 'float64']
    """
    began_s = time.monotonic()
    if not isinstance(body, Body):
        raise IfaValueError("body: needs an ifa.Body")
    if not isinstance(marks, Signature):
        raise IfaValueError("marks: needs an ifa.Signature")
    names = all_knobs.chosen(knobs)
    if repeats is None:
        repeats = QUICK_REPEATS if quick else REPEATS
    repeats = arguments.whole(repeats, "repeats", _MOST_REPEATS, least=1)
    seed = arguments.whole(seed, "seed", 2**64 - 1 - _MOST_REPEATS)
    limit_s = QUICK_S if quick else math.inf
    if time_limit_s is not None:
        limit_s = arguments.positive(time_limit_s, "time_limit_s")
    arguments.threads(threads)
    arguments.check_progress(progress)
    if out is not None:
        check_folder(out)
        picture.check_matplotlib()

    circumstances = {"command": command, "date": time.strftime("%Y-%m-%d %H:%M %Z"), **machine()}
    # cancels, but counts nothing
    inner = Progress() if progress is None else progress.part(0.0, 0.0)
    scene = Scene(body, marks, seed, threads, inner)
    studies = _prepared(scene, names, quick, began_s + _PREPARING * limit_s)
    deadline_s = began_s + limit_s
    if out is not None and math.isfinite(limit_s):
        drawing_s = _DRAWING * len(studies) * picture.drawing_time_s()
        deadline_s -= _SLACK * limit_s + min(drawing_s, _MOST_DRAWING * limit_s)
    curves = measure(
        studies, repeats=repeats, deadline_s=deadline_s, progress=progress, running=inner
    )
    circumstances["load after"] = load()
    report = TradeoffReport(
        body=body,
        marks=marks,
        curves=tuple(curves),
        circumstances=circumstances,
        repeats=repeats,
        seed=seed,
        quick=quick,
        measured_s=time.monotonic() - began_s,
    )
    if out is not None:
        report.write(out, progress)
    if progress is not None:
        progress.raise_to(1.0)
    return report


def _prepared(scene: Scene, names: Sequence[str], quick: bool, until_s: float) -> list[Study]:
    """The studies of the knobs; those that cannot be made have no settings and say why.

    until_s: By `time.monotonic`; none is begun later.
    """
    studies = []
    for name in names:
        for make in all_knobs.KNOBS[name]:
            if scene.progress is not None and scene.progress.cancelled:
                raise Cancelled("cancelled")
            if time.monotonic() > until_s:
                reason = "not begun: the time was up"
            else:
                try:
                    studies.append(make(scene, quick=quick))
                    continue
                except Cancelled:
                    raise
                except IfaError as error:
                    reason = f"could not be measured: {error}"
            label = make.__name__
            studies.append(Study(label, label.replace("_", " "), "error", (), reason))
    return studies
