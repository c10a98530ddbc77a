"""The independent check of a motion: contacts, timing and physics again, from its poses alone.

Nothing of the simulation or the search is used, so their errors cannot hide here. Hits are detected
from the velocity of the body's own points, flights are compared with parabolas under gravity and
with Euler's equations, and every finding is a sentence in the certificate.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from ifa import _core
from ifa._core import IfaFileError, IfaValueError
from ifa.arguments import array, number
from ifa.body import Body
from ifa.body_files import read_fields
from ifa.marks import HEARING, Signature

_TRIVIAL = 1e-9  # a retiming by rounding is none


class SampledMotion(Protocol):
    """What `verify` reads of a motion; `ifa.Motion` is one."""

    times_s: NDArray[np.float64]
    positions_m: NDArray[np.float64]
    quaternions_wxyz: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DetectedHit:
    """An impact found in the poses that can be heard; with contact events, any impact."""

    time_s: float
    approach_speed_m_s: float
    """As shown; the largest over the touching points."""
    position_m: tuple[float, float, float]
    """Of the point that approaches fastest, on the ground."""
    certain: bool
    """Above the hysteresis band (audible speed +- 5 %); inside it a hit may also be silent."""
    event: int
    """Index into the certificate's events."""


@dataclass(frozen=True, slots=True)
class DetectedEvent:
    """Hits chained by the merge gap; with contact events, an interval of contact."""

    time_s: float
    """Of the first hit, or where contact begins."""
    duration_s: float
    """To the last hit, or to where contact ends or the body comes to rest."""
    hits: int
    """With contact events possibly 0: a landing too soft to be seen as an impact."""


@dataclass(frozen=True, slots=True)
class MarkCheck:
    """How a mark is met; `achieved_s` and `error_s` are None where no event answers it."""

    target_s: float
    achieved_s: float | None
    error_s: float | None
    """Achieved minus target."""


