"""What each effect costs in time: measured, kept in data/effects.json, never assumed.

`python -m benchmarks.effects --record` writes the file, for an effect that it has timed on a scene
that needs it. The file is one JSON object:

    machine    what it was timed on: processor, threads
    date       YYYY-MM-DD
    versions   of ifa and of what it was built with: name -> version
    costs      name of the effect -> ratio, spread, scene (see `Cost`)

An effect without an entry was not measured.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from ifa import _core
from ifa._core import IfaFileError, IfaValueError
from ifa.body_files import read_fields, write_fields
from ifa.sound import FilePath

RECORDED = Path(__file__).parent / "data" / "effects.json"


@dataclass(frozen=True)
class Cost:
    """The time that a scene takes with an effect over the time that it takes without.

    ratio: the median of runs in turns, 1 where it costs nothing. spread: from the lower quartile to
    the upper one. scene: what was timed. Raises IfaValueError naming the field.
    """

    ratio: float
    spread: float
    scene: str

    def __post_init__(self) -> None:
        if not _is_number(self.ratio) or not 0.0 < self.ratio < math.inf:
            raise IfaValueError(f"ratio: must be finite and above 0, got {self.ratio!r}")
        if not _is_number(self.spread) or not 0.0 <= self.spread < math.inf:
            raise IfaValueError(f"spread: must be finite and 0 or more, got {self.spread!r}")
        if not isinstance(self.scene, str) or not self.scene:
            raise IfaValueError("scene: must say what was timed")

    def __str__(self) -> str:
        return f"{self.ratio:.2f} +- {self.spread:.2f}"


@dataclass(frozen=True)
class CostTable:
    """The costs of the effects that were measured, and on what. Raises IfaValueError."""

    machine: str = ""
    date: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    costs: Mapping[str, Cost] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.costs:
            if name not in _core.EFFECTS:
                raise IfaValueError(f"costs: there is no effect '{name}'")
        if self.costs and not (self.machine and self.date and "ifa" in self.versions):
            raise IfaValueError("costs: need the machine, the date and the version of ifa")

    @property
    def source(self) -> str:
        """What was measured on what, in a phrase; empty where nothing was."""
        if not self.costs:
            return ""
        return f"{self.machine}, ifa {self.versions['ifa']}, {self.date}"

    @classmethod
    def read(cls, path: FilePath) -> CostTable:
        """Read the file. Raises IfaFileError naming it and the field."""
        fields = read_fields(path)
        try:
            if not isinstance(fields, dict) or set(fields) != set(cls.__dataclass_fields__):
                raise IfaValueError(f"needs exactly {', '.join(cls.__dataclass_fields__)}")
            kinds = {"machine": str, "date": str, "versions": dict, "costs": dict}
            for name, kind in kinds.items():
                if not isinstance(fields[name], kind):
                    raise IfaValueError(f"{name}: is of the wrong kind")
            costs = {name: _cost(name, cost) for name, cost in fields["costs"].items()}
            return cls(**(fields | {"costs": costs}))
        except IfaValueError as error:
            raise IfaFileError(f"{path}: {error}") from None

    def write(self, path: FilePath = RECORDED) -> None:
        """Write the file, whole or not at all, effects in their order. Raises IfaFileError."""
        costs = {e: vars(self.costs[e]) for e in _core.EFFECTS if e in self.costs}
        out = {"machine": self.machine, "date": self.date, "versions": dict(self.versions)}
        write_fields(path, out | {"costs": costs})


@cache
def recorded() -> CostTable:
    """What this version of the package was measured to cost."""
    return CostTable.read(RECORDED)


def _cost(name: str, fields: Any) -> Cost:
    if not isinstance(fields, dict) or set(fields) != set(Cost.__dataclass_fields__):
        raise IfaValueError(f"{name}: needs exactly {', '.join(Cost.__dataclass_fields__)}")
    try:
        return Cost(**fields)
    except IfaValueError as error:
        raise IfaValueError(f"{name}: {error}") from None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
