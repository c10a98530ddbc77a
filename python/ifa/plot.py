"""Pictures of a solution: how its hits meet the sound, and what the body does.

Needs matplotlib (`pip install ifa[plot]`), which is loaded only when a picture is drawn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ifa._core import IfaError, IfaFileError
from ifa.arguments import positive
from ifa.body import Body
from ifa.marks import Signature
from ifa.solution import Solution
from ifa.sound import FilePath, file_name, read_sound

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INK, _FAINT, _PAPER = "#22313f", "#9aa5b1", "#ffffff"
_MARK, _HIT, _WAVE, _CENTRE = "#d1495b", "#22313f", "#8fa9c0", "#edae49"
_FACTOR_NAMES = ("velocity", "orientation", "time", "amplitude", "length", "centroid")
_WIDTH_IN, _DPI = 12.0, 110


def plot_solution(solution: Solution, sound: FilePath | None = None, path: FilePath = "") -> None:
    """Draw the sound's waveform with the marks and achieved hits, and every factor of each event.

    Args:
        solution: What `ifa.solve` returned.
        sound: The sound that was marked. Without it the marks' amplitudes are drawn alone.
        path: The picture; its ending (.png, .svg, .pdf) says the format.

    Raises:
        IfaFileError: The sound cannot be read or the picture not be written.
        IfaError: matplotlib is not installed.
    """
    wave = None if sound is None else read_sound(sound)
    count = len(solution.events)
    figure = _new_figure(6.4)
    top, links, cells = figure.subplots(
        3, 1, gridspec_kw={"height_ratios": [2.4, 0.35, 2.6], "hspace": 0.0}
    )
    figure.subplots_adjust(left=0.09, right=0.985, top=0.895, bottom=0.07)
    begin_s, end_s = _shown_span(solution, wave)

    if wave is not None:
        _draw_wave(top, *wave, begin_s, end_s)
        top.set_ylabel("sound")
    else:
        top.set_ylabel("amplitude")
    _draw_marks(top, solution.marks, with_stems=wave is None)
    achieved = [event.achieved_s for event in solution.events]
    top.plot(
        achieved, np.full(count, -1.0), "^", color=_HIT, markersize=6, clip_on=False, zorder=5,
        label="achieved hit",
    )  # fmt: skip
    top.set_xlim(begin_s, end_s)
    top.set_ylim(-1.0, 1.12)
    top.set_yticks([])
    top.xaxis.tick_top()
    top.xaxis.set_label_position("top")
    _strip_frame(top, keep=("top",))
    top.text(-0.008, 1.05, "time in s", transform=top.transAxes, ha="right", fontsize=9, color=_INK)
    figure.legend(
        loc="upper right", ncols=3, fontsize=9, frameon=False, bbox_to_anchor=(0.99, 1.0),
        labelcolor=_INK,
    )  # fmt: skip

    _draw_links(links, achieved, begin_s, end_s)
    _draw_cells(cells, solution)
    figure.suptitle(_headline(solution), x=0.09, y=0.975, ha="left", fontsize=11, color=_INK)
    _save(figure, path)


def plot_strobe(solution: Solution, path: FilePath, frames_per_s: float = 60.0) -> None:
    """Draw the body from the side at `frames_per_s`, and its heights over time with the marks.

    The side view looks across the direction in which the body travels most, at equal scales.

    Args:
        solution: What `ifa.solve` returned.
        path: The picture; its ending (.png, .svg, .pdf) says the format.
        frames_per_s: Silhouettes for each second.

    Raises:
        IfaFileError: The picture cannot be written.
        IfaError: matplotlib is not installed.
    """
    motion, body, marks = solution.motion, solution.body, solution.marks
    times_s = np.arange(motion.start_s, motion.end_s, 1.0 / positive(frames_per_s, "frames_per_s"))
    fine_s = np.linspace(motion.start_s, motion.end_s, 4000)
    heights_m, lowest_m, along = _heights(body, *motion.sample(fine_s))
    outlines = [
        _outline(body, position, quaternion, along)
        for position, quaternion in zip(*motion.sample(times_s), strict=True)
    ]
    corners = 1e3 * np.concatenate(outlines)
    low, high = corners.min(axis=0), corners.max(axis=0)
    ground = 0.07 * high[1]  # room below it
    width_mm, height_mm = 1.04 * (high[0] - low[0]), 1.05 * high[1] + ground
    panel_in = 0.92 * _WIDTH_IN
    side_in = float(np.clip(panel_in * height_mm / width_mm, 1.0, 3.6))
    scale = max(width_mm / panel_in, height_mm / side_in)  # equal for both directions
    height_in = side_in + 4.2
    figure = _new_figure(height_in)
    side = figure.add_axes((0.065, 1.0 - (0.5 + side_in) / height_in, 0.92, side_in / height_in))
    below = figure.add_axes((0.065, 0.5 / height_in, 0.92, 2.55 / height_in))

    _draw_silhouettes(side, outlines, times_s, solution)
    positions, _ = motion.sample(fine_s)
    side.plot(
        1e3 * (positions[:, :2] @ along), 1e3 * positions[:, 2], color=_INK, lw=0.7, alpha=0.6
    )
    middle = 0.5 * (low[0] + high[0])
    side.set_xlim(middle - 0.5 * scale * panel_in, middle + 0.5 * scale * panel_in)
    side.set_ylim(-ground, scale * side_in - ground)
    _draw_contact_places(side, solution, along, ground)
    side.set_xlabel("along the motion in mm", labelpad=2)
    side.set_ylabel("height in mm")
    _strip_frame(side, keep=("left", "bottom"))

    widths = _mark_widths(marks)
    for time_s, duration_s, width in zip(marks.times_s, marks.durations_s, widths, strict=True):
        if duration_s > 0:
            below.axvspan(time_s, time_s + duration_s, color=_MARK, alpha=0.15, lw=0)
        below.axvline(time_s, color=_MARK, lw=width, alpha=0.85)
    below.plot([], [], color=_MARK, lw=2, label="mark (width: loudness)")
    below.plot(fine_s, 1e3 * heights_m, color=_CENTRE, lw=1.8, label="centre of mass")
    below.plot(fine_s, 1e3 * lowest_m, color=_INK, lw=1.4, label="lowest point")
    below.set_xlim(motion.start_s, motion.end_s)
    below.set_ylim(-1e3 * 0.03 * heights_m.max(), 1e3 * 1.06 * heights_m.max())
    below.set_xlabel("time in s", labelpad=2)
    below.set_ylabel("height in mm")
    _strip_frame(below, keep=("left", "bottom"))
    title = (
        f"{body.name} from the side, {frames_per_s:g} frames a second; red: contacts at the marks"
    )
    figure.text(0.065, 1.0 - 0.3 / height_in, title, fontsize=11, color=_INK)
    figure.legend(
        loc="upper right", ncols=3, fontsize=9, frameon=False, labelcolor=_INK,
        bbox_to_anchor=(0.99, 1.0 - 0.06 / height_in),
    )  # fmt: skip
    _save(figure, path)


def _new_figure(height_in: float) -> Figure:
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise IfaError("pictures need matplotlib: pip install matplotlib") from error
    return Figure(figsize=(_WIDTH_IN, height_in), dpi=_DPI, facecolor=_PAPER)


def _save(figure: Figure, path: FilePath) -> None:
    name = file_name(path)
    try:
        figure.savefig(name)
    except OSError as error:
        raise IfaFileError(f"{name}: cannot be written: {error.strerror or error}") from None
    except ValueError as error:  # an ending that is no picture's
        raise IfaFileError(f"{name}: cannot be written: {error}") from None


def _strip_frame(axes: Axes, keep: tuple[str, ...]) -> None:
    for side, spine in axes.spines.items():
        spine.set_visible(side in keep)
        spine.set_color(_FAINT)
    axes.tick_params(colors=_INK, labelsize=9, width=0.6, length=3)
    for label in (axes.xaxis.label, axes.yaxis.label):
        label.set_color(_INK)
        label.set_fontsize(9.5)


def _headline(solution: Solution) -> str:
    state = "succeeded" if solution.succeeded else "not succeeded"
    return (
        f"{solution.body.name}, {len(solution.events)} marks: {state}, "
        f"{'plausible' if solution.plausible else 'not plausible'}, score {solution.score:.2f}, "
        f"worst error {1e3 * solution.max_abs_error_s:.2f} ms"
    )


def _shown_span(
    solution: Solution, wave: tuple[NDArray[np.float64], int] | None
) -> tuple[float, float]:
    marks = solution.marks
    first, last = marks.times_s[0], marks.times_s[-1] + marks.durations_s[-1]
    margin = 0.06 * max(last - first, 0.1)
    end = last + 3 * margin
    if wave is not None:
        end = min(end, max(len(wave[0]) / wave[1], last + margin))
    return first - margin, end


def _draw_wave(
    axes: Axes, samples: NDArray[np.float64], rate_hz: int, begin_s: float, end_s: float
) -> None:
    """The envelope between lowest and highest sample in each of some 2000 columns."""
    first, last = max(0, int(begin_s * rate_hz)), min(len(samples), int(end_s * rate_hz))
    shown = samples[first:last]
    if not len(shown):
        return
    step = max(1, len(shown) // 2000)
    whole = shown[: len(shown) // step * step].reshape(-1, step)
    peak = max(float(np.abs(shown).max()), 1e-12)
    times_s = (first + step * (0.5 + np.arange(len(whole)))) / rate_hz
    axes.fill_between(
        times_s, whole.min(axis=1) / peak, whole.max(axis=1) / peak, color=_WAVE, lw=0.5,
    )  # fmt: skip
    axes.axhline(0.0, color=_WAVE, lw=0.5)


def _draw_marks(axes: Axes, marks: Signature, with_stems: bool) -> None:
    heights = np.ones(len(marks))
    if with_stems and marks.amplitudes is not None:
        heights = 2.0 * marks.amplitudes / marks.amplitudes.max()
    elif with_stems:
        heights = np.full(len(marks), 2.0)
    rows = zip(marks.times_s, marks.durations_s, heights, strict=True)
    for k, (time_s, duration_s, height) in enumerate(rows):
        if duration_s > 0:
            axes.axvspan(time_s, time_s + duration_s, color=_MARK, alpha=0.15, lw=0)
        top = height - 1.0 if with_stems else 1.0
        axes.plot([time_s] * 2, [-1.0, top], color=_MARK, lw=1.3, label="" if k else "mark")


def _draw_links(axes: Axes, times_s: list[float], begin_s: float, end_s: float) -> None:
    """From each hit's time to its column below: hits crowd, columns do not."""
    count = len(times_s)
    for k, time_s in enumerate(times_s):
        x = (time_s - begin_s) / (end_s - begin_s)
        column = (k + 0.5) / count
        axes.plot([x, x, column, column], [1.0, 0.88, 0.12, 0.0], color=_FAINT, lw=0.8)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, 1.0)
    axes.set_axis_off()


