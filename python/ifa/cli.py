"""The command line: `ifa solve`, `explain`, `estimate`, `build`, `tradeoff`, `verify`, `bodies`.

Exit codes: 0 done, 2 bad input, 3 no acceptable motion (the best one is still written, unless not
even a first contact was found) or no repair that works, 4 cancelled. With `--json` stdout holds one
JSON object and nothing else; everything for the eye goes to stderr.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import ifa
from ifa import arguments, report
from ifa.cli_options import BAD_INPUT, MESH_ENDINGS, command_parser
from ifa.marks import Ending
from ifa.meter import BuildMeter, watched
from ifa.solving import MOST_TAKES
from ifa.text_files import write_text
from ifa.tradeoff import command as tradeoff_command

DONE, NO_MOTION, CANCELLED = 0, 3, 4

_EXPLAIN = "`ifa explain` with the same arguments tries repairs"


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; argparse itself exits with 0 or 2."""
    options = command_parser(_VERBS).parse_args(words)
    try:
        code: int = options.run(options)
        sys.stdout.flush()
        return code
    except (KeyboardInterrupt, ifa.Cancelled):
        _say("cancelled: nothing was written")
        return CANCELLED
    except ifa.IfaError as error:
        _say(str(error))
        return BAD_INPUT
    except BrokenPipeError:  # the reader of our output has gone, as with `| head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE


def _solve(options: argparse.Namespace) -> int:
    arguments.whole(options.takes, "takes", MOST_TAKES, least=1)
    if options.out is not None:
        for out in _take_files(options.out, options.takes):
            _check_out(out, inputs=(options.body, options.marks, options.sound))
    body, marks = _request(options)
    effects: dict[str, Any] = {
        "method": options.method,
        "lead_in_s": options.lead_in,
        "effects": options.effect,
    }
    if options.explain:
        plan = ifa.plan(body, marks, events=options.events, material=options.material, **effects)
        _say(plan.line())
    predicted = _predicted(options, body, marks)
    progress = ifa.Progress()
    try:
        solution = watched(
            lambda: ifa.solve(
                body,
                marks,
                **_search_options(options),
                **effects,
                **predicted,
                database=options.database,
                search=options.search,
                takes=options.takes,
                progress=progress,
                rung=options.rung,
            ),
            progress,
        )
    except ifa.NoMotionError as error:
        _say(f"{error}; {_EXPLAIN}")
        if options.json:
            _print_json(
                {
                    "succeeded": False,
                    "plausible": False,
                    "error": str(error),
                    "version": ifa.__version__,
                }
            )
        return NO_MOTION
    written = _write_takes(solution, options.out, options.takes)
    if options.json:
        _print_json({**solution.to_dict(), "takes": report.takes(solution, written)})
    else:
        print(report.solution_text(solution))
        if options.explain:
            print(f"\n{solution.effects}")
        if options.takes > 1:
            print(f"\n{report.takes_text(solution, written, asked=options.takes)}")
        elif options.out is not None:
            print(f"written to {options.out}")
    if solution.succeeded:
        return DONE
    _say(f"{'; '.join(report.troubles(solution))}; {_EXPLAIN}")
    return NO_MOTION


def _take_files(out: str, number: int) -> list[str]:
    """The file of each take: OUT.json, OUT.take2.json, OUT.take3.json ..."""
    path = Path(out)
    others = (path.with_name(f"{path.stem}.take{k}{path.suffix}") for k in range(2, number + 1))
    return [out, *map(str, others)]


def _write_takes(solution: ifa.Solution, out: str | None, asked: int) -> list[str | None]:
    """Write every take, the solve's own motion first."""
    takes = solution.takes
    if out is None:
        return [None] * len(takes)
    files = _take_files(out, asked)
    for take, path in zip(takes, files, strict=False):  # there may be fewer takes
        take.write(path)
    for path in files[len(takes) :]:
        if Path(path).exists():
            _say(f"{path}: is left as it was, from an earlier solve")
    return list(files[: len(takes)])


