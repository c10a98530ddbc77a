"""The body's shape: how many vertices its hull has, how its edges are rounded."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from ifa import _core
from ifa._core import IfaError
from ifa.body import Body
from ifa.tradeoff.curve import Outcome, Scene, Setting, Study
from ifa.tradeoff.throws import (
    DEFAULT_STEP_S,
    Reference,
    Throws,
    event_simulation,
    measured,
)

_CONTACT = 2  # later ones are another throw's wherever the shape is another
_DETAIL = (4, 6, 8, 12, 16, 24, 32, 48, 64, 128, 256)
_RADII = (0.0, 0.01, 0.02, 0.05, 0.1)  # of the bounding radius
_RATES = (0.0, 0.5, 0.8, 1.25, 2.0)  # of the radius that the body has

_Shape = tuple[str, Callable[[], Body]]  # a label, and what makes the body
_Shapes = tuple[Sequence[_Shape], str]  # and why there are none


def hull_detail_contacts(scene: Scene, *, quick: bool) -> Study:
    """Contact-time error of hulls of fewer vertices."""
    return _contacts(
        scene, "hull_detail", "Hull detail: contact times", _coarser(scene.body, quick), quick
    )


def hull_detail_mass(scene: Scene, *, quick: bool) -> Study:
    """Mass-property error of hulls of fewer vertices."""
    return _mass(scene, "hull_detail", "Hull detail: mass properties", _coarser(scene.body, quick))


def rounding_contacts(scene: Scene, *, quick: bool) -> Study:
    """Contact-time error of another rounding radius."""
    return _contacts(
        scene, "rounding", "Rounding: contact times", _rounded(scene.body, quick), quick
    )


def rounding_mass(scene: Scene, *, quick: bool) -> Study:
    """Mass-property error of another rounding radius."""
    return _mass(scene, "rounding", "Rounding: mass properties", _rounded(scene.body, quick))


def _coarser(body: Body, quick: bool) -> _Shapes:
    """The body with fewer vertices, and as it is; none where it has none to spare."""
    vertices, rings = len(body.vertices_m), len(body.rings_m)
    if vertices < 5 and not rings:
        return [], "The body has too few vertices for a coarser hull."
    most = len(body.outline_m)
    counts = [count for count in _DETAIL if count < most]
    if quick:
        counts = counts[:: max(1, len(counts) // 3)]
    whole = f"all {vertices}" if not rings else f"{rings} circular edges"
    return [
        *((str(count), lambda count=count: body.with_hull_detail(count)) for count in counts),
        (whole, lambda: body),
    ], ""


def _rounded(body: Body, quick: bool) -> _Shapes:
    """The body with other radii, and as it is; none where its shape allows no other."""
    own_m = body.radius_m
    size_m = own_m + float(np.linalg.norm(body.outline_m, axis=1).max())
    radii_m = [own_m * rate for rate in _RATES] if own_m > 0.0 else [size_m * r for r in _RADII]
    radii_m = [radius_m for radius_m in radii_m if radius_m != own_m]
    if quick:
        radii_m = radii_m[::2]
    try:
        body.with_rounding(radii_m[0])
    except IfaError as error:
        return [], f"The body has no other rounding: {error}."
    return [
        *(
            (f"{1e3 * radius_m:.3g} mm", lambda radius_m=radius_m: body.with_rounding(radius_m))
            for radius_m in radii_m
        ),
        (f"{1e3 * own_m:.3g} mm, the body's", lambda: body),
    ], ""


def _contacts(scene: Scene, knob: str, title: str, found: _Shapes, quick: bool) -> Study:
    shapes, reason = found
    throws = Throws(scene, 8 if quick else 40, _CONTACT)
    reference = Reference(throws, event_simulation(scene.body, DEFAULT_STEP_S))

    def setting(make: Callable[[], Body]) -> Callable[[int], Outcome]:
        return lambda repeat: measured(reference, event_simulation(make(), DEFAULT_STEP_S))(repeat)

    return Study(
        f"{knob}_contacts",
        title,
        f"error of contact {_CONTACT}, ms",
        tuple(Setting(label, setting(make)) for label, make in shapes),
        "Mean over random throws, each set of them another repeat, against the body as it is; mass "
        "and inertia are kept. The time is that of one simulation by the event engine."
        if shapes
        else reason,
    )


def _mass(scene: Scene, knob: str, title: str, found: _Shapes) -> Study:
    shapes, reason = found
    wanted = _mass_properties(scene.body)
    if wanted[0] <= 0.0:  # a flat hull without rounding
        shapes, reason = [], "The body is flat: it has no volume."

    def setting(make: Callable[[], Body]) -> Callable[[int], Outcome]:
        def run(repeat: int) -> Outcome:
            body = make()
            began_s = time.perf_counter()
            got = _mass_properties(body)
            time_s = time.perf_counter() - began_s
            return Outcome(time_s, mass_property_error(got, wanted))

        return run

    return Study(
        f"{knob}_mass",
        title,
        "largest error of volume, centre and inertia, %",
        tuple(Setting(label, setting(make)) for label, make in shapes),
        "The solid of uniform density inside the changed hull against the solid inside the body's "
        "own: the largest of the errors of the volume, of the centre of mass over the bounding "
        "radius, and of the inertia at the same density (Frobenius norm). The time is that of the "
        "mass properties."
        if shapes
        else reason,
    )


_MassProperties = tuple[float, np.ndarray, np.ndarray, float]


def _mass_properties(body: Body) -> _MassProperties:
    """Volume, centre and inertia of the rounded hull at density 1, and its bounding radius."""
    volume, centre, moments = _core.rounded_hull_mass_properties(
        body.vertices_m, body.radius_m, 1.0, body.rings_m
    )
    size_m = body.radius_m + float(np.linalg.norm(body.outline_m, axis=1).max())
    return volume, centre, moments, size_m


def mass_property_error(got: _MassProperties, wanted: _MassProperties) -> float:
    """The largest relative error of the three, in percent."""
    return 100.0 * max(
        abs(got[0] / wanted[0] - 1.0),
        float(np.linalg.norm(got[1] - wanted[1])) / wanted[3],
        float(np.linalg.norm(got[2] - wanted[2]) / np.linalg.norm(wanted[2])),
    )
