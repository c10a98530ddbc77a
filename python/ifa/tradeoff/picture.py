"""The picture of a curve: error over time, both logarithmic, with what failed at the edges.

Needs matplotlib (`pip install ifa[plot]`), which is loaded only when a picture is drawn.
"""

from __future__ import annotations

import io
import math
import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ifa._core import IfaError
from ifa.tradeoff.curve import Curve, Point, Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INK, _FAINT, _GRID, _FRONT, _FAILED = "#22313f", "#8a8f98", "#e3e7eb", "#edae49", "#d1495b"
_COLOURS = ("#2a7f9e", "#8a4f7d", "#5d9e84", "#b5651d", "#4c5b8f", "#777777")
_MARKERS = ("o", "s", "^", "D", "v", "P")
_SIZE_IN, _PANEL_IN, _DPI = (6.8, 4.3), (4.0, 2.75), 100
_MARGIN = 1.9  # factor beyond the outermost points, for bars and labels
# Where the label of a point may stand: offset in points, alignment.
_PLACES = (
    (0, 7, "center", "bottom"), (0, -7, "center", "top"), (7, 0, "left", "center"),
    (-7, 0, "right", "center"), (6, 6, "left", "bottom"), (-6, 6, "right", "bottom"),
    (6, -6, "left", "top"), (-6, -6, "right", "top"),
    (0, 17, "center", "bottom"), (0, -17, "center", "top"),
)  # fmt: skip