def _explain(options: argparse.Namespace) -> int:
    if options.out is not None:
        _check_out(options.out, inputs=(options.body, options.marks, options.sound))
    body, marks = _request(options)
    progress = ifa.Progress()
    explanation = watched(
        lambda: ifa.explain(
            body,
            marks,
            **_search_options(options),
            progress=progress,
        ),
        progress,
    )
    content = explanation.to_dict()
    if options.out is not None:
        write_text(options.out, json.dumps(content, allow_nan=False) + "\n")
    if options.json:
        _print_json(content)
    else:
        print(report.explanation_text(explanation, body))
        if options.out is not None:
            print(f"written to {options.out}")
    return DONE if explanation.plausible or explanation.repairs else NO_MOTION


def _search_options(options: argparse.Namespace) -> dict[str, Any]:
    """What a solve and an explanation have in common."""
    asked = {
        "events": options.events,
        "material": options.material,
        "energy_gain_j": options.energy_gain,
        "seed": options.seed,
        "threads": options.threads,
    }
    if options.time_budget is not None:
        asked["time_budget_s"] = options.time_budget
    return asked


def _predicted(options: argparse.Namespace, body: ifa.Body, marks: ifa.Signature) -> dict[str, Any]:
    """The accuracy asked for, if one is, and what is expected of it, which is said at once."""
    if options.accuracy is None:
        return {}
    if options.method != "forward" or options.rung is not None or options.takes > 1:
        return {"accuracy": options.accuracy}  # a prediction is of a climb to one motion
    progress = ifa.Progress()
    prediction = watched(
        lambda: ifa.predict(
            body,
            marks,
            accuracy=options.accuracy,
            lead_in_s=options.lead_in,
            effects=options.effect,
            progress=progress,
            **_search_options(options),
        ),
        progress,
    )
    _say(report.prediction_text(prediction))
    return {"accuracy": options.accuracy, "prediction": prediction}


def _request(options: argparse.Namespace) -> tuple[ifa.Body, ifa.Signature]:
    """The body, of the material that the options name, and the marks."""
    marks = ifa.Signature.read(options.marks, sound=options.sound, ending=options.ending)
    body = _body(options)
    material = {
        field: value
        for field in ("restitution", "friction")
        if (value := getattr(options, field)) is not None
    }
    return body.replace(**material), marks


def _estimate(options: argparse.Namespace) -> int:
    marks = ifa.Signature.read(options.marks, ending=options.ending)
    body = _body(options)
    estimate = ifa.estimate(body, marks)
    if options.json:
        _print_json(estimate.to_dict())
    else:
        print(report.estimate_text(estimate, body, marks))
    return DONE


def _build(options: argparse.Namespace) -> int:
    body = _body(options)
    asked: dict[str, Any] = {}
    if options.cone is not None:
        asked["sampling"] = {"cone_rad": math.radians(options.cone)}
    if options.merge_gap is not None:
        asked["merge_gap_s"] = options.merge_gap
    progress = ifa.Progress()

    def build() -> ifa.Database:
        database = ifa.Database.build(
            body,
            options.out,
            options.simulations,
            options.seed,
            threads=options.threads,
            events=options.events,
            progress=progress,
            **asked,
        )
        if options.check:
            database.check(options.threads)
        if not options.nodes_only:
            database.prepare(options.threads, progress)
        return database

    try:
        database = watched(build, progress, BuildMeter(sys.stderr, options.simulations))
    except ifa.Cancelled:
        _say("cancelled: the same command goes on from here")
        return CANCELLED
    content = database.to_dict()
    if options.json:
        _print_json(content)
    else:
        print(report.database_text(content, checked=options.check))
    return DONE


def _tradeoff(options: argparse.Namespace) -> int:
    body, marks = _request(options)
    found = tradeoff_command.run(options, body, marks)
    if options.json:
        _print_json(found.to_dict())
    else:
        print(tradeoff_command.text(found))
        print(f"written to {options.out}")
    return DONE


