"""Measure accuracy against time on six bodies, for docs/accuracy.md: `make accuracy`.

Each body is thrown once in the simulation, and the marks are what is heard of that throw. Nothing
else should run on the machine meanwhile.
"""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import ifa
from ifa.tradeoff import Curve, Point, page, picture, table
from PIL import Image  # matplotlib needs it too

BODIES = ("d6", "ball", "coin", "card", "eraser", "coffee_cup")
SEED = 1
MARKS = (4, 12)  # of a throw: the fewest and the most
TIME_LIMIT_S = 75.0  # of a body; six of them, drawn, are done in eight minutes
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from benchmarks.accuracy_presets import section  # noqa: E402

_COLOURS = 128  # of a picture, which keeps it small
_FOLDER = Path(__file__).parent


def throw(body: ifa.Body) -> ifa.Signature:
    """The marks of the first throw of SEED that is heard often enough and comes to rest."""
    states = ifa.sample_states(body, 200, seed=SEED)
    for row in range(len(states)):
        run = ifa.simulate(body, states[row], until_s=10.0)
        if not (run.hits.approach_speed_m_s >= 0.05).any():
            continue
        marks = ifa.Signature.from_run(run)
        if marks.ending == "rest" and MARKS[0] <= len(marks) <= MARKS[1]:
            return marks
    raise ifa.IfaError(f"{body.name}: no throw of seed {SEED} is heard often enough")


def small(png: bytes) -> bytes:
    """The picture in few colours."""
    image = Image.open(io.BytesIO(png)).convert("RGB")
    out = io.BytesIO()
    image.quantize(_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
        out, "png", optimize=True
    )
    return out.getvalue()


def page_text(reports: Mapping[str, ifa.TradeoffReport], drawn: Sequence[str]) -> str:
    """docs/accuracy.md."""
    first = next(iter(reports.values()))
    facts = {k: v for k, v in first.circumstances.items() if k != "command"}
    marks = ", ".join(f"{name} {len(report.marks)}" for name, report in reports.items())
    took_s = sum(report.measured_s for report in reports.values())
    lines = [
        "# Accuracy against time",
        "",
        "What every accuracy knob costs in time and what it buys, on one scene for each of "
        f"{len(reports)} bodies. `ifa tradeoff BODY MARKS -o report/` measures the same on a scene "
        "of yours; `make accuracy` makes this page again.",
        "",
        f"A scene is one simulated throw (seed {SEED}) and what is heard of it; marks: {marks}. "
        f"Each setting was run {first.repeats} times, all interleaved, {took_s:.0f} s in all. "
        "Figures are medians; bars in the pictures go from the least to the largest, the yellow "
        "line is the Pareto front, and what failed is crossed out and named. All points are in "
        "[accuracy.csv](accuracy.csv).",
        "",
        *(f"- {name}: {value}" for name, value in facts.items()),
        "",
    ]
    lines += [
        "## The presets: draft, good, best",
        "",
        "`ifa.ACCURACIES`, points on the curve of what was tried, and `ifa.predict` before solving "
        "(`python -m benchmarks.accuracy_presets` measures both, `--record` keeps them).",
        "",
        section.markdown(),
    ]
    for knob in drawn:
        curves = _of(reports, knob)
        study = next(iter(curves.values())).study
        lines += [f"## {study.title}", "", f"![{study.title}](images/accuracy_{knob}.png)", ""]
        lines += [_note(curves), ""]
        lines += _table(curves)
        left_out = [
            f"{name}: {curve.study.note}"
            for name, curve in _of(reports, knob, without_points=True).items()
        ]
        lines += [*left_out, ""] if left_out else []
        lines += _troubles(curves)
    return "\n".join(lines).rstrip() + "\n"


def _of(
    reports: Mapping[str, ifa.TradeoffReport], knob: str, without_points: bool = False
) -> dict[str, Curve]:
    return {
        name: curve
        for name, report in reports.items()
        for curve in report.curves
        if curve.study.knob == knob and bool(curve.points) is not without_points
    }


