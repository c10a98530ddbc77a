"""The options of the command line, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

import ifa
from ifa.tradeoff import QUICK_REPEATS, REPEATS
from ifa.tradeoff.knobs import KNOBS

BAD_INPUT = 2
MESH_ENDINGS = (".obj", ".off", ".ply", ".stl")

Verb = Callable[[argparse.Namespace], int]


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message} (see {self.prog} --help)\n")


def command_parser(verbs: Mapping[str, Verb]) -> argparse.ArgumentParser:
    """The whole command line; what it parses has `run`, which is one of `verbs` by name."""
    parser = _Parser(
        prog="ifa",
        description="Rigid-body motion whose contacts land on the marks of a sound.",
        epilog="Exit codes: 0 done, 2 bad input, 3 no acceptable motion (solve still writes the "
        "best one, which may miss marks) or no repair that works, 4 cancelled.",
    )
    parser.add_argument("--version", action="version", version=f"ifa {ifa.__version__}")
    subparsers = parser.add_subparsers(required=True, metavar="VERB")

    solve = subparsers.add_parser("solve", help="find a motion that meets the marks")
    _add_body(solve)
    _add_marks(solve)
    solve.add_argument(
        "-o",
        "--out",
        metavar="OUT",
        help="write the motion to this .json file, further takes beside it (OUT.take2.json ...)",
    )
    _add_search(solve)
    solve.add_argument(
        "--method",
        choices=("forward", "graph"),
        default="forward",
        help="search forwards (default), or a database of the body, as the paper does",
    )
    solve.add_argument(
        "--database", metavar="DIR", help="for --method graph: what ifa build has made of BODY"
    )
    solve.add_argument(
        "--search",
        choices=("exact", "branch_and_bound"),
        default="exact",
        help="for --method graph: the best path (default), or the paper's search",
    )
    solve.add_argument(
        "--accuracy",
        choices=tuple(ifa.ACCURACIES),
        help="draft is fast, good (default) plausible, best goes on; given here, seconds and error "
        "of one take are predicted before, which takes a second at most, and compared after",
    )
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
    solve.add_argument(
        "--effect",
        type=_forced_effect,
        action=_Forced,
        default={},
        metavar="NAME=on|off",
        help="force an effect on or off, where the marks and the body would decide; may be given "
        f"again: {' '.join(ifa.EFFECTS)}",
    )
    solve.add_argument(
        "--explain",
        action="store_true",
        help="say which effects are on and off, because of what, and what each costs: in one line "
        "before the search, with how often each ran after it",
    )
    _add_json(solve)
    solve.set_defaults(run=verbs["solve"])

    explain = subparsers.add_parser(
        "explain", help="say which marks conflict, and which changes work: each is tried"
    )
    _add_body(explain)
    _add_marks(explain)
    explain.add_argument("-o", "--out", metavar="OUT", help="write what --json prints to this file")
    _add_search(explain)
    _add_json(explain)
    explain.set_defaults(run=verbs["explain"])

    estimate = subparsers.add_parser(
        "estimate", help="say what the marks ask for, without a search"
    )
    _add_body(estimate)
    _add_marks(estimate)
    _add_ending(estimate)
    _add_json(estimate)
    estimate.set_defaults(run=verbs["estimate"])

    build = subparsers.add_parser(
        "build", help="simulate a body many times into a database; goes on with one begun before"
    )
    _add_body(build)
    build.add_argument(
        "-o", "--out", metavar="DIR", required=True, help="the folder of the database"
    )
    build.add_argument(
        "--simulations", type=int, default=100_000, metavar="N", help="how many (default 100000)"
    )
    build.add_argument("--seed", type=int, default=0, metavar="N", help="of the random starts")
    _add_threads(build)
    build.add_argument(
        "--events",
        choices=("audible", "contact"),
        default="audible",
        help="what an event is: audible hits (default), or an interval of contact",
    )
    build.add_argument(
        "--cone",
        type=float,
        metavar="DEG",
        help="of first velocities about straight down (default 30; 80 suit bodies that roll)",
    )
    build.add_argument(
        "--merge-gap",
        type=float,
        metavar="S",
        help="hits (of contact: flights) nearer than this are one event (default 0.01)",
    )
    build.add_argument(
        "--nodes-only",
        action="store_true",
        help="leave the transitions, which searches need, to the first solve",
    )
    build.add_argument(
        "--check", action="store_true", help="read it all again and compare its checksums"
    )
    _add_json(build)
    build.set_defaults(run=verbs["build"])

    tradeoff = subparsers.add_parser(
        "tradeoff", help="measure what accuracy costs in time on this scene, knob by knob"
    )
    _add_body(tradeoff)
    _add_marks(tradeoff)
    _add_sound(tradeoff)
    _add_ending(tradeoff)
    _add_material(tradeoff)
    tradeoff.add_argument(
        "-o",
        "--out",
        metavar="DIR",
        required=True,
        help="the folder of the report: a page, and a picture and a table of each curve; an "
        "earlier report there is replaced",
    )
    tradeoff.add_argument(
        "--quick", action="store_true", help="fewer and smaller settings, within a minute"
    )
    tradeoff.add_argument(
        "--knobs", metavar="A,B", help=f"only these of {','.join(KNOBS)} (default: all)"
    )
    tradeoff.add_argument(
        "--repeats",
        type=int,
        metavar="N",
        help=f"run each setting so often (default {REPEATS}; with --quick {QUICK_REPEATS})",
    )
    tradeoff.add_argument(
        "--time-limit",
        type=float,
        metavar="S",
        help="begin no run that would end later (default none; with --quick 60); the report says "
        "what was left out",
    )
    tradeoff.add_argument("--seed", type=int, default=0, metavar="N", help="of throws and searches")
    _add_threads(tradeoff)
    _add_json(tradeoff)
    tradeoff.set_defaults(run=verbs["tradeoff"])

    verify = subparsers.add_parser("verify", help="check a motion again, from its poses alone")
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
    verify.set_defaults(run=verbs["verify"])

    bodies = subparsers.add_parser("bodies", help="list the library of bodies")
    _add_json(bodies)
    bodies.set_defaults(run=verbs["bodies"])
    return parser


class _Forced(argparse.Action):
    """Effects by name; one that is given twice is refused."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        name, on = values
        forced = dict(getattr(namespace, self.dest))
        if name in forced:
            parser.error(f"argument --effect: {name} is given twice")
        setattr(namespace, self.dest, forced | {name: on})


