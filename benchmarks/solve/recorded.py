"""Cases from recordings and measurements, of the evaluation data that lies beside the project."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import product
from pathlib import Path

import ifa
from ifa.marks import Ending

from .cases import Case

# Bodies of recordings whose name does not say it; the balls bounce on after the recording ends.
_OTHER_BODIES: dict[str, tuple[str, Ending]] = {
    "diceapi_roll1": ("d6", "rest"),
    "qabcs_rubber_ball": ("ball", "open"),
    "foobillard_balloutoftable": ("ball", "open"),
}


def sounds(shared: Path) -> list[Case]:
    """Every hit of a recording is a mark, its loudness comes from the sound."""
    return _recordings(shared, "hits")


def labels(shared: Path) -> list[Case]:
    """The coarser labels of the same recordings, where a span is one continuous event."""
    return _recordings(shared, "labels")


def _recordings(shared: Path, marked: str) -> list[Case]:
    cases = []
    for path in sorted((shared / "sounds").glob(f"*.{marked}.txt")):
        name = path.name.removesuffix(f".{marked}.txt")
        body, ending = (
            _OTHER_BODIES[name] if name in _OTHER_BODIES else (name.split("_")[1], "rest")
        )
        marks = ifa.Signature.read(path, sound=path.with_name(f"{name}.wav"), ending=ending)
        cases.append(Case(name, ifa.bodies.get(body), marks, "fit"))
    return cases


def tosses(shared: Path) -> list[Case]:
    """Every hit of a motion-captured toss of a cube is a mark, with the impulse measured."""

    def marks(toss: dict) -> ifa.Signature:
        return ifa.Signature(
            [hit["t"] for hit in toss["hits"]],
            amplitudes=[hit["amp"] for hit in toss["hits"]],
            ending=_ending(toss),
        )

    return _toss_cases(shared, marks, "audible")


def toss_events(shared: Path) -> list[Case]:
    """The same tosses in the paper's sense: intervals of contact, with their impulse."""

    def marks(toss: dict) -> ifa.Signature:
        events = toss["events"]
        return ifa.Signature(
            [event["t"] for event in events],
            [event["dur"] if event["kind"] == "continuous" else 0.0 for event in events],
            [event["amp"] for event in events],
            ending=_ending(toss),
        )

    return _toss_cases(shared, marks, "contact")


def _toss_cases(shared: Path, marks_of: Callable[[dict], ifa.Signature], events: str) -> list[Case]:
    cube, rows = _tosses(shared)
    return [Case(f"toss_{row['toss']:03}", cube, marks_of(row), events=events) for row in rows]


def balls(shared: Path) -> list[Case]:
    """Bounces of real balls by microphone, without loudness; each goes on to bounce."""
    path = shared / "tosses" / "ball_bounces.json"
    throws = json.loads(path.read_text(encoding="utf-8"))["throws"]
    return [
        Case(
            f"{throw['ball']}_{i:02}",
            ifa.bodies.get("ball"),
            ifa.Signature(throw["t"], ending="open"),
            "fit",
        )
        for i, throw in enumerate(throws)
    ]


def _tosses(shared: Path) -> tuple[ifa.Body, list[dict]]:
    data = json.loads((shared / "tosses" / "cube_tosses.json").read_text(encoding="utf-8"))
    cube = data["object"]
    half = 0.5 * cube["side_m"]
    body = ifa.Body.from_vertices(
        list(product((-half, half), repeat=3)),
        mass_kg=cube["mass_kg"],
        inertia_kg_m2=cube["inertia_kgm2"],
        restitution=cube["restitution"],
        friction=cube["mu"],
        name="cube",
    )
    return body, data["tosses"]


def _ending(toss: dict) -> Ending:
    return "rest" if toss["terminal"] else "open"
