"""The files that marks are read from and written to."""

import json
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from ifa import constraints
from ifa._core import IfaFileError, IfaValueError

_ROUNDING_S = 1e-9  # 0.76 - 0.75 is a hair off 0.01
_MOST_BYTES = 1 << 24  # some 100,000 marks; a bigger file was not meant
_NUMBER = re.compile(r"[+-]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)([eE][+-]?[0-9]+)?")


@dataclass(frozen=True)
class MarkFile:
    """What a file says of its marks, not yet checked by `Signature`."""

    fields: dict[str, Any]  # arguments of Signature
    lines: list[int]  # the line of each mark, from 1; empty if the format has no line for each


def read_marks(name: str, merge_gap_s: float) -> MarkFile:
    """Read a file of marks; IfaFileError or IfaValueError, naming it, if that is impossible."""
    kind = Path(name).suffix.lower()
    readers = {".txt": _read_labels, ".json": _read_json}
    if kind not in readers and os.path.isfile(name):
        raise IfaFileError(
            f'{name}: the ending "{kind}" is not known; marks are read from Audacity label '
            "tracks (.txt) and JSON (.json)"
        )
    data = _read_bytes(name)
    return readers[kind](data, name, merge_gap_s)


def fields_of(marks: Any) -> dict[str, Any]:
    """Turn what `Signature.to_dict` gives into the arguments of `Signature`."""
    _check_keys(marks, "marks", required={"events"}, optional={"ending", "rest_orientation"})
    events = marks["events"]
    if not isinstance(events, list):
        raise IfaValueError("events: must be a list")
    asked: list[constraints.Constraint] = []
    for k, event in enumerate(events, start=1):
        optional = {"duration_s", "amplitude", "centroid_s", "position_m", "orientation"}
        _check_keys(event, f"mark {k}", required={"time_s"}, optional=optional)
        asked += constraints.from_fields(event, k - 1, f"mark {k}")
        for key, value in event.items():
            if key in ("position_m", "orientation"):
                continue
            if value is None and key in ("amplitude", "centroid_s"):
                continue
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise IfaValueError(f"mark {k}: {key} must be a number")
    with_amplitude = [event.get("amplitude") is not None for event in events]
    if any(with_amplitude) and not all(with_amplitude):
        without = with_amplitude.index(False) + 1
        raise IfaValueError(f"mark {without}: has no amplitude; give one for all marks or for none")
    centroids_s = [event.get("centroid_s") for event in events]
    return {
        "times_s": [event["time_s"] for event in events],
        "durations_s": [event.get("duration_s", 0.0) for event in events],
        "amplitudes": [event["amplitude"] for event in events] if any(with_amplitude) else None,
        "centroids_s": [float("nan") if c is None else c for c in centroids_s],
        "ending": marks.get("ending", "rest"),
        "constraints": [*asked, *constraints.from_fields(marks, "rest", "rest")],
    }


def _check_keys(
    value: Any, where: str, *, required: Iterable[str], optional: Iterable[str]
) -> None:
    if not isinstance(value, dict):
        raise IfaValueError(f"{where}: must be an object")
    for key in required:
        if key not in value:
            raise IfaValueError(f"{where}: the key {key} is missing")
    known = {*required, *optional}
    for key in value:
        if key not in known:
            raise IfaValueError(
                f"{where}: unknown key {key!r}; known are {', '.join(sorted(known))}"
            )


def _read_bytes(name: str) -> bytes:
    if os.path.isdir(name):
        raise IfaFileError(f"{name}: is a folder, not a file of marks")
    if os.path.exists(name) and not os.path.isfile(name):
        raise IfaFileError(f"{name}: is not a regular file")
    try:
        with open(name, "rb") as file:
            data = file.read(_MOST_BYTES + 1)
    except FileNotFoundError:
        raise IfaFileError(f"{name}: there is no such file") from None
    except OSError as error:
        raise IfaFileError(f"{name}: cannot be read: {error.strerror}") from error
    if not data.strip():
        raise IfaFileError(f"{name}: is empty")
    if len(data) > _MOST_BYTES:
        raise IfaFileError(f"{name}: is larger than 16 MiB, too large for a file of marks")
    if b"\0" in data:
        raise IfaFileError(f"{name}: is a binary file, not marks as text")
    return data


def _read_labels(data: bytes, name: str, merge_gap_s: float) -> MarkFile:
    text = data.decode("utf-8-sig", errors="replace")  # only numbers are read, in any encoding
    times_s: list[float] = []
    durations_s: list[float] = []
    lines: list[int] = []
    for number, line in enumerate(re.split(r"\r\n|\r|\n", text), start=1):
        if not line.strip() or line.startswith("\\"):  # frequencies of a spectral selection
            continue
        where = f"{name}, line {number}"
        fields = [field.strip() for field in line.split("\t")[:2]]
        if len(fields) < 2 or not all(_NUMBER.fullmatch(field) for field in fields):
            shown = line if len(line) <= 40 else line[:40] + "..."
            raise IfaFileError(
                f"{where}: a label has a start and an end in seconds between tabs, got {shown!r}"
            )
        start_s, end_s = (float(field.replace(",", ".")) for field in fields)
        if end_s < start_s:
            raise IfaValueError(f"{where}: the label ends before it starts")
        duration_s = end_s - start_s
        times_s.append(start_s)
        durations_s.append(0.0 if duration_s < merge_gap_s - _ROUNDING_S else duration_s)
        lines.append(number)
    if not times_s:
        raise IfaFileError(f"{name}: holds no labels")
    return MarkFile({"times_s": times_s, "durations_s": durations_s}, lines)


def _read_json(data: bytes, name: str, merge_gap_s: float) -> MarkFile:
    def no_constant(text: str) -> NoReturn:
        raise ValueError(f"{text} is no number in JSON")

    def no_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result = dict(pairs)
        if len(result) < len(pairs):
            raise ValueError("a key appears twice in one object")
        return result

    try:
        parsed = json.loads(
            data.decode("utf-8-sig"), parse_constant=no_constant, object_pairs_hook=no_duplicates
        )
    except RecursionError:
        raise IfaFileError(f"{name}: is nested too deeply for a file of marks") from None
    except ValueError as error:  # of the encoding, of the syntax, and those above
        raise IfaFileError(f"{name}: is no valid JSON: {error}") from None
    try:
        return MarkFile(fields_of(parsed), [])
    except IfaValueError as error:
        raise IfaValueError(f"{name}: {error}") from None
