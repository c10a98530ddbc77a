"""The page of a report: everything in one HTML file, which asks the network for nothing."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #22313f; margin: 2em auto; max-width: 1280px;
  padding: 0 1em; }
h1 { font-size: 1.5em; margin-bottom: 0.2em; } h2 { font-size: 1.15em; margin: 0 0 0.3em; }
section { border-top: 1px solid #e3e7eb; padding: 1.2em 0; }
.side { display: flex; flex-wrap: wrap; gap: 1.2em; align-items: flex-start; }
.side img { width: 640px; max-width: 100%; height: auto; }
.side > div { flex: 1 1 420px; overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums; }
th, td { padding: 0.15em 0.7em 0.15em 0; text-align: left; white-space: nowrap; }
th { border-bottom: 1px solid #8a8f98; font-weight: 600; }
td.number { text-align: right; } tr.front { background: #fbf1dd; }
.faint { color: #6b7480; } .failed { color: #b02a40; white-space: normal; }
p.note { max-width: 75em; margin: 0.2em 0 0.8em; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.1em 1em; margin: 0.6em 0; }
dt { color: #6b7480; } dd { margin: 0; }
"""
_UNITS_S = (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6))


def html_text(content: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    """The page of a report's `to_dict`, with the PNG of each study that has one."""
    title = f"Accuracy against time: {content['body']}, {len(content['marks']['events'])} marks"
    facts = {
        **content["circumstances"],
        "repeats": f"{content['repeats']} of each setting, seed {content['seed']}, all in "
        f"{content['measured_s']:.0f} s" + (", quick" if content["quick"] else ""),
    }
    rows = "".join(
        f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in facts.items()
    )
    warning = "" if content["complete"] else (
        '<p class="failed">The time was up before every setting was run as often as asked: '
        "the tables say where.</p>"
    )  # fmt: skip
    sections = "\n".join(_section(curve, pictures) for curve in content["curves"])
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>{escape(title)}</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>{escape(title)}</h1>
<dl>{rows}</dl>
{warning}
<p>Figures are medians, with the least and the largest of all repeats in brackets. Shaded settings
are on the Pareto front: none is both faster and more accurate.</p>
{sections}
</body>
</html>
"""


def _section(curve: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    name = curve["knob"]
    title, points = escape(curve["title"]), curve["points"]
    head = f'<section id="{escape(name)}">\n<h2>{title}</h2>\n'
    head += f'<p class="note faint">{escape(curve["note"])}</p>\n'
    if not points:
        return f"{head}</section>"
    picture = ""
    if name in pictures:
        data = base64.b64encode(pictures[name]).decode("ascii")
        alt = f"{title}: {escape(curve['error_name'])} over time"
        picture = f'<img src="data:image/png;base64,{data}" alt="{alt}">'
    table = _table(curve["error_name"], points)
    return f'{head}<div class="side">\n{picture}\n<div>{table}</div>\n</div>\n</section>'


def _table(error_name: str, points: Sequence[Mapping[str, Any]]) -> str:
    with_series = any(point["series"] for point in points)
    names = ["series"] * with_series + ["setting", "time", error_name, "succeeded", ""]
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    return f"<table>\n<tr>{head}</tr>\n{''.join(_row(p, with_series) for p in points)}</table>"


def _row(point: Mapping[str, Any], with_series: bool) -> str:
    cells = [f"<td>{escape(point['series'])}</td>"] if with_series else []
    cells.append(f"<td>{escape(point['label'])}</td>")
    cells.append(f'<td class="number">{_time(point["time_s"], point["time_range_s"])}</td>')
    cells.append(f'<td class="number">{_spread(point["error"], point["error_range"], 1.0)}</td>')
    good = point["repeats"] - len(point["failures"])
    cells.append(f'<td class="number">{good} of {point["repeats"]}</td>')
    cells.append(f'<td class="failed">{escape("; ".join(troubles(point)))}</td>')
    front = ' class="front"' if point["on_front"] else ""
    return f"<tr{front}>{''.join(cells)}</tr>\n"


def troubles(point: Mapping[str, Any]) -> list[str]:
    """What went wrong with a setting, in words; empty where nothing did."""
    asked = point["repeats"] + point["not_reached"]
    out = []
    for failure in dict.fromkeys(point["failures"]):
        count = point["failures"].count(failure)
        out.append(f"failed {count} of {point['repeats']} times: {failure}")
    out += point["losses"]
    if point["not_reached"]:
        out.append(f"the time was up: {point['repeats']} of {asked} repeats run")
    return out


def _time(time_s: float | None, range_s: Sequence[float | None]) -> str:
    if time_s is None:
        return "&ndash;"
    unit, scale = next((u for u in _UNITS_S if time_s >= u[1]), _UNITS_S[-1])
    return f"{_spread(time_s, range_s, scale)} {unit}"


def _spread(value: float | None, ends: Sequence[float | None], scale: float) -> str:
    if value is None:
        return "&ndash;"
    low, high = (_figure((end or 0.0) / scale) for end in ends)
    return f'{_figure(value / scale)} <span class="faint">[{low}, {high}]</span>'


def _figure(value: float) -> str:
    return f"{value:.3g}"
