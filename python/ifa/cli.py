"""The command line: `ifa solve`, `ifa explain`, `ifa estimate`, `ifa verify`, `ifa bodies`.

Exit codes: 0 done, 2 bad input, 3 no acceptable motion (the best one is still written, unless not
even a first contact was found) or no repair that works, 4 cancelled. With `--json` stdout holds one
JSON object and nothing else; everything for the eye goes to stderr.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

import ifa
from ifa import arguments, report
from ifa.marks import Ending
from ifa.meter import watched
from ifa.solving import MOST_TAKES
from ifa.text_files import write_text

DONE, BAD_INPUT, NO_MOTION, CANCELLED = 0, 2, 3, 4

_EXPLAIN = "`ifa explain` with the same arguments tries repairs"
_MESH_ENDINGS = (".obj", ".off", ".ply", ".stl")


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message} (see {self.prog} --help)\n")


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; argparse itself exits with 0 or 2."""
    options = _parser().parse_args(words)
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


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="ifa",
        description="Rigid-body motion whose contacts land on the marks of a sound.",
        epilog="Exit codes: 0 done, 2 bad input, 3 no acceptable motion (solve still writes the "
        "best one, which may miss marks) or no repair that works, 4 cancelled.",
    )
    parser.add_argument("--version", action="version", version=f"ifa {ifa.__version__}")
    verbs = parser.add_subparsers(required=True, metavar="VERB")

    solve = verbs.add_parser("solve", help="find a motion that meets the marks")
    _add_body(solve)
    _add_marks(solve)
    solve.add_argument(
        "-o",
        "--out",
        metavar="OUT",
        help="write the motion to this .json file, further takes beside it (OUT.take2.json ...)",
    )
    _add_search(solve)
    solve.add_argument("--method", choices=("forward", "graph"), default="forward")
    solve.add_argument(
        "--rung",
        type=int,
        metavar="N",
        help="search exactly this hard, whatever the time: the result says at which rung it ended",
    )
    solve.add_argument(
        "--takes",
        type=int,
        default=1,
        metavar="N",
        help="look for so many clearly different motions (default 1); there may be fewer",
    )
    solve.add_argument(
        "--lead-in",
        type=float,
        default=0.5,
        metavar="S",
        help="of flight before the first mark (default 0.5); less where an earlier contact comes",
    )
    _add_json(solve)
    solve.set_defaults(run=_solve)

    explain = verbs.add_parser(
        "explain", help="say which marks conflict, and which changes work: each is tried"
    )
    _add_body(explain)
    _add_marks(explain)
    explain.add_argument("-o", "--out", metavar="OUT", help="write what --json prints to this file")
    _add_search(explain)
    _add_json(explain)
    explain.set_defaults(run=_explain)

    estimate = verbs.add_parser("estimate", help="say what the marks ask for, without a search")
    _add_body(estimate)
    _add_marks(estimate)
    _add_ending(estimate)
    _add_json(estimate)
    estimate.set_defaults(run=_estimate)

    verify = verbs.add_parser("verify", help="check a motion again, from its poses alone")
    verify.add_argument("motion", metavar="MOTION", help="what ifa solve -o wrote")
    _add_marks(verify)
    _add_body(verify)
    _add_ending(verify)
    verify.add_argument(
        "--events",
        choices=("audible", "contact"),
        help="what answers a mark: an audible hit, or the beginning of a contact; default: what "
        "the motion was made for",
    )
    _add_json(verify)
    verify.set_defaults(run=_verify)

    bodies = verbs.add_parser("bodies", help="list the library of bodies")
    _add_json(bodies)
    bodies.set_defaults(run=_bodies)
    return parser


def _add_body(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "body",
        metavar="BODY",
        help=f"a name ({' '.join(ifa.bodies.names())}), a mesh ({' '.join(_MESH_ENDINGS)}) or a "
        "body file (.json)",
    )
    parser.add_argument(
        "--surface", choices=ifa.bodies.surfaces(), help="under a body of the library"
    )
    parser.add_argument("--unit", help="of a mesh: m (default), cm, mm, inch ...")
    parser.add_argument("--density", type=float, metavar="KG_M3", help="of a mesh (default 1000)")
    parser.add_argument("--mass", type=float, metavar="KG", help="of a mesh, in place of --density")


def _add_marks(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "marks", metavar="MARKS", help="an Audacity label track (.txt) or JSON (.json)"
    )


def _add_ending(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ending",
        choices=("rest", "open"),
        help="after the last mark: at rest without a further hit, or anything",
    )


def _add_search(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--sound", metavar="WAV", help="the marked sound: gives the amplitudes")
    _add_ending(parser)
    parser.add_argument(
        "--events",
        choices=("audible", "contact"),
        default="audible",
        help="what a mark asks for: an audible hit (default), or an interval of contact",
    )
    parser.add_argument(
        "--material",
        choices=("given", "fit"),
        default="given",
        help="take restitution and friction as given (default), or choose them to suit the marks",
    )
    parser.add_argument("--restitution", type=float, metavar="E", help="0 to 1")
    parser.add_argument("--friction", type=float, metavar="MU", help="0 or more")
    parser.add_argument(
        "--energy-gain", type=float, default=0.0, metavar="J", help="that a contact may add"
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        metavar="N",
        help="another seed, another take; the same seed and rung give the same motion",
    )
    parser.add_argument(
        "--time-budget",
        type=float,
        default=10.0,
        metavar="S",
        help="begin no larger search after so many seconds (default 10)",
    )
    parser.add_argument("--threads", type=int, metavar="N", help="default: one for each core")


def _add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _solve(options: argparse.Namespace) -> int:
    arguments.whole(options.takes, "takes", MOST_TAKES, least=1)
    if options.out is not None:
        for out in _take_files(options.out, options.takes):
            _check_out(out, inputs=(options.body, options.marks, options.sound))
    body, marks = _request(options)
    progress = ifa.Progress()
    try:
        solution = watched(
            lambda: ifa.solve(
                body,
                marks,
                method=options.method,
                events=options.events,
                seed=options.seed,
                time_budget_s=options.time_budget,
                threads=options.threads,
                material=options.material,
                energy_gain_j=options.energy_gain,
                takes=options.takes,
                lead_in_s=options.lead_in,
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
    """Write every take, OUT last: where it is new, the others are whole beside it."""
    takes = solution.takes
    if out is None:
        return [None] * len(takes)
    files = _take_files(out, asked)
    for take, path in reversed(list(zip(takes, files, strict=False))):  # there may be fewer takes
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
            material=options.material,
            energy_gain_j=options.energy_gain,
            seed=options.seed,
            time_budget_s=options.time_budget,
            threads=options.threads,
            events=options.events,
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
    is_mesh = not in_library and ending in _MESH_ENDINGS
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
            f"{given}: its ending is not known; a body is a mesh ({', '.join(_MESH_ENDINGS)}) or a "
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


if __name__ == "__main__":
    sys.exit(main())