def _note(curves: Mapping[str, Curve]) -> str:
    """The study's note; figures in it may be of one body."""
    notes = {curve.study.note for curve in curves.values()}
    first = next(iter(curves))
    return curves[first].study.note + (f" ({first}'s figures.)" if len(notes) > 1 else "")


def _table(curves: Mapping[str, Curve]) -> list[str]:
    """Error and time of the settings that most bodies share."""
    cells: dict[tuple[str, str], dict[str, Point]] = {}
    for name, curve in curves.items():
        for point in curve.points:
            cells.setdefault((point.series, point.label), {})[name] = point
    shared = {key: row for key, row in cells.items() if 2 * len(row) > len(curves)}
    if not shared:
        return []
    study = next(iter(curves.values())).study
    lines = [
        f"{study.error_name[0].upper()}{study.error_name[1:]}, and in brackets the time; bold: on "
        "the front.",
        "",
        f"| setting | {' | '.join(curves)} |",
        f"|---|{'---|' * len(curves)}",
    ]
    for (series, label), row in shared.items():
        name = f"{series}: {label}" if series else label
        lines.append(f"| {name} | {' | '.join(_cell(row.get(body)) for body in curves)} |")
    return [*lines, ""]


def _cell(point: Point | None) -> str:
    if point is None or not point.repeats:
        return ""
    time_name = picture.time_name(point.time_s)
    if len(point.failures) == point.repeats:
        return f"failed ({time_name})"
    text = f"{point.error:.2g} ({time_name})"
    return f"**{text}**" if point.on_front else text


def _troubles(curves: Mapping[str, Curve]) -> list[str]:
    """What failed, by point; what the time left out, counted for each body."""
    lines = []
    for body, curve in curves.items():
        late = 0
        for point in curve.points:
            late += point.not_reached
            troubles = page.troubles(vars(replace(point, not_reached=0)))
            if troubles:
                name = f"{point.series}, {point.label}" if point.series else point.label
                lines.append(f"- {body}, {name}: {'; '.join(troubles)}")
        if late:
            lines.append(f"- {body}: {late} runs that the time limit left out")
    if not lines:
        return []
    return [
        f"<details><summary>What failed or was left out: {len(lines)}</summary>",
        "",
        *lines,
        "",
        "</details>",
        "",
    ]


def main() -> None:
    """Measure, draw and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", default=",".join(BODIES), help="default: %(default)s")
    parser.add_argument("--knobs", help="default: all")
    parser.add_argument("--quick", action="store_true", help="the settings of ifa tradeoff --quick")
    parser.add_argument("--repeats", type=int, default=5, help="default: %(default)s")
    parser.add_argument("--out", type=Path, default=_FOLDER, help="default: docs")
    options = parser.parse_args()
    knobs = None if options.knobs is None else options.knobs.split(",")

    reports: dict[str, ifa.TradeoffReport] = {}
    for name in options.bodies.split(","):
        body = ifa.bodies.get(name)
        reports[name] = ifa.tradeoff(
            body,
            throw(body),
            quick=options.quick,
            knobs=knobs,
            repeats=options.repeats,
            time_limit_s=TIME_LIMIT_S,
            seed=SEED,
            command="make accuracy",
        )
        print(f"{name}: {reports[name].measured_s:.0f} s", flush=True)

    images = options.out / "images"
    images.mkdir(parents=True, exist_ok=True)
    for old in images.glob("accuracy_*.png"):
        old.unlink()
    studies = dict.fromkeys(c.study.knob for report in reports.values() for c in report.curves)
    drawn = [knob for knob in studies if _of(reports, knob)]
    for knob in drawn:
        (images / f"accuracy_{knob}.png").write_bytes(
            small(picture.panels_png(_of(reports, knob), columns=min(3, len(reports))))
        )
    (options.out / "accuracy.md").write_text(page_text(reports, drawn), "utf-8")
    rows = []
    for name, report in reports.items():
        head, *points = table.csv_text(report.curves).splitlines()
        rows += [f"body,{head}"] * (not rows) + [f"{name},{row}" for row in points]
    (options.out / "accuracy.csv").write_text("\n".join(rows) + "\n", "utf-8")


if __name__ == "__main__":
    main()
