"""The work-precision picture: error of a contact's time against the time of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from .report import Row

LEAST_MS = 1e-3  # curves with smaller errors are drawn in a band below, each at a height of its own
# Name in the legend, colour, marker, and where the labels of the coarsest and the finest step stand
# beside their points: offsets in points and alignment.
STYLES = {
    "event": ("event engine", "#d1495b", "o", ((0, 8, "center"), (0, 8, "center"))),
    "ode": ("ODE", "#22313f", "s", ((-5, 4, "right"), (5, -3, "left"))),
    "ode_flight": (
        "ODE, flight in closed form", "#8a8f98", "D", ((-5, -4, "right"), (0, -17, "center")),
    ),
    "bullet": ("Bullet", "#2a7f9e", "^", ((0, 15, "left"), (4, -7, "left"))),
    "mujoco": (
        "MuJoCo (restitution approximate)", "#edae49", "v", ((2, 8, "center"), (5, 4, "left")),
    ),
}  # fmt: skip
_INK = "#22313f"


# The columns of panels: column of the CSV, what the error is of.
_KINDS = (
    ("contact_2_median_ms", "against the common reference"),
    ("own_contact_2_median_ms", "against the engine's own finest step"),
)


def work_precision(rows: Sequence[Row], path: Path) -> None:
    """A panel for each body and kind of error, one curve for each engine, a point for each step."""
    bodies = list(dict.fromkeys(str(row["body"]) for row in rows))
    figure, axes = plt.subplots(
        len(bodies), len(_KINDS), sharex=True, sharey=True, squeeze=False, dpi=110,
        figsize=(12.0, 1.4 + 2.8 * len(bodies)),
    )  # fmt: skip
    for i, body in enumerate(bodies):
        for j, (key, _) in enumerate(_KINDS):
            _panel(axes[i][j], [row for row in rows if row["body"] == body], key)
        axes[i][0].set_ylabel(f"{body}\nmedian error of contact 2, ms", fontsize=9)
    for j, (_, kind) in enumerate(_KINDS):
        axes[0][j].set_title(f"Time of the second contact {kind}", fontsize=10, color=_INK)
        axes[-1][j].set_xlabel("CPU time of a simulation, ms", fontsize=9)
    left, right = axes[0][0].get_xlim()
    axes[0][0].set_xlim(0.6 * left, 1.7 * right)  # room for the labels
    axes[0][0].set_ylim(bottom=0.012 * LEAST_MS)

    handles = []
    for name in dict.fromkeys(str(row["engine"]) for row in rows):
        label, colour, marker, _ = STYLES[name]
        handles.append(plt.Line2D([], [], color=colour, marker=marker, ms=5, lw=1.3, label=label))
    height_in = figure.get_size_inches()[1]
    figure.legend(
        handles=handles, loc="upper center", ncols=len(handles), frameon=False, fontsize=9,
        labelcolor=_INK,
    )  # fmt: skip
    figure.text(
        0.5, 0.1 / height_in, "A point for each step, the coarsest and the finest labelled, in s."
        f" Errors below {1e3 * LEAST_MS:g} microsecond are in the grey band, their size not shown.",
        ha="center", fontsize=8, color=_INK,
    )  # fmt: skip
    figure.tight_layout(rect=(0.0, 0.3 / height_in, 1.0, 1.0 - 0.35 / height_in))
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    plt.close(figure)


def _panel(axes: Axes, rows: Sequence[Row], key: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(color="#e3e7eb", lw=0.6)
    axes.tick_params(labelsize=8)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.axhspan(0.0, LEAST_MS, color="#eef1f4", zorder=0)
    band_ms = iter(LEAST_MS * np.array([0.1, 0.3, 0.04, 0.6, 0.02]))
    for name in dict.fromkeys(str(row["engine"]) for row in rows):
        own = sorted(
            (row for row in rows if row["engine"] == name), key=lambda r: float(r["steps_per_s"])
        )  # type: ignore[arg-type]
        x = np.array([float(row["simulation_ms"]) for row in own])  # type: ignore[arg-type]
        y = np.array([float(row[key]) for row in own])  # type: ignore[arg-type]
        shown = np.isfinite(y)
        shown[-1] &= not key.startswith("own_")  # the finest step against itself
        if not shown.any():
            continue
        _, colour, marker, places = STYLES[name]
        if (y[shown] < LEAST_MS).any():
            height_ms = next(band_ms)
            y = np.where(y < LEAST_MS, height_ms, y)
            places = ((0, -8 if height_ms < 0.2 * LEAST_MS else 8, "center"),) * 2
        axes.plot(x[shown], y[shown], color=colour, marker=marker, ms=4, lw=1.3)
        for k, place in zip(np.flatnonzero(shown)[[0, -1]], places, strict=True):
            axes.annotate(
                f"1/{float(own[k]['steps_per_s']):.0f}", (x[k], y[k]), xytext=place[:2],
                textcoords="offset points", ha=place[2], va="center", fontsize=7, color=colour,
                bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0.0, "pad": 0.4},
            )  # fmt: skip