@dataclass(frozen=True, slots=True)
class FlightCheck:
    """One stretch of free flight."""

    start_s: float
    end_s: float
    gravity_error: float
    """Largest deviation from the parabola under gravity, relative to the parabola's height."""
    horizontal_acceleration_m_s2: float
    momentum_drift: float
    """Largest change of the angular momentum, relative."""
    energy_j: float
    """Mechanical energy, before retiming."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """What `verify` found. `passed` is True where `failures` is empty."""

    passed: bool
    failures: tuple[str, ...]
    """One sentence for each, naming the mark or the time."""
    hits: tuple[DetectedHit, ...]
    events: tuple[DetectedEvent, ...]
    marks: tuple[MarkCheck, ...]
    flights: tuple[FlightCheck, ...]
    extra_events_s: tuple[float, ...]
    missed_hits: int
    """Marks that no event answers."""
    extra_hits: int
    """Events that answer no mark."""
    max_abs_error_s: float
    """Over the marks that are answered."""
    max_penetration_m: float
    """At samples, between them, and where an impact lies between two."""
    max_gravity_error: float
    """Of the worst flight, as are the next two."""
    max_horizontal_acceleration_m_s2: float
    max_momentum_drift: float
    max_energy_gain_j: float
    """From one flight to the next, 0 where none grows."""
    max_contact_energy_gain_j: float
    """Through sustained contact, beyond what poses tell there (a tenth of the kinetic energy)."""
    at_rest: bool
    rest_s: float
    """At rest from here on; the motion's end where it never is."""
    claimed_retime: tuple[float, ...]
    """For each mark, the ratio that was relied on: flights must show gravity over its square."""
    claimed_energy_gain_j: float
    """What a contact was allowed to add."""
    options: Mapping[str, float | str] = field(repr=False)
    """The options of `verify` that this was found with."""

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON. A mark that is not answered has no `achieved_s` and `error_s`."""
        plain = asdict(self)
        plain["marks"] = [
            {key: value for key, value in mark.items() if value is not None}
            for mark in plain["marks"]
        ]
        return _lists(plain)

    def summary(self) -> str:
        """A few lines for people."""
        answered = len(self.marks) - self.missed_hits
        contact = self.options["events"] == "contact"
        heard = (
            "intervals of contact" if contact
            else f"hits from {self.options['audible_speed_m_s']:.3g} m/s on"
        )  # fmt: skip
        lines = [
            "PASSED" if self.passed else "FAILED",
            f"events: {heard}, merged below {1e3 * float(self.options['merge_gap_s']):.3g} ms",
            f"marks met: {answered} of {len(self.marks)}, largest error "
            f"{1e3 * self.max_abs_error_s:.3f} ms; extra {'contacts' if contact else 'hits'}: "
            f"{self.extra_hits}",
            f"flights: {len(self.flights)}, worst departure from gravity "
            f"{100 * self.max_gravity_error:.3g} %, from constant angular momentum "
            f"{100 * self.max_momentum_drift:.3g} %",
            f"penetration: {1e3 * self.max_penetration_m:.4f} mm; "
            f"energy gain: {self.max_energy_gain_j:.3g} J",
            f"at rest from {self.rest_s:.3f} s" if self.at_rest else "not at rest at the end",
        ]
        claims = []
        retiming = max((max(r, 1.0 / r) - 1.0 for r in self.claimed_retime), default=0.0)
        if retiming > _TRIVIAL:
            claims.append(f"retiming of up to {100 * retiming:.3g} %")
        if self.claimed_energy_gain_j > 0.0:
            claims.append(f"{self.claimed_energy_gain_j:.3g} J that a contact may add")
        if claims:
            lines.append(f"relies on the claims: {'; '.join(claims)}")
        return "\n".join(lines + [f"- {failure}" for failure in self.failures])


def verify(
    motion: SampledMotion | Mapping[str, Any] | str | os.PathLike[str],
    body: Body,
    marks: Signature,
    *,
    retime: Any = None,
    energy_gain_j: float | None = None,
    events: Literal["audible", "contact"] | None = None,
    audible_speed_m_s: float | None = None,
    merge_gap_s: float | None = None,
    gravity_m_s2: float = 9.81,
    rest_speed_m_s: float = 0.01,
    rest_duration_s: float = 0.050,
    time_tolerance_s: float = 1e-3,
    penetration_limit_m: float = 1e-4,
) -> Certificate:
    """Check a motion of a body against marks, from its poses alone.

    The motion should be sampled as `ifa solve` writes it: steps of at most 1 ms (longer ones are a
    failure), samples at the impact instants and at least four between two of them. In other
    samplings an impact between samples is found by extrapolating the motion before it: its time is
    then good to a fraction of a step, but two impacts inside one step count as one.

    Args:
        motion: An object with `times_s` (n,), `positions_m` (n, 3) of the centre of mass and
            `quaternions_wxyz` (n, 4) from body to world axes; or the path of an OUT.json, or what
            that holds.
        body: The body that moves.
        marks: When contacts should happen.
        retime: Shape (len(marks),): the claimed ratio of the length of the transition to each mark,
            retimed over simulated. Flights must show gravity divided by its square. Left out:
            what the motion claims (a file in its `events`), or 1; also 1 where it claims for
            another number of marks, as it was then not made for these.
        energy_gain_j: What a contact may add. Left out: the file's, or 0.
        events: What answers a mark: "audible" hits, or the beginning of an interval of "contact"
            with the ground (CONVENTIONS.md). Left out, as are the next two: what the motion was
            made for (a file's `hearing`, an object's attribute of that name), or "audible".
        audible_speed_m_s: Impacts slower than this are silent. Within 5 % of it an impact may count
            as either, whichever suits the marks. Compared before retiming. Default 0.05.
        merge_gap_s: Hits less than this after the previous one belong to its event, and flights
            shorter than this join intervals of contact; measured before retiming or after,
            whichever suits the marks. Default 0.010.
        gravity_m_s2: Downwards.
        rest_speed_m_s: At rest, no point of the hull is faster.
        rest_duration_s: How much standing still the motion must show where the marks end in rest.
        time_tolerance_s: Largest error of a mark.
        penetration_limit_m: Largest depth of any point, at samples and between them.

    Returns:
        The certificate. A motion that cannot be checked (a number that is not finite, times out of
        order, quaternions that are not unit) fails, with the reason.

    Raises:
        IfaFileError: The file cannot be read or is not JSON.
        IfaValueError: A field is missing or has the wrong shape, or an option makes no sense; the
            message names it, and the file.
    """
    options = {
        "gravity_m_s2": number(gravity_m_s2, "gravity_m_s2"),
        "rest_speed_m_s": number(rest_speed_m_s, "rest_speed_m_s"),
        "rest_duration_s": number(rest_duration_s, "rest_duration_s"),
        "time_tolerance_s": number(time_tolerance_s, "time_tolerance_s"),
        "penetration_limit_m": number(penetration_limit_m, "penetration_limit_m"),
    }
    if not isinstance(body, Body):
        raise IfaValueError(f"body: must be an ifa.Body, got {type(body).__name__}")
    if not isinstance(marks, Signature):
        raise IfaValueError(f"marks: must be an ifa.Signature, got {type(marks).__name__}")
    source = ""
    if isinstance(motion, str | os.PathLike):
        source = f"{os.fspath(motion)}: "
        motion = read_fields(motion)
        if not isinstance(motion, Mapping):
            raise IfaFileError(f"{source}does not hold a motion")
    given = {
        "events": events,
        "audible_speed_m_s": audible_speed_m_s,
        "merge_gap_s": merge_gap_s,
    }
    try:
        hearing = _hearing(motion, given)
        options |= {key: value for key, value in hearing.items() if key != "events"}
        ratios = (
            _claimed_retime(motion, len(marks)) if retime is None
            else array(retime, "retime", (None,))
        )  # fmt: skip
        gain = (
            _claimed_gain(motion) if energy_gain_j is None
            else number(energy_gain_j, "energy_gain_j")
        )  # fmt: skip
        found = _core.verify(
            **_poses(motion),
            body=body._core,
            mark_times_s=marks.times_s,
            mark_durations_s=marks.durations_s,
            rest=marks.ending == "rest",
            retime=ratios,
            energy_gain_j=gain,
            contact=hearing["events"] == "contact",
            options=options,
        )
    except IfaValueError as error:
        raise IfaValueError(f"{source}{error}") from None
    for key, kind in _PARTS.items():
        found[key] = tuple(kind(**part) for part in found[key])
    for key in ("failures", "extra_events_s"):
        found[key] = tuple(found[key])
    found |= {"claimed_retime": tuple(ratios.tolist()), "claimed_energy_gain_j": gain}
    return Certificate(**found, options=options | {"events": hearing["events"]})


_PARTS: dict[str, type] = {
    "hits": DetectedHit,
    "events": DetectedEvent,
    "marks": MarkCheck,
    "flights": FlightCheck,
}


def _poses(motion: SampledMotion | Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    shapes: dict[str, tuple[int | None, ...]] = {
        "times_s": (None,),
        "positions_m": (None, 3),
        "quaternions_wxyz": (None, 4),
    }
    poses = {}
    for key, shape in shapes.items():
        if isinstance(motion, Mapping):
            if key not in motion:
                raise IfaValueError(f"{key}: is missing")
            poses[key] = array(motion[key], key, shape)
        elif hasattr(motion, key):
            poses[key] = array(getattr(motion, key), key, shape)
        else:
            raise IfaValueError(
                f"motion: must be a motion, a path or a mapping, got {type(motion).__name__}"
            )
    return poses


def _hearing(motion: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """What an event is: as given, else as the motion says, else the default."""
    if isinstance(motion, Mapping):
        said = motion.get("hearing", {})
    else:
        said = getattr(motion, "hearing", {})
    if not isinstance(said, Mapping):
        raise IfaValueError("hearing: must be an object")
    hearing = {}
    for key, default in HEARING.items():
        value, field = given[key], key
        if value is None:
            value, field = said.get(key, default), f"hearing.{key}"
        if key != "events":
            value = number(value, field)
        elif value not in ("audible", "contact"):
            raise IfaValueError(f'{field}: must be "audible" or "contact", got {value!r}')
        hearing[key] = value
    return hearing


def _claimed_retime(motion: Any, count: int) -> NDArray[np.float64]:
    if not isinstance(motion, Mapping):
        claimed = getattr(motion, "retime", ())
        return array(claimed, "retime", (None,)) if len(claimed) == count else np.ones(count)
    if "events" not in motion:
        return np.ones(count)
    events = motion["events"]
    if not isinstance(events, list) or not all(isinstance(event, Mapping) for event in events):
        raise IfaValueError("events: must be a list of objects")
    ratios = np.array(list(_ratios(events)))
    return ratios if len(ratios) == count else np.ones(count)


def _ratios(events: list[Mapping[str, Any]]) -> Iterator[float]:
    for index, event in enumerate(events):
        yield number(event.get("retime", 1.0), f"events[{index}].retime")


def _claimed_gain(motion: Any) -> float:
    if not isinstance(motion, Mapping):
        return number(getattr(motion, "energy_gain_j", 0.0), "energy_gain_j")
    return number(motion.get("energy_gain_j", 0.0), "energy_gain_j")


def _lists(value: Any) -> Any:
    """Tuples as lists, all the way down, as JSON has them."""
    if isinstance(value, Mapping):
        return {key: _lists(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_lists(inner) for inner in value]
    return value