def check_matplotlib() -> None:
    """Raise IfaError where no picture could be drawn."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise IfaError(
            "pictures of a trade-off need matplotlib: pip install ifa[plot], or leave out the "
            "folder and take the figures alone"
        ) from error


def drawing_time_s() -> float:
    """How long one picture takes, here and now: of a made-up curve, drawn twice."""
    points = tuple(
        Point(
            f"setting {k}", "", 2.0**k, (2.0**k, 3.0**k), 3.0**-k, (4.0**-k, 3.0**-k), 3, (), True
        )
        for k in range(8)
    )
    took_s = 0.0
    for _ in range(2):  # the first time loads matplotlib and its fonts
        began_s = time.perf_counter()
        png(Curve(Study("drawing", "Drawing", "error", ()), points))
        took_s = time.perf_counter() - began_s
    return took_s


def png(curve: Curve) -> bytes:
    """The picture of a curve with points."""
    figure, renderer = _new_figure(_SIZE_IN)
    axes = figure.add_subplot()
    figure.subplots_adjust(left=0.12, right=0.975, top=0.83, bottom=0.135)
    _draw(axes, curve, renderer)
    _title(figure, curve.study.title, 0.12, 0.945, 0.875)
    return _bytes(figure)


def panels_png(curves: Mapping[str, Curve], columns: int = 3) -> bytes:
    """The same study on several scenes, by name: a panel for each."""
    rows = -(-len(curves) // columns)
    height_in = 0.9 + _PANEL_IN[1] * rows
    width_in = max(_PANEL_IN[0] * columns, _SIZE_IN[0])  # room for the legend
    left = 0.75 / width_in
    figure, renderer = _new_figure((width_in, height_in))
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    figure.subplots_adjust(
        left=left, right=0.99, top=1.0 - 0.85 / height_in, bottom=0.48 / height_in, wspace=0.24,
        hspace=0.38,
    )  # fmt: skip
    for axes in grid[len(curves) :]:
        axes.set_axis_off()
    for k, (axes, (name, curve)) in enumerate(zip(grid, curves.items(), strict=False)):
        _draw(axes, curve, renderer)
        axes.set_title(name, fontsize=9.5, color=_INK, loc="left", pad=4)
        if k % columns:
            axes.set_ylabel("")
        if k < len(curves) - columns:
            axes.set_xlabel("")
    title = next(iter(curves.values())).study.title
    _title(figure, title, left, 1.0 - 0.2 / height_in, 1.0 - 0.46 / height_in)
    return _bytes(figure)


def _new_figure(size_in: tuple[float, float]) -> tuple[Figure, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size_in, dpi=_DPI, facecolor="white")
    return figure, FigureCanvasAgg(figure).get_renderer()  # which measures the labels


def _title(figure: Figure, title: str, x: float, y: float, legend_y: float) -> None:
    """The title, and under it one legend of all panels."""
    figure.text(x, y, title, fontsize=11.5, color=_INK, va="center", weight="bold")
    entries: dict[str, Any] = {}
    for axes in figure.axes:
        handles, names = axes.get_legend_handles_labels()
        entries |= dict(zip(names, handles, strict=True))
    figure.legend(
        list(entries.values()), list(entries), loc="center left", frameon=False, fontsize=8,
        bbox_to_anchor=(x - 0.01, legend_y), ncol=max(1, len(entries)), labelcolor=_INK,
        borderpad=0.0, borderaxespad=0.0, columnspacing=1.0, handlelength=1.4, handletextpad=0.5,
    )  # fmt: skip


def _bytes(figure: Figure) -> bytes:
    out = io.BytesIO()
    figure.savefig(out, format="png", metadata={"Software": None})
    return out.getvalue()


def _draw(axes: Axes, curve: Curve, renderer: Any) -> None:
    shown = [point for point in curve.points if math.isfinite(point.error)]
    failed = [
        point
        for point in curve.points
        if not math.isfinite(point.error) and math.isfinite(point.time_s)
    ]
    axes.set_xscale("log")
    axes.set_yscale("log")
    positive = [value for p in shown for value in (p.error, *p.error_range) if value > 0.0]
    floor = 0.4 * min(positive, default=1.0)
    has_zero = any(point.error <= 0.0 for point in shown)
    zero = floor / _MARGIN  # where points without any error are drawn
    _set_limits(axes, [*shown, *failed], positive, zero if has_zero else None)
    if has_zero:
        axes.axhspan(axes.get_ylim()[0], floor, color="#eef1f4", zorder=0)
        axes.text(
            0.006, 0.012, "no error", transform=axes.transAxes, fontsize=7, color=_FAINT,
            va="bottom",
        )  # fmt: skip

    places: dict[int, tuple[float, float]] = {
        id(point): (point.time_s, max(point.error, 0.0) or zero) for point in shown
    }
    front = sorted((point for point in shown if point.on_front), key=lambda point: point.time_s)
    if len(front) > 1:
        axes.step(
            *zip(*(places[id(point)] for point in front), strict=True), where="post",
            color=_FRONT, lw=5.0, alpha=0.55, zorder=1, label="Pareto front",
        )  # fmt: skip
    series = list(dict.fromkeys(point.series for point in curve.points))
    for k, name in enumerate(series):
        own = [point for point in shown if point.series == name]
        _draw_series(axes, own, places, name, k, floor)
    lossy = [places[id(point)] for point in shown if point.losses or point.failures]
    if lossy:
        axes.plot(
            *zip(*lossy, strict=True), "x", color=_FAILED, ms=10, mew=1.6, zorder=4,
            label="in part failed",
        )  # fmt: skip
    low, high = axes.get_ylim()
    top = high * (low / high) ** 0.07  # a little below the edge
    if failed:
        axes.plot(
            [point.time_s for point in failed], [top] * len(failed), "X", color=_FAILED, ms=8,
            zorder=4, clip_on=False, label="failed",
        )  # fmt: skip
        places |= {id(point): (point.time_s, top) for point in failed}
    _dress(axes, curve)
    colours = {name: _colour(k) for k, name in enumerate(series)}
    _label(
        axes,
        [(places[id(p)], p.label, colours[p.series]) for p in shown]
        + [(places[id(p)], p.label, colours[p.series]) for p in failed],
        renderer,
    )
    if not shown:
        axes.set_yticks([], [])
        axes.set_yticks([], [], minor=True)
    left_out = [
        f"{point.series}, {point.label}" if point.series else point.label
        for point in curve.points
        if not point.repeats
    ]
    if left_out:
        more = f" and {len(left_out) - 3} more" if len(left_out) > 3 else ""
        axes.text(
            0.99, 0.02, f"not reached in time: {'; '.join(left_out[:3])}{more}", color=_FAILED,
            transform=axes.transAxes, ha="right", fontsize=7,
        )  # fmt: skip


def _set_limits(
    axes: Axes, drawn: Sequence[Point], positive: Sequence[float], zero: float | None
) -> None:
    times_s = [value for point in drawn for value in (point.time_s, *point.time_range_s)]
    times_s = [value for value in times_s if value > 0.0] or [1.0]
    low_s, high_s = min(times_s), max(times_s)
    room = max(1.25, (high_s / low_s) ** 0.12)
    axes.set_xlim(low_s / room, high_s * room)
    low, high = min(positive, default=1.0), max(positive, default=1.0)
    room = max(1.6, (high / low) ** 0.14)
    axes.set_ylim(low / room if zero is None else zero / _MARGIN, high * room)


def _draw_series(
    axes: Axes,
    points: Sequence[Point],
    places: dict[int, tuple[float, float]],
    name: str,
    index: int,
    floor: float,
) -> None:
    """Markers joined by a line where the series has a name, with bars from least to most.

    One without points is only in the legend.
    """
    x, y = [places[id(p)][0] for p in points], [places[id(p)][1] for p in points]
    colour = _colour(index)
    axes.plot(
        x, y, ls="-" if name else "", color=colour, marker=_MARKERS[index % len(_MARKERS)], ms=4.5,
        lw=1.2, zorder=3, label=name or None,
    )  # fmt: skip
    for point, here_s, here in zip(points, x, y, strict=True):
        axes.plot(point.time_range_s, (here, here), color=colour, lw=0.9, alpha=0.7, zorder=2)
        if point.error_range[1] > 0.0:
            ends = [max(end, floor) for end in point.error_range]
            axes.plot((here_s, here_s), ends, color=colour, lw=0.9, alpha=0.7, zorder=2)


def _colour(index: int) -> str:
    return _COLOURS[index % len(_COLOURS)]


def _dress(axes: Axes, curve: Curve) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for axis, unit in ((axes.xaxis, "s"), (axes.yaxis, "")):
        low, high = sorted(axis.get_view_interval())
        decades = math.log10(high / low)
        subs = (
            (1.0,) if decades > 2.2 else (1.0, 2.0, 5.0) if decades > 0.7 else tuple(range(1, 10))
        )
        axis.set_major_locator(LogLocator(subs=subs, numticks=12))
        axis.set_major_formatter(FuncFormatter(time_name if unit else _error_name))
        axis.set_minor_locator(LogLocator(subs=tuple(range(1, 10)), numticks=12))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(color=_GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8, colors=_INK, which="both", width=0.6)
    axes.set_xlabel("time", fontsize=9, color=_INK, labelpad=2)
    axes.set_ylabel(curve.study.error_name, fontsize=9, color=_INK, labelpad=2)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(_FAINT)


def _error_name(error: float, _: Any) -> str:
    if 1e-4 <= error < 1e5:
        return f"{error:.3g}" if error < 1e3 else f"{error:,.0f}"
    exponent = math.floor(math.log10(error) + 1e-9)
    leading = round(error / 10.0**exponent)
    return f"$10^{{{exponent}}}$" if leading == 1 else f"${leading}\\cdot 10^{{{exponent}}}$"


def time_name(time_s: float, _: Any = None) -> str:
    """A time in the unit that suits it; matplotlib's tickers give the position as well."""
    for unit, scale in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if time_s >= 0.999 * scale:
            return f"{time_s / scale:.3g} {unit}"
    return f"{time_s / 1e-9:.3g} ns"


