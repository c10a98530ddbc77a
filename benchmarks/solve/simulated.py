"""Cases from simulations of bodies that are not quite those that the solver is given.

The seeds are fixed here and have nothing to do with the solver's. A throw that makes no sound is
drawn again.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import ifa
import numpy as np

from .cases import Case, first_marks, spread

STARTS_SEED = 771_100_000  # one more for each body; the solver's is 0 unless told otherwise
ROLLS_SEED = 772_200_000
NUDGES_SEED = 773_300_000

# One solid piece each: what `real` makes of them has its mass spread evenly, as they have.
BODIES = ("d4", "d6", "d8", "d10", "d12", "d20", "ball", "coin", "eraser", "card")
THROWS = 50  # of each body
MOST_DRAWS = 1000  # for a throw that is heard, or one that rolls long enough
RESTITUTION_OFF, SHAPE_OFF = 0.10, 0.03

# Thrown low and fast along the ground, with a spin: round dice then click 30 times and more.
_LOW_AND_FAST: dict[str, Any] = {
    "cone_rad": np.radians(80.0),
    "speed_m_s": (4.0, 6.0),
    "spin_rad_s": (20.0, 60.0),
}
_ROLLING = ("d12", "d20", "d10")
_ROLL_MARKS = 30

_NUDGE_MARKS = 15
_NUDGE_S = 0.005
_NUDGED = (3, 7, 11)  # early, in the middle, late


def real(body: ifa.Body, k: int) -> ifa.Body:
    """The body as it is in truth, where the solver knows `body`; one of six for k = 0 to 5.

    Its restitution is 10 % more or less by turns, and one of its axes 3 % longer, by turns; at the
    same mass and uniform density. Circular edges stay circles: with them, only the axis along which
    library bodies have theirs (z). A ball stays one, of a radius 3 % larger.
    """
    up = k % 2 == 0
    scale = np.ones(3)
    scale[2 if len(body.rings_m) else k % 3] += SHAPE_OFF
    rings_m = body.rings_m.copy()
    rings_m[:, :3] *= scale
    is_ball = len(body.vertices_m) == 1 and not len(rings_m)
    return ifa.Body.from_vertices(
        body.vertices_m * scale,
        body.radius_m * (1.0 + SHAPE_OFF if is_ball else 1.0),
        rings_m,
        mass_kg=body.mass_kg,
        restitution=body.restitution * (1.0 + RESTITUTION_OFF if up else 1.0 - RESTITUTION_OFF),
        friction=body.friction,
        rolling_friction_m=body.rolling_friction_m,
        spin_friction_m=body.spin_friction_m,
        name=body.name,
    )


def simulated(limit: int | None = None) -> list[Case]:
    """Throws of ten of the library's bodies to rest, heard; solved with the nominal body.

    limit: so many of them, as `spread` picks them; simulating the rest would take a while.
    """
    throws = [(b, name, i) for b, name in enumerate(BODIES) for i in range(THROWS)]
    return [
        Case(
            f"{name}_{i:02}",
            ifa.bodies.get(name),
            next(_heard(name, STARTS_SEED + b, first_real=b + i, first_sample=i * MOST_DRAWS)),
        )
        for b, name, i in spread(throws, limit)
    ]


def rolls(count: int = 5) -> list[Case]:
    """The first 30 marks of throws low and fast along the ground that click as often or more."""
    cases = []
    for i in range(count):
        name = _ROLLING[i % len(_ROLLING)]
        throws = _heard(name, ROLLS_SEED + i, first_real=i, **_LOW_AND_FAST)
        marks = next(marks for marks in throws if len(marks) >= _ROLL_MARKS)
        cases.append(
            Case(f"roll_{name}_{i}", ifa.bodies.get(name), first_marks(marks, _ROLL_MARKS))
        )
    return cases


def nudges() -> list[Case]:
    """A roll of a d6 with 15 marks to rest, of which one comes 5 ms later than before."""
    throws = _heard("d6", NUDGES_SEED)
    before = next(marks for marks in throws if len(marks) == _NUDGE_MARKS)
    cases = []
    for wanted in _NUDGED:
        # the first from there on that has room: its own span, 5 ms, and the merge gap
        room_s = np.diff(before.times_s) - before.durations_s[:-1]
        k = wanted + int(np.argmax(room_s[wanted:] >= _NUDGE_S + 0.010))
        times_s = before.times_s.copy()
        times_s[k] += _NUDGE_S
        after = ifa.Signature(
            times_s, before.durations_s, before.amplitudes, before.centroids_s, before.ending
        )
        cases.append(Case(f"mark_{k + 1:02}", ifa.bodies.get("d6"), after, before=before))
    return cases


def _heard(
    name: str, seed: int, first_real: int = 0, first_sample: int = 0, **sampling: Any
) -> Iterator[ifa.Signature]:
    """Signatures of at most MOST_DRAWS throws, those that make no sound left out.

    Each is of the next of the bodies of `real`.
    """
    body = ifa.bodies.get(name)
    k = first_real
    for sample in range(first_sample, first_sample + MOST_DRAWS):
        thrown = real(body, k)
        run = ifa.simulate(thrown, ifa.sample_states(thrown, 1, seed, sample, **sampling)[0])
        try:
            marks = ifa.Signature.from_run(run)
        except ifa.IfaValueError:  # it makes no sound
            continue
        k += 1
        yield marks
