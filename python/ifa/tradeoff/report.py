"""A report: the curves of one scene, where they were measured, and the folder that shows them."""

from __future__ import annotations

import json
import math
import os
import secrets
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ifa._core import Cancelled, IfaFileError, Progress
from ifa.body import Body
from ifa.marks import Signature
from ifa.sound import FilePath, file_name
from ifa.tradeoff import page, picture, table
from ifa.tradeoff.curve import Curve, Point

_KIND = "ifa tradeoff"
_INDEX = "tradeoff.json"


@dataclass(frozen=True)
class TradeoffReport:
    """What accuracy costs in time on one scene.

    curves: one for each study, in the order of the knobs; one without points says in its study's
    `note` why. circumstances: by name, what a reader must know to compare: the command, when, the
    machine, versions. complete: whether every setting was run as often as asked, which a time
    limit may prevent.
    """

    body: Body
    marks: Signature
    curves: tuple[Curve, ...]
    circumstances: dict[str, str]
    repeats: int
    seed: int
    quick: bool
    measured_s: float = field(compare=False, default=0.0)

    @property
    def complete(self) -> bool:
        """Whether no repeat of any setting was left out."""
        return not any(point.not_reached for curve in self.curves for point in curve.points)

    def to_dict(self) -> dict[str, Any]:
        """What `ifa tradeoff --json` prints: JSON-ready; None where there is no figure."""
        return {
            "kind": _KIND,
            "body": self.body.name,
            "marks": self.marks.to_dict(),
            "seed": self.seed,
            "repeats": self.repeats,
            "quick": self.quick,
            "complete": self.complete,
            "measured_s": self.measured_s,
            "circumstances": self.circumstances,
            "curves": [
                {
                    "knob": curve.study.knob,
                    "title": curve.study.title,
                    "error_name": curve.study.error_name,
                    "note": curve.study.note,
                    "points": [_plain(point) for point in curve.points],
                }
                for curve in self.curves
            ],
        }

    def write(self, out: FilePath, progress: Progress | None = None) -> None:
        """Write the folder `out`: tradeoff.html, tradeoff.csv, a CSV and a PNG of each study.

        An earlier report there is replaced; nothing half-written is left. Raises IfaFileError where
        the folder cannot be written or is something else, IfaError without matplotlib, Cancelled.
        """
        folder = check_folder(out)
        picture.check_matplotlib()
        part = folder.with_name(f"{folder.name}.part-{secrets.token_hex(8)}")
        try:
            try:
                part.mkdir()
                self._fill(part, progress)
                _move_into_place(part, folder)
            finally:
                if part.exists():
                    shutil.rmtree(part)
        except OSError as error:
            raise IfaFileError(f"{folder}: cannot be written: {error.strerror}") from error

    def _fill(self, folder: Path, progress: Progress | None) -> None:
        pictures: dict[str, bytes] = {}
        content = self.to_dict()
        for curve in self.curves:
            if progress is not None and progress.cancelled:
                raise Cancelled("cancelled")
            name = curve.study.knob
            if curve.points:
                pictures[name] = picture.png(curve)
                (folder / f"{name}.png").write_bytes(pictures[name])
            (folder / f"{name}.csv").write_text(table.csv_text([curve]), "utf-8")
        (folder / "tradeoff.csv").write_text(table.csv_text(self.curves), "utf-8")
        (folder / "tradeoff.html").write_text(page.html_text(content, pictures), "utf-8")
        content["files"] = sorted([_INDEX, *(path.name for path in folder.iterdir())])
        (folder / _INDEX).write_text(json.dumps(content, allow_nan=False) + "\n", "utf-8")


def check_folder(out: FilePath) -> Path:
    """The folder of a report: one that can be made, or an earlier report. Else IfaFileError."""
    folder = Path(os.path.abspath(file_name(out)))
    if folder.is_dir():
        there = sorted(path.name for path in folder.iterdir())
        strange = [name for name in there if name not in _files(folder)]
        if strange:
            raise IfaFileError(
                f"{folder}: is not overwritten: {strange[0]} is not of an earlier report"
            )
    elif os.path.lexists(folder):
        raise IfaFileError(f"{folder}: is no folder")
    if not folder.parent.is_dir():
        raise IfaFileError(f"{folder}: there is no folder {folder.parent}")
    if not os.access(folder.parent, os.W_OK):
        raise IfaFileError(f"{folder}: the folder {folder.parent} cannot be written to")
    return folder


def _files(folder: Path) -> list[str]:
    """The files that a report says it consists of; none where there is no report."""
    try:
        content = json.loads((folder / _INDEX).read_bytes())
        files = content["files"] if content["kind"] == _KIND else []
    except (OSError, ValueError, LookupError, TypeError):
        return []
    return files if isinstance(files, list) else []


def _move_into_place(part: Path, folder: Path) -> None:
    """Rename, with an earlier report kept until that has worked."""
    if not folder.exists():
        part.rename(folder)
        return
    earlier = part.with_suffix(".earlier")
    folder.rename(earlier)
    try:
        part.rename(folder)
    except OSError:
        earlier.rename(folder)
        raise
    shutil.rmtree(earlier)


def _plain(point: Point) -> dict[str, Any]:
    def plain(value: Any) -> Any:
        if isinstance(value, float):
            return value if math.isfinite(value) else None
        return [plain(inner) for inner in value] if isinstance(value, tuple) else value

    return {name: plain(value) for name, value in vars(point).items()} | {
        "success": plain(point.success)
    }
