"""Where and with what it was measured, the tables, and the CSV files."""

from __future__ import annotations

import csv
import os
import platform
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np

Row = dict[str, object]


def machine(lines: Sequence[str]) -> list[str]:
    """Lines that name the machine and the versions, then `lines`."""
    return [
        f"processor: {_processor()}, {os.cpu_count()} cores",
        f"system: {_system()}, {platform.machine()}; compiler: {_compiler()}",
        f"Python {platform.python_version()}, numpy {np.__version__}",
        *lines,
    ]


def write_csv(path: Path, header: Sequence[str], rows: Sequence[Row]) -> None:
    """The rows, below the header as lines that begin with `# `."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"# {line}\n" for line in header)
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(
            {k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows
        )


def read_csv(path: Path) -> list[Row]:
    """What `write_csv` wrote, numbers as floats."""
    with path.open(newline="", encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("# ")]
    return [{k: _number(v) for k, v in row.items()} for row in csv.DictReader(lines)]


COMPARISON_HEADER = (
    f"{'body':7} {'engine':10} {'step s':>8} {'sims/s':>8} "
    f"{'contact 1':>15} {'contact 2':>15} {'contact 3':>15} {'contact 4':>15} "
    f"{'gain':>8} {'>1 %':>6} {'depth mm':>13} {'rest':>6}\n"
    f"{'':7} {'':10} {'':>8} {'':>8} {'error, ms: median, 90th percentile':^63} "
    f"{'largest':>8} {'share':>6} {'median, most':>13} {'share':>6}"
)


def comparison_line(row: Row) -> str:
    contacts = " ".join(
        f"{_short(row[f'contact_{k}_median_ms']):>7} {_short(row[f'contact_{k}_p90_ms']):>7}"
        for k in range(1, 5)
    )
    depth = f"{_short(row['penetration_median_mm']):>6} {_short(row['penetration_largest_mm']):>6}"
    return (
        f"{row['body']:7} {row['engine']:10} {'1/' + format(row['steps_per_s'], '.0f'):>8} "
        f"{row['simulations_per_s']:8.0f} {contacts} {_short(row['energy_gain_largest']):>8} "
        f"{100 * _float(row['energy_gain_notable_share']):5.0f}% {depth} "
        f"{100 * _float(row['rest_share']):5.0f}%"
        + (f"  {row['failed']} failed" if row["failed"] else "")
    )


def summary(rows: Sequence[Row], steps_per_s: int) -> str:
    """A table in Markdown of all bodies and engines at one step, for docs/physics.md."""
    lines = [
        "| body | engine | simulations/s | error of contact 1, 2, 3, 4: median, ms | contact 2: "
        "90th percentile, ms | largest energy gain | penetration: median, largest, mm | at rest |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        if row["steps_per_s"] == steps_per_s:
            contacts = ", ".join(_short(row[f"contact_{k}_median_ms"]) for k in range(1, 5))
            depths = ", ".join(
                _short(row[f"penetration_{which}_mm"]) for which in ("median", "largest")
            )
            lines.append(
                f"| {row['body']} | {row['engine']} | {row['simulations_per_s']:.0f} | {contacts} "
                f"| {_short(row['contact_2_p90_ms'])} "
                f"| {100.0 * _float(row['energy_gain_largest']):.2g} % "
                f"| {depths} | {100.0 * _float(row['rest_share']):.0f} % |"
            )
    return "\n".join(lines) + "\n"


def _short(value: object) -> str:
    number = _float(value)
    if not np.isfinite(number):
        return "missed" if np.isinf(number) else "-"
    return f"{number:.1e}" if 0.0 < abs(number) < 1e-3 else f"{number:.3g}"


def _float(value: object) -> float:
    return float(value)  # type: ignore[arg-type]


def _number(text: str) -> object:
    try:
        return float(text)
    except ValueError:
        return text


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        fields = {}
        for line in info.read_text(encoding="utf-8").split("\n\n")[0].splitlines():
            key, _, value = line.partition(":")
            fields[key.strip()] = value.strip()
        if "model name" in fields:
            family, model = fields.get("cpu family", "?"), fields.get("model", "?")
            return f"{fields['model name']} (family {family}, model {model})"
    return platform.processor() or "unknown"


def _system() -> str:
    try:
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        return platform.platform()


def _compiler() -> str:
    try:
        done = subprocess.run(["c++", "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return done.stdout.splitlines()[0]
