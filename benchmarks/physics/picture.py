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

LEAST_MS = 1e-6  # smaller errors are drawn here: a nanosecond
STYLES = {
    "event": ("event engine", "#d1495b", "o"),
    "ode": ("ODE", "#22313f", "s"),
    "ode_flight": ("ODE, flight in closed form", "#8a8f98", "D"),
    "bullet": ("Bullet", "#2a7f9e", "^"),
    "mujoco": ("MuJoCo (restitution approximate)", "#edae49", "v"),
}
_INK = "#22313f"


def work_precision(rows: Sequence[Row], path: Path, contacts: Sequence[int] = (2, 4)) -> None:
    """A panel for each body and contact, one curve for each engine, a point for each step."""
    bodies = list(dict.fromkeys(str(row["body"]) for row in rows))
    figure, axes = plt.subplots(
        len(contacts), len(bodies), sharex=True, sharey=True, squeeze=False, dpi=110,
        figsize=(1.2 + 3.4 * len(bodies), 1.3 + 3.7 * len(contacts)),
    )  # fmt: skip
    for i, contact in enumerate(contacts):
        for j, body in enumerate(bodies):
            own = [row for row in rows if row["body"] == body]
            _panel(axes[i][j], own, f"contact_{contact}_median_ms")
            if i == 0:
                axes[i][j].set_title(body, fontsize=11, color=_INK)
            if i == len(contacts) - 1:
                axes[i][j].set_xlabel("CPU time of a simulation, ms", fontsize=9)
        axes[i][0].set_ylabel(f"error of contact {contact}, ms (median)", fontsize=9)
    names = dict.fromkeys(str(row["engine"]) for row in rows)
    handles = [
        plt.Line2D([], [], color=STYLES[n][1], marker=STYLES[n][2], ms=5, lw=1.3, label=STYLES[n][0])
        for n in names
    ]  # fmt: skip
    figure.legend(
        handles=handles, loc="upper center", ncols=len(handles), frameon=False, fontsize=9,
        labelcolor=_INK,
    )  # fmt: skip
    figure.text(
        0.5, 0.008, "Each point is a step; labels are steps in s. Errors below a nanosecond are"
        " drawn at one, medians of missed contacts are left out.",
        ha="center", fontsize=8, color=_INK,
    )  # fmt: skip
    figure.tight_layout(rect=(0.0, 0.025, 1.0, 0.96))
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
    for name in dict.fromkeys(str(row["engine"]) for row in rows):
        own = sorted(
            (row for row in rows if row["engine"] == name), key=lambda r: float(r["steps_per_s"])
        )  # type: ignore[arg-type]
        x = np.array([float(row["simulation_ms"]) for row in own])  # type: ignore[arg-type]
        y = np.array([float(row[key]) for row in own])  # type: ignore[arg-type]
        shown = np.isfinite(y)
        y = np.maximum(y, LEAST_MS)
        _, colour, marker = STYLES[name]
        axes.plot(x[shown], y[shown], color=colour, marker=marker, ms=4, lw=1.3)
        labelled = [k for k in (0, len(own) - 1) if shown[k]]
        for k in labelled:
            axes.annotate(
                f"1/{float(own[k]['steps_per_s']):.0f}", (x[k], y[k]),  # type: ignore[arg-type]
                xytext=(0, 6), textcoords="offset points", ha="center", fontsize=7, color=colour,
            )  # fmt: skip