def _draw_cells(axes: Axes, solution: Solution) -> None:
    from matplotlib.colors import LinearSegmentedColormap

    good = LinearSegmentedColormap.from_list(
        "agreement", ["#d1495b", "#f3d9a4", "#cfe3d4", "#5d9e84"]
    )
    count = len(solution.events)
    factors = np.array(
        [[event.factors[name] for event in solution.events] for name in _FACTOR_NAMES]
    )
    # The last rows are red at twice of what a plausible motion may have at most.
    notes = (
        ("error, ms", [1e3 * e.error_s for e in solution.events], 20.0, 1),
        ("retiming, %", [100.0 * (e.retime - 1.0) for e in solution.events], 14.0, 1),
        ("excess", [e.excess for e in solution.events], 2.0, 2),
    )
    size = float(np.clip(170.0 / count, 5.0, 9.0))
    rows = [*factors, *[1.0 - np.minimum(np.abs(v) / limit, 1.0) for _, v, limit, _ in notes]]
    axes.imshow(
        np.array(rows), cmap=good, vmin=0.0, vmax=1.0, aspect="auto",
        extent=(0.0, count, len(rows), 0.0),
    )  # fmt: skip
    texts: list[list[str]] = [[f"{value:.2f}" for value in row] for row in factors]
    texts += [
        [f"{round(v, digits) + 0.0:.{digits}f}" for v in values] for _, values, _, digits in notes
    ]
    for r, row in enumerate(texts):
        for c, text in enumerate(row):
            axes.text(c + 0.5, r + 0.5, text, ha="center", va="center", fontsize=size, color=_INK)
    for c in range(1, count):
        axes.axvline(c, color=_PAPER, lw=1.5)
    for r in range(1, len(rows)):
        axes.axhline(r, color=_PAPER, lw=5.0 if r == len(factors) else 1.5)
    axes.set_yticks(0.5 + np.arange(len(rows)), [*_FACTOR_NAMES, *[name for name, *_ in notes]])
    axes.set_xticks(0.5 + np.arange(count), [str(k + 1) for k in range(count)])
    axes.set_xlabel("mark (factors: 1 is perfect)", labelpad=2)
    _strip_frame(axes, keep=())
    axes.tick_params(length=0)


