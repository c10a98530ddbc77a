"""Studies whose outcomes are written down: what is measured and shown of them is known."""

from __future__ import annotations

import math
import time

import ifa
import pytest
from ifa.tradeoff import Outcome, Setting, Study, TradeoffReport
from ifa.tradeoff.measure import measure

BALL_MARKS = ifa.Signature([0.30, 0.42, 0.51], ending="open")


def scripted(*outcomes):
    """A setting whose k-th repeat is the k-th outcome; what is no outcome is raised."""

    def run(repeat):
        outcome = outcomes[repeat]
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    return run


def study(*settings, knob="scripted"):
    return Study(knob, knob.title(), "error, ms", tuple(settings), "a <note> & more")


def report_of(*curves, quick=False):
    return TradeoffReport(
        body=ifa.bodies.get("ball"),
        marks=BALL_MARKS,
        curves=tuple(curves),
        circumstances={"processor": "a <fast> one", "date": "today"},
        repeats=3,
        seed=0,
        quick=quick,
        measured_s=1.0,
    )


@pytest.fixture
def mixed():
    """Curves with a point of each kind: good, failed in part, failed, with losses, left out."""
    nothing = Setting("left out", scripted())
    studies = [
        study(
            Setting("good", scripted(*(Outcome(t, e) for t, e in ((1, 5), (3, 4), (2, 9))))),
            Setting("exact", scripted(*[Outcome(7.0, 0.0)] * 3), "series"),
            Setting(
                "part", scripted(Outcome(4, 2), Outcome(5, 0, 'it, "fell" | <b>'), Outcome(6, 1))
            ),
            Setting("bad", scripted(*[ifa.IfaError("no motion")] * 3)),
            Setting("lossy", scripted(*[Outcome(8.0, 0.5, losses=("2 of 9 throws",))] * 3)),
            Setting("nan", scripted(*[Outcome(1.0, math.nan)] * 3)),
        ),
        Study("empty", "Empty", "error", (), "nothing to turn here"),
    ]
    curves = measure(studies, repeats=3)
    late = measure([study(nothing, knob="late")], repeats=3, deadline_s=time.monotonic() - 1.0)
    return [*curves, *late]


# The front
