"""What is asked of a motion's poses beside its marks (paper section 6)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ifa import arguments
from ifa._core import IfaValueError

_MOST_MARKS = 2**31 - 1
_MET_FACTOR = 0.5


@dataclass(frozen=True)
class Orientation:
    """A direction of the body that shall point along one of the world, at a mark or at rest.

    mark: counted from 0: when its contact begins; or "rest": once the body has come to rest after
    the last mark, as in "lands with this face up". body_direction: (3,) in body axes. direction:
    (3,) in world axes; lengths are of no account. Where it is not vertical, its heading says how
    the motion lies on the ground, which it may be turned on as a whole: one such heading is met by
    that alone, further ones, and positions, are relative to it.

    Raises IfaValueError naming the field.

    Example:
        >>> Orientation(mark="rest", body_direction=(0, 0, 1))
        Orientation(mark='rest', body_direction=(0.0, 0.0, 1.0), direction=(0.0, 0.0, 1.0))
    """

    mark: int | Literal["rest"]
    body_direction: Sequence[float]
    direction: Sequence[float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        mark = self.mark
        if isinstance(mark, str):
            if mark != "rest":
                raise IfaValueError(f'mark: must be a whole number or "rest", got {mark!r}')
        else:
            object.__setattr__(self, "mark", arguments.whole(mark, "mark", _MOST_MARKS))
        for name in ("body_direction", "direction"):
            values = _numbers(getattr(self, name), name, 3)
            if not any(values):
                raise IfaValueError(f"{name}: is 0 and points nowhere")
            object.__setattr__(self, name, values)


@dataclass(frozen=True)
class Position:
    """Where on the ground the centre of mass shall be when a mark's contact begins.

    mark: counted from 0. position_m: (2,) x and y. A motion is placed by the turn about z and the
    shift that bring it nearest to all its positions, so that only how they lie to one another is
    asked of it.

    Raises IfaValueError naming the field.
    """

    mark: int
    position_m: Sequence[float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "mark", arguments.whole(self.mark, "mark", _MOST_MARKS))
        object.__setattr__(self, "position_m", _numbers(self.position_m, "position_m", 2))


Constraint = Orientation | Position


@dataclass(frozen=True)
class ConstraintReport:
    """How one constraint was met, on the motion as it is placed.

    error_m: of a position, the distance; error_deg: of an orientation, the angle; the other is
    None. factor: f_p = exp(-7000 error_m^2) or f_o = exp(-140 error^2), with the error in rad
    (paper section 6).
    """

    constraint: Constraint
    error_m: float | None
    error_deg: float | None
    factor: float

    @property
    def met(self) -> bool:
        """Whether the factor is at least one half: within 1 cm, or 4 degrees."""
        return self.factor >= _MET_FACTOR

    def to_dict(self) -> dict[str, Any]:
        """`mark`, what was asked, `error_m` or `error_deg`, `factor` and `met`; JSON-ready."""
        out: dict[str, Any] = {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in vars(self.constraint).items()
        }
        if self.error_m is not None:
            out["error_m"] = self.error_m
        if self.error_deg is not None:
            out["error_deg"] = self.error_deg
        return out | {"factor": self.factor, "met": self.met}


def sequence(value: Any) -> tuple[Constraint, ...]:
    """The argument `constraints`: orientations and positions, in the order of the reports.

    By mark, rest last; of one mark its position first.
    """
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        raise IfaValueError(
            f"constraints: must be a sequence of ifa.Orientation and ifa.Position, got {value!r}"
        )
    for item in value:
        if not isinstance(item, Orientation | Position):
            raise IfaValueError(
                f"constraints: must hold ifa.Orientation and ifa.Position only, got {item!r}"
            )

    def place(item: Constraint) -> tuple[float, bool]:
        mark = np.inf if isinstance(item.mark, str) else item.mark
        return mark, isinstance(item, Orientation)

    return tuple(sorted(value, key=place))


def for_core(constraints: Iterable[Constraint]) -> dict[str, Any]:
    """As the core's Marks take them."""
    positions, orientations = [], []
    for c in constraints:
        if isinstance(c, Position):
            positions.append((c.mark, list(c.position_m)))
        else:
            mark = None if c.mark == "rest" else c.mark
            orientations.append((mark, list(c.body_direction), list(c.direction)))
    return {"positions": positions, "orientations": orientations}


def from_core(marks: Any) -> tuple[Constraint, ...]:
    """What the core's Marks hold."""
    positions = [Position(mark, at) for mark, at in marks.positions]
    orientations = [
        Orientation("rest" if mark is None else mark, body, world)
        for mark, body, world in marks.orientations
    ]
    return sequence([*positions, *orientations])


def reports(
    constraints: Sequence[Constraint], found: Iterable[tuple[float, float]]
) -> tuple[ConstraintReport, ...]:
    """The core's errors and factors, positions before orientations, put beside `constraints`."""
    pairs = list(found)
    positions = sum(isinstance(c, Position) for c in constraints)
    of_positions, of_orientations = iter(pairs[:positions]), iter(pairs[positions:])
    out = []
    for c in constraints:
        if isinstance(c, Position):
            error_m, factor = next(of_positions)
            out.append(ConstraintReport(c, error_m, None, factor))
        else:
            error_rad, factor = next(of_orientations)
            out.append(ConstraintReport(c, None, float(np.degrees(error_rad)), factor))
    return tuple(out)


def to_fields(constraints: Iterable[Constraint], mark: int | Literal["rest"]) -> dict[str, Any]:
    """The keys of one mark in a dictionary of marks, or of rest; only those that are asked."""
    out: dict[str, Any] = {}
    orientations = []
    for c in constraints:
        if c.mark != mark:
            continue
        if isinstance(c, Position):
            out["position_m"] = list(c.position_m)
        else:
            orientations.append(
                {"body_direction": list(c.body_direction), "direction": list(c.direction)}
            )
    if orientations:
        key = "rest_orientation" if mark == "rest" else "orientation"
        out[key] = orientations if len(orientations) > 1 else orientations[0]
    return out


def from_fields(
    fields: Mapping[str, Any], mark: int | Literal["rest"], where: str
) -> list[Constraint]:
    """The inverse of `to_fields`; an error begins with `where`."""
    try:
        out: list[Constraint] = []
        if mark != "rest" and fields.get("position_m") is not None:
            out.append(Position(mark, fields["position_m"]))
        key = "rest_orientation" if mark == "rest" else "orientation"
        asked = fields.get(key)
        for one in asked if isinstance(asked, list) else [] if asked is None else [asked]:
            if not isinstance(one, dict) or not {"body_direction"} <= set(one) <= {
                "body_direction",
                "direction",
            }:
                raise IfaValueError(f"{key}: must be an object with body_direction and direction")
            out.append(Orientation(mark, **one))
        return out
    except IfaValueError as error:
        raise IfaValueError(f"{where}: {error}") from None


def _numbers(value: Any, field: str, count: int) -> tuple[float, ...]:
    values = arguments.array(value, field, (count,))
    if not np.isfinite(values).all():
        raise IfaValueError(f"{field}: must be finite, got {value!r}")
    return tuple(values.tolist())