def _mark_widths(marks: Signature) -> NDArray[np.float64]:
    if marks.amplitudes is None:
        return np.full(len(marks), 1.2)
    return 0.5 + 3.0 * np.sqrt(marks.amplitudes / marks.amplitudes.max())


def _rotations(quaternions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4) wxyz."""
    w, x, y, z = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _heights(
    body: Body, positions: NDArray[np.float64], quaternions: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Heights (n,) of the centre and the lowest point, and the direction (2,) of most travel."""
    down = _rotations(quaternions)[:, 2, :] @ body.outline_m.T
    lowest = positions[:, 2] + down.min(axis=1) - body.radius_m
    spread = positions[:, :2] - positions[:, :2].mean(axis=0)
    along = np.linalg.svd(spread, full_matrices=False)[2][0]
    forward = (positions[-1, :2] - positions[0, :2]) @ along
    return positions[:, 2], lowest, along if forward >= 0 else -along


def _outline(
    body: Body,
    position: NDArray[np.float64],
    quaternion: NDArray[np.float64],
    along: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Corners (k, 2) of the rounded hull's silhouette."""
    points = body.outline_m @ _rotations(quaternion[None])[0].T + position
    flat = np.column_stack([points[:, :2] @ along, points[:, 2]])
    angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    disc = body.radius_m * np.column_stack([np.cos(angle), np.sin(angle)])
    return _hull_2d((flat[:, None, :] + disc).reshape(-1, 2) if body.radius_m > 0 else flat)


def _hull_2d(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The convex hull, by Andrew's monotone chain."""
    ordered = sorted(set(map(tuple, points.tolist())))

    def chain(row: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for p in row:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2:]
                if (bx - ax) * (p[1] - ay) > (by - ay) * (p[0] - ax):
                    break
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _draw_silhouettes(
    axes: Axes, outlines: list[NDArray[np.float64]], times_s: NDArray[np.float64], solution: Any
) -> None:
    from matplotlib import colormaps
    from matplotlib.colors import to_rgba

    shade = (times_s - times_s[0]) / max(times_s[-1] - times_s[0], 1e-12)
    axes.axhline(0.0, color=_INK, lw=1.0, zorder=0)
    drawn = None
    for outline, s in zip(outlines, shade, strict=True):
        size = np.ptp(outline, axis=0)
        box = np.concatenate([outline.min(axis=0), outline.max(axis=0)])
        if drawn is not None and np.abs(box - drawn).max() < 0.005 * size.max():
            continue  # at rest, where silhouettes would only pile up
        drawn = box
        colour = colormaps["viridis"](0.08 + 0.84 * s)
        axes.fill(
            *(1e3 * outline.T), facecolor=to_rgba(colour, 0.28), edgecolor=to_rgba(colour, 0.95),
            lw=0.8, joinstyle="round",
        )  # fmt: skip


def _draw_contact_places(
    axes: Axes, solution: Solution, along: NDArray[np.float64], ground: float
) -> None:
    """A stroke under the ground where the body strikes at each mark."""
    body = solution.body
    poses = solution.motion.sample([event.achieved_s for event in solution.events])
    widths = _mark_widths(solution.marks)
    for position, rotation, width in zip(poses[0], _rotations(poses[1]), widths, strict=True):
        points = body.outline_m @ rotation.T + position
        x = 1e3 * points[points[:, 2].argmin(), :2] @ along
        axes.plot([x, x], [-0.15 * ground, -0.85 * ground], color=_MARK, lw=width)
