"""Rows of figures that outlive a kill: each is appended to a CSV file as soon as it is there."""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, Generic, TypeVar

import ifa

R = TypeVar("R")


class Records(Generic[R]):
    """The rows of a CSV file, of one data class of str, int, float and bool.

    The file begins with `settings`, what the rows were made with, and lines that name the machine.
    """

    def __init__(self, path: Path, kind: type[R], settings: str, header: Sequence[str]) -> None:
        """Open the file, or make it. IfaValueError where its rows were made with other settings."""
        self.path = path
        self._kind: Any = kind
        self._names = [field.name for field in fields(kind)]  # type: ignore[arg-type]
        self.rows: list[R] = []
        first = f"# settings: {settings}\n"
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            self._append(first + "".join(f"# {line}\n" for line in header))
            self._append(",".join(self._names) + "\n")
            return
        text = path.read_text(encoding="utf-8")
        if not text.startswith(first):
            raise ifa.IfaValueError(
                f"output: {path} has rows that were made with other settings; choose another folder"
            )
        whole = text[: text.rindex("\n") + 1]  # a kill may have cut the last row
        if whole != text:
            path.write_text(whole, encoding="utf-8")
        lines = [line for line in whole.splitlines() if not line.startswith("# ")]
        self.rows = [self._row(row) for row in csv.DictReader(lines)]

    def add(self, row: R) -> None:
        """Append it to the file, at once."""
        values = asdict(row)  # type: ignore[call-overload]
        with self.path.open("a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, self._names, lineterminator="\n").writerow(
                {k: f"{v:.6g}" if isinstance(v, float) else v for k, v in values.items()}
            )
            file.flush()
            os.fsync(file.fileno())
        self.rows.append(row)

    def _append(self, text: str) -> None:
        with self.path.open("a", encoding="utf-8") as file:
            file.write(text)

    def _row(self, texts: dict[str, str]) -> R:
        read = {"str": str, "int": int, "float": float, "bool": "True".__eq__}
        return self._kind(
            **{field.name: read[str(field.type)](texts[field.name]) for field in fields(self._kind)}
        )