def _verify(options: argparse.Namespace) -> int:
    ending = options.ending
    if ending is None and Path(options.marks).suffix.lower() != ".json":
        ending = _ending_solved_for(options.motion)
    marks = ifa.Signature.read(options.marks, ending=ending)
    certificate = ifa.verify(options.motion, _body(options), marks, events=options.events)
    if options.json:
        _print_json(certificate.to_dict())
    else:
        print(certificate.summary())
    return DONE if certificate.passed else NO_MOTION


def _bodies(options: argparse.Namespace) -> int:
    rows = ifa.bodies.describe()
    if options.json:
        _print_json({"bodies": rows})
    else:
        print(report.bodies_text(rows))
    return DONE


def _body(options: argparse.Namespace) -> ifa.Body:
    """The body that BODY and the options beside it name; what was assumed goes to stderr."""
    given, ending = options.body, Path(options.body).suffix.lower()
    mesh_options = {"unit": options.unit, "density": options.density, "mass": options.mass}
    in_library = given in ifa.bodies.names()
    is_mesh = not in_library and ending in MESH_ENDINGS
    if not is_mesh:
        for field, value in mesh_options.items():
            if value is not None:
                raise ifa.IfaValueError(f"--{field}: is for mesh files; {given} is none")
    if not in_library and options.surface is not None:
        raise ifa.IfaValueError(
            f"--surface: is for bodies of the library; give {given} a restitution and friction"
        )
    if in_library:
        return ifa.bodies.get(given, **({"surface": options.surface} if options.surface else {}))
    if is_mesh:
        return _mesh_body(given, **mesh_options)
    if ending == ".json":
        return ifa.Body.read(given)
    if Path(given).is_file():
        raise ifa.IfaFileError(
            f"{given}: its ending is not known; a body is a mesh ({', '.join(MESH_ENDINGS)}) or a "
            "body file (.json)"
        )
    raise ifa.IfaValueError(
        f"body: '{given}' is neither in the library ({', '.join(ifa.bodies.names())}) nor a file"
    )


def _mesh_body(path: str, unit: str | None, density: float | None, mass: float | None) -> ifa.Body:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ifa.MeshWarning)  # they are among the notes
        body = ifa.Body.from_mesh(path, unit=unit or "m", density=density, mass_kg=mass)
    for note in body.notes:
        _say(f"{path}: {note}")
    size_mm = 1e3 * (body.outline_m.max(axis=0) - body.outline_m.min(axis=0))
    assumed = "" if unit else "no --unit given, taken as m; "
    size = " x ".join(f"{s:.4g}" for s in size_mm)
    _say(f"{path}: {assumed}{size} mm, {1e3 * body.mass_kg:.4g} g")
    return body


def _check_out(out: str, inputs: Sequence[str | None]) -> None:
    """Find out before the search, not after it, that its result could not be written."""
    path = Path(out)
    if path.suffix.lower() != ".json":
        raise ifa.IfaValueError(f"{out}: is written as JSON, so its name must end in .json")
    if path.is_dir():
        raise ifa.IfaFileError(f"{out}: is a folder")
    if not path.parent.is_dir():
        raise ifa.IfaFileError(f"{out}: there is no folder {path.parent}")
    if not os.access(path.parent, os.W_OK):
        raise ifa.IfaFileError(f"{out}: the folder {path.parent} cannot be written to")
    for name in inputs:
        if name is not None and path.exists() and os.path.exists(name) and path.samefile(name):
            raise ifa.IfaValueError(f"{out}: is also an input and would be overwritten")


def _ending_solved_for(motion: str) -> Ending | None:
    """A label track does not say how a sound ends; the motion says which ending it was made for."""
    try:
        ending = json.loads(Path(motion).read_bytes())["marks"]["ending"]
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return None  # verify says what is wrong with the file
    return ending if ending in ("rest", "open") else None


def _print_json(content: dict[str, Any]) -> None:
    print(json.dumps(content, allow_nan=False))


def _say(sentence: str) -> None:
    print(f"ifa: {sentence}", file=sys.stderr)


_VERBS = {
    "solve": _solve,
    "explain": _explain,
    "estimate": _estimate,
    "build": _build,
    "tradeoff": _tradeoff,
    "verify": _verify,
    "bodies": _bodies,
}


if __name__ == "__main__":
    sys.exit(main())
