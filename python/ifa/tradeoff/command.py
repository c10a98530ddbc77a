"""`ifa tradeoff`: the run, and what it prints."""

from __future__ import annotations

import argparse
import shlex
import sys

import ifa
from ifa.body import Body
from ifa.marks import Signature
from ifa.meter import Meter, watched
from ifa.tradeoff import TradeoffReport, page, tradeoff
from ifa.tradeoff.curve import Curve


class _Meter(Meter):
    _VERB = "measuring"


def run(options: argparse.Namespace, body: Body, marks: Signature) -> TradeoffReport:
    """Measure what the options ask for and write the report."""
    progress = ifa.Progress()
    return watched(
        lambda: tradeoff(
            body,
            marks,
            options.out,
            quick=options.quick,
            knobs=None if options.knobs is None else options.knobs.split(","),
            repeats=options.repeats,
            time_limit_s=options.time_limit,
            seed=options.seed,
            threads=options.threads,
            progress=progress,
            command=_command(options),
        ),
        progress,
        _Meter(sys.stderr),
    )


def _command(options: argparse.Namespace) -> str:
    """The command line again, from what it was parsed into."""
    words = ["ifa", "tradeoff", options.body, options.marks]
    for name, value in vars(options).items():
        if name in ("run", "body", "marks") or value is None or value is False:
            continue
        flag = f"--{name.replace('_', '-')}"
        words += [flag] if value is True else [flag, str(value)]
    return shlex.join(words)


def text(report: TradeoffReport) -> str:
    """The Pareto front of each curve, and what failed, for people."""
    return "\n\n".join(_curve_text(curve) for curve in report.curves)


def _curve_text(curve: Curve) -> str:
    head = f"{curve.study.title} ({curve.study.knob}): {curve.study.error_name}"
    if not curve.points:
        return f"{head}\n  {curve.study.note}"
    lines = [head]
    for point in sorted((p for p in curve.points if p.on_front), key=lambda p: p.time_s):
        name = f"{point.series}, {point.label}" if point.series else point.label
        lines.append(f"  {1e3 * point.time_s:10.3g} ms  {point.error:10.3g}  {name}")
    for point in curve.points:
        for trouble in page.troubles(vars(point)):
            name = f"{point.series}, {point.label}" if point.series else point.label
            lines.append(f"  {name}: {trouble}")
    return "\n".join(lines)
