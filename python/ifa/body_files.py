"""Body files (.json) as plain fields. JSON is read strictly: no NaN, no field twice."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ifa._core import IfaFileError
from ifa.text_files import write_text


def read_fields(path: str | os.PathLike[str]) -> Any:
    """What the JSON file holds. Raises IfaFileError where it cannot be read."""
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise IfaFileError(f"{path}: cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise IfaFileError(f"{path}: is not UTF-8 text") from None
    try:
        return json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_refuse_repeated)
    except (ValueError, RecursionError) as error:
        raise IfaFileError(f"{path}: is not valid JSON: {error}") from None


def write_fields(path: str | os.PathLike[str], fields: dict[str, Any]) -> None:
    """Write the fields as JSON, whole or not at all. Raises IfaFileError where that fails."""
    write_text(path, json.dumps(fields, indent=1, allow_nan=False) + "\n")


def _refuse_constant(word: str) -> None:
    raise ValueError(f"{word} is not a number that JSON has")


def _refuse_repeated(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content: dict[str, Any] = {}
    for key, value in pairs:
        if key in content:
            raise ValueError(f"the field {key!r} is given twice")
        content[key] = value
    return content