def _label(
    axes: Axes, labels: Sequence[tuple[tuple[float, float], str, str]], renderer: Any
) -> None:
    """Write each label beside its point, where it covers as little as it can."""
    from matplotlib.transforms import Bbox

    markers = [axes.transData.transform(place) for place, _, _ in labels]
    taken = [Bbox.from_bounds(x - 5, y - 5, 10, 10) for x, y in markers]
    inside = axes.get_window_extent(renderer)
    for (place, text, colour), _ in zip(labels, markers, strict=True):
        best, least = None, math.inf
        for rank, (dx, dy, ha, va) in enumerate(_PLACES):
            note = axes.annotate(
                text, place, xytext=(dx, dy), textcoords="offset points", ha=ha, va=va,
                fontsize=7, color=colour, zorder=5, annotation_clip=False,
            )  # fmt: skip
            box = note.get_window_extent(renderer)
            covered = sum(_overlap(box, other) for other in taken)
            outside = box.width * box.height - _overlap(box, inside)
            cost = covered + 3.0 * outside + 0.5 * rank
            if cost < least:
                if best is not None:
                    best.remove()
                best, least, chosen = note, cost, box
            else:
                note.remove()
        taken.append(chosen)


def _overlap(a: Any, b: Any) -> float:
    width = min(a.x1, b.x1) - max(a.x0, b.x0)
    height = min(a.y1, b.y1) - max(a.y0, b.y0)
    return max(width, 0.0) * max(height, 0.0)
