# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion with its contacts moved to whole frames. Pure numpy, no bpy.

Time runs a little faster or slower between one contact and the next, so that each of them is
seen on a frame of its own. A parabola stays a parabola, of a slightly different gravity.
"""

from __future__ import annotations

import numpy as np

LEAD_S = 0.015  # how far "PICTURE_FIRST" lets a hit be seen before it is heard
_ROUNDING_FRAMES = 1e-6  # a time that is a whole frame but for float64 rounding


def nearest_frame(frames: np.ndarray, fps: float) -> np.ndarray:
    """Half a frame early or late at most; halfway between two frames, the later one."""
    return np.floor(frames + 0.5)


def picture_first_frame(frames: np.ndarray, fps: float) -> np.ndarray:
    """The last frame that begins at or before the hit, or the next where that is over LEAD_S early.

    Shown minus heard is at least -LEAD_S and less than a frame - LEAD_S (at most 0 where a frame
    is not longer than LEAD_S).
    """
    last = np.floor(frames + _ROUNDING_FRAMES)
    early_s = (frames - last) / fps
    return np.where(early_s > LEAD_S + _ROUNDING_FRAMES / fps, last + 1, last)


RULES = {"FRAME": nearest_frame, "PICTURE_FIRST": picture_first_frame}


class Retimed:
    """`motion`, run so that it is at `true_s` when `shown_s` is shown; linear in between.

    Both (n,) strictly increasing, n >= 2. The first and the last are where the motion begins and
    ends; `contact_times_s` (shown) are those of its contacts that have a frame to themselves.
    """

    def __init__(self, motion, true_s, shown_s, contact_times_s, notes=()) -> None:
        self._motion = motion
        self._true_s = np.asarray(true_s, dtype=np.float64)
        self._shown_s = np.asarray(shown_s, dtype=np.float64)
        self._rate = np.diff(self._true_s) / np.diff(self._shown_s)
        self.start_s, self.end_s = float(self._shown_s[0]), float(self._shown_s[-1])
        self.contact_times_s = np.asarray(contact_times_s, dtype=np.float64)
        self.notes = tuple(notes)

    def true_s(self, shown_s: np.ndarray) -> np.ndarray:
        return np.interp(shown_s, self._shown_s, self._true_s)

    def sample(self, times_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self._motion.sample(self.true_s(times_s))

    def sample_velocity(
        self, times_s: np.ndarray, side: str = "right"
    ) -> tuple[np.ndarray, np.ndarray]:
        # At a contact the rate jumps with the velocity: each side has its own.
        found = np.searchsorted(self._shown_s, times_s, side=side) - 1
        rate = self._rate[np.clip(found, 0, len(self._rate) - 1)][:, None]
        velocity, omega = self._motion.sample_velocity(self.true_s(times_s), side=side)
        return velocity * rate, omega * rate


def on_frames(motion, timing, rule: str) -> Retimed:
    """`motion` with its beginning, end and contacts on whole frames, each by the rule `rule`.

    Where several contacts would share a frame the first has it; the others follow in their order
    without a key, and a note says how many. A flight of less than a frame before the first
    contact is left out.
    """
    choose = RULES[rule]
    contacts = np.unique(np.asarray(motion.contact_times_s, dtype=np.float64))
    contacts = contacts[(contacts >= motion.start_s) & (contacts <= motion.end_s)]
    frames = choose(timing.frame(contacts), timing.fps)
    first_on_frame = np.diff(frames, prepend=-np.inf) > 0
    sharing = len(contacts) - int(first_on_frame.sum())
    contacts, frames = contacts[first_on_frame], frames[first_on_frame]

    true_s, shown = list(contacts), list(frames)
    begin = float(choose(timing.frame(np.array([motion.start_s])), timing.fps)[0])
    if not shown or begin < shown[0]:
        true_s.insert(0, float(motion.start_s))
        shown.insert(0, begin)
    if motion.end_s > true_s[-1] or len(shown) == 1:
        end = float(choose(timing.frame(np.array([motion.end_s])), timing.fps)[0])
        true_s.append(max(float(motion.end_s), true_s[-1] + 1e-9))
        shown.append(max(end, shown[-1] + 1))
    notes = []
    if sharing:
        one = sharing == 1
        notes.append(
            f"{sharing} contact{'' if one else 's'} share{'s' if one else ''} the frame of the one "
            f"before and {'has' if one else 'have'} no key there."
        )
    return Retimed(motion, true_s, timing.time_s(np.array(shown)), timing.time_s(frames), notes)
