"""What marks say before any search: heights, energies and restitution, in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from ifa import _core
from ifa._core import IfaValueError
from ifa.body import Body
from ifa.marks import Signature
from ifa.simulation import GRAVITY_M_S2, gravity_vector


@dataclass(frozen=True)
class Gap:
    """The gap that leads from one mark to the next, as a single flight.

    All figures are of the vertical motion of the centre of mass. They hold if the body flies from
    the end of the first mark's span (`flight_s`) to the next mark; it may instead rest on an edge,
    rock or roll in silence, which takes less energy. A range is (least, most) over the heights that
    the centre can have in the two contacts (`Estimate.centre_height_m`); the single figure beside
    it is for equal heights.

    gap_s: from mark to mark. takeoff_speed_m_s: below 0 where the centre already sinks. apex_m: how
    far the centre rises above its height at the take-off. energy_j, most_energy_j: the least and
    the most vertical kinetic energy, with the weight times the height over the lowest centre.
    needed_j: the largest energy_j of this and all later gaps, which the body must have in all,
    turning and travel included, to fly them. surplus_j: what of energy_j the flight before cannot
    have had, even if both gaps are retimed by 7 %: it comes from the body's spin or travel, or must
    be given. ratio: of flight_s to that of the gap before; None where there is none.
    """

    gap_s: float
    flight_s: float
    takeoff_speed_m_s: float
    takeoff_speed_range_m_s: tuple[float, float]
    apex_m: float
    apex_range_m: tuple[float, float]
    energy_j: float
    most_energy_j: float
    needed_j: float
    surplus_j: float
    ratio: float | None


@dataclass(frozen=True)
class Finding:
    """Something about a mark that a solve may not meet, or only with energy or another material.

    mark: its index, from 0. name: as messages call it, "mark 7 (1.25 s)". text: without the name;
    `str()` gives both.
    """

    mark: int
    name: str
    text: str

    def __str__(self) -> str:
        return f"{self.name}: {self.text}"


@dataclass(frozen=True)
class Estimate:
    """What the marks of a body say; CONVENTIONS.md has the formulas.

    centre_height_m: the lowest and the highest that the centre of mass can be in a contact. ball:
    these are equal, so that no pose matters. gaps: one less than there are marks. restitution,
    friction: to begin a material fit with. The restitution is exact for a ball and a hint for other
    bodies; it is the body's own unless `restitution_from_gaps`. Gaps do not show friction: it is
    always the body's own. next_gap_s: how long the body would bounce on after the last mark; None
    where the last gap is no flight or the mark has a duration. rest_is_near: that bounce, if any,
    is small enough to come to rest without another audible hit (certain for a ball, else a hint).
    findings: in the order of the marks; empty where nothing stands out.
    """

    centre_height_m: tuple[float, float]
    ball: bool
    gaps: list[Gap]
    restitution: float
    friction: float
    restitution_from_gaps: bool
    next_gap_s: float | None
    rest_is_near: bool
    findings: list[Finding]

    def to_dict(self) -> dict[str, Any]:
        """What `ifa estimate --json` prints: every figure, JSON-ready."""
        out = dict(vars(self))
        out["gaps"] = [vars(gap) for gap in self.gaps]
        out["findings"] = [vars(finding) for finding in self.findings]
        out["version"] = _core.__version__
        return out


def estimate(body: Body, marks: Signature, gravity_m_s2: ArrayLike = GRAVITY_M_S2) -> Estimate:
    """Say what `marks` ask of `body` from their times alone: no search, well under a millisecond.

    gravity_m_s2: its size, downwards, or a vector (3,), of which only the part normal to the ground
    counts. Raises IfaValueError naming the argument, or the mark whose gap is too long to compute
    with.

    Example:
        >>> ball = Body.ball(0.02, mass_kg=0.01)
        >>> round(estimate(ball, Signature([0.0, 0.4, 0.6, 0.7], ending="open")).restitution, 12)
        0.5
    """
    if not isinstance(body, Body):
        raise IfaValueError("body: needs an ifa.Body")
    if not isinstance(marks, Signature):
        raise IfaValueError("marks: needs an ifa.Signature")
    found = _core.estimate(body._core, marks._marks, gravity_vector(gravity_m_s2))
    return Estimate(
        gaps=[Gap(**gap) for gap in found.pop("gaps")],
        findings=[Finding(**finding) for finding in found.pop("findings")],
        **found,
    )
