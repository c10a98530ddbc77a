"""A rhythm that no throw makes: 200 hits of a drum pattern, energy allowed at each contact."""

from __future__ import annotations

import ifa
import numpy as np

from .cases import Case

HITS = 200
_SIXTEENTH_S = 60.0 / 120.0 / 4.0  # at 120 beats a minute

# Bars of 16 sixteenths; digits are how hard, of 9; dots are rests or go on. Written for this
# benchmark: eighths with an accent on one and three, sixteenths to lead on, rests of a quarter. No
# gap is more than twice the one before: a bounce cannot be changed beyond that and still look like
# one, however much energy it may gain.
_BARS = ("9.4.6.4.8.446.4.", "9.4.6.438.4.6.45", "9.4...6.8.4...6.", "9.4.6.4.8.446454")
_G_M_S2 = 9.81


def rhythm() -> list[Case]:
    """The rhythm for a d6 and a ball."""
    marks = drums()
    return [
        Case(
            f"drums_{name}", body := ifa.bodies.get(name), marks, energy_gain_j=gain_j(body, marks)
        )
        for name in ("d6", "ball")
    ]


def drums(hits: int = HITS) -> ifa.Signature:
    """Marks of the bars, again and again from the first; they begin at 0.5 s and end open."""
    times_s: list[float] = []
    amplitudes: list[float] = []
    step = 0
    while len(times_s) < hits:
        bar, within = divmod(step, 16)
        velocity = _BARS[bar % len(_BARS)][within]
        if velocity != ".":
            times_s.append(0.5 + step * _SIXTEENTH_S)
            amplitudes.append(int(velocity) / 9.0)
        step += 1
    return ifa.Signature(times_s, amplitudes=amplitudes, ending="open")


def gain_j(body: ifa.Body, marks: ifa.Signature) -> float:
    """What a contact may add: twice the energy of a jump from the ground over the longest gap.

    That jump rises g T^2 / 8; as much again is for what goes into spin and travel.
    """
    longest_s = float(np.diff(marks.times_s).max())
    return 2.0 * body.mass_kg * _G_M_S2 * (_G_M_S2 * longest_s**2 / 8.0)