def _forced_effect(words: str) -> tuple[str, bool]:
    name, _, value = words.partition("=")
    if name not in ifa.EFFECTS:
        raise argparse.ArgumentTypeError(
            f"'{name}' is no effect; there are {', '.join(ifa.EFFECTS)}"
        )
    if value not in ("on", "off"):
        raise argparse.ArgumentTypeError(f"must be {name}=on or {name}=off, got '{words}'")
    return name, value == "on"


def _add_body(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "body",
        metavar="BODY",
        help=f"a name ({' '.join(ifa.bodies.names())}), a mesh ({' '.join(MESH_ENDINGS)}) or a "
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


def _add_sound(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--sound", metavar="WAV", help="the marked sound: gives the amplitudes")


def _add_ending(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ending",
        choices=("rest", "open"),
        help="after the last mark: at rest without a further hit, or anything",
    )


def _add_search(parser: argparse.ArgumentParser) -> None:
    _add_sound(parser)
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
    _add_material(parser)
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
        metavar="S",
        help="begin no larger search after so many seconds (default 10; --accuracy best 60)",
    )
    _add_threads(parser)


def _add_material(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--restitution", type=float, metavar="E", help="0 to 1")
    parser.add_argument("--friction", type=float, metavar="MU", help="0 or more")


def _add_threads(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--threads", type=int, metavar="N", help="default: one for each core")


def _add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object")
