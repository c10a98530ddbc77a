"""The contact-time signature of a sound: when its contacts happen (paper section 3)."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ifa import _core
from ifa import constraints as poses
from ifa._core import IfaValueError
from ifa.arguments import array, number, positive
from ifa.constraints import Constraint
from ifa.mark_files import fields_of, read_marks
from ifa.simulation import Run
from ifa.sound import FilePath, file_name
from ifa.text_files import write_text

Ending = Literal["rest", "open"]

MERGE_GAP_S: float = _core.MERGE_GAP_S
"""Contacts closer than 10 ms are one event (paper section 4)."""

AUDIBLE_SPEED_M_S: float = _core.AUDIBLE_SPEED_M_S
"""Impacts that approach slower are silent."""

HEARING: Mapping[str, Any] = {
    "events": "audible",
    "audible_speed_m_s": AUDIBLE_SPEED_M_S,
    "merge_gap_s": MERGE_GAP_S,
}
"""What an event of a motion is, unless told otherwise (CONVENTIONS.md, "Hits, events, rest")."""


class Signature:
    """Marks: the times at which a sound's contacts happen, and what is known about each.

    Immutable. Everything is checked when it is made, and an error names the mark, counted from 1.

    Args:
        times_s: Shape (n,): when each contact starts, in seconds from the start of the sound,
            increasing, at least `merge_gap_s` apart. Kept as given.
        durations_s: Shape (n,): 0 for a discrete contact, more for continuous activity such as
            sliding or chattering. Left out: all discrete.
        amplitudes: Shape (n,): how loud each contact is, in any unit; only ratios to the first
            count, which must not be 0. Left out: unknown, and not asked of the motion.
        centroids_s: Shape (n,): the mean time of the loudness of a contact with a duration, from
            its start (tau of paper eq. 8); NaN where unknown.
        ending: "rest": the body comes to rest after the last mark without a further hit; "open":
            anything may follow.
        merge_gap_s: Marks closer than this, start to start, are an error.
        constraints: `ifa.Orientation` and `ifa.Position`: how the body shall lie, and where, at
            some of the marks or at rest.

    Raises:
        IfaValueError: No marks, marks out of order or too close, a mark inside the span of the one
            before, negative or not finite values, a centroid outside its span; a constraint of a
            mark that is not there, two positions of one mark, an orientation at rest without the
            ending "rest".

    Example:
        >>> marks = Signature([0.357, 0.486, 0.76], durations_s=[0, 0, 0.2])
        >>> len(marks)
        3
    """

    __slots__ = (
        "_amplitudes",
        "_centroids_s",
        "_constraints",
        "_durations_s",
        "_marks",
        "_merge_gap_s",
        "_times_s",
    )

    def __init__(
        self,
        times_s: ArrayLike,
        durations_s: ArrayLike | None = None,
        amplitudes: ArrayLike | None = None,
        centroids_s: ArrayLike | None = None,
        ending: Ending = "rest",
        *,
        merge_gap_s: float = MERGE_GAP_S,
        constraints: Sequence[Constraint] = (),
    ) -> None:
        def optional(values: ArrayLike | None, field: str) -> NDArray[np.float64] | None:
            return None if values is None else array(values, field, (None,))

        _check_ending(ending)
        self._merge_gap_s = number(merge_gap_s, "merge_gap_s")
        marks = _core.Marks(
            array(times_s, "times_s", (None,)),
            optional(durations_s, "durations_s"),
            optional(amplitudes, "amplitudes"),
            optional(centroids_s, "centroids_s"),
            ending,
            self._merge_gap_s,
            **poses.for_core(poses.sequence(constraints)),
        )
        self._constraints = poses.from_core(marks)
        self._marks = marks  # what the core's functions take
        self._times_s = _read_only(marks.times_s)
        self._durations_s = _read_only(marks.durations_s)
        self._amplitudes = None if marks.amplitudes is None else _read_only(marks.amplitudes)
        self._centroids_s = _read_only(marks.centroids_s)

    @property
    def times_s(self) -> NDArray[np.float64]:
        """Shape (n,): the start of each contact, seconds from the start of the sound."""
        return self._times_s

    @property
    def durations_s(self) -> NDArray[np.float64]:
        """Shape (n,): 0 for discrete contacts."""
        return self._durations_s

    @property
    def amplitudes(self) -> NDArray[np.float64] | None:
        """Shape (n,), not normalised; None where unknown."""
        return self._amplitudes

    @property
    def centroids_s(self) -> NDArray[np.float64]:
        """Shape (n,): seconds from each contact's start; NaN where unknown."""
        return self._centroids_s

    @property
    def ending(self) -> Ending:
        """What follows the last mark, "rest" or "open"."""
        ending: Ending = self._marks.ending
        return ending

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """Orientations and positions that are asked, by mark, those at rest last."""
        return self._constraints

    def with_constraints(self, constraints: Sequence[Constraint]) -> Self:
        """These marks with these constraints beside their own.

        Raises IfaValueError as the class does.
        """
        return type(self)(
            self._times_s,
            self._durations_s,
            self._amplitudes,
            self._centroids_s,
            self.ending,
            merge_gap_s=self._merge_gap_s,
            constraints=[*self._constraints, *poses.sequence(constraints)],
        )

    @classmethod
    def read(
        cls,
        path: FilePath,
        sound: FilePath | None = None,
        ending: Ending | None = None,
        *,
        merge_gap_s: float = MERGE_GAP_S,
    ) -> Self:
        r"""Read marks from a file; its ending says the format.

        `.txt` is an Audacity label track: on each line start, end and text between tabs, times in
        seconds with a decimal point or comma. The text and the frequency lines that Audacity adds
        for spectral selections (they begin with a backslash) are ignored. Labels shorter than
        `merge_gap_s` are discrete. `.json` is what `write` writes.

        Args:
            path: The file with the marks.
            sound: The sound that was marked: gives the amplitudes and centroids, in place of any
                that are in the file (`with_sound`).
            ending: "rest" or "open", in place of the file's. A label track has none: "rest".
            merge_gap_s: As for the class.

        Raises:
            IfaFileError: A file is missing or cannot be read; the message names the file and line.
            IfaValueError: The marks are not valid; the message names the file, line and mark.
        """
        if ending is not None:
            _check_ending(ending)
        merge_gap_s = number(merge_gap_s, "merge_gap_s")
        name = file_name(path)
        file = read_marks(name, merge_gap_s)
        fields = file.fields if ending is None else file.fields | {"ending": ending}
        try:
            marks = cls(**fields, merge_gap_s=merge_gap_s)
        except IfaValueError as error:
            mark = re.match("mark ([0-9]+) ", str(error))
            line = f", line {file.lines[int(mark[1]) - 1]}" if mark and file.lines else ""
            raise IfaValueError(f"{name}{line}: {error}") from None
        return marks if sound is None else marks.with_sound(sound)

    @classmethod
    def from_run(
        cls,
        run: Run,
        *,
        audible_speed_m_s: float = AUDIBLE_SPEED_M_S,
        merge_gap_s: float = MERGE_GAP_S,
    ) -> Self:
        """The marks of a simulated run: what a recording of it would be marked with.

        In the audible sense, and of hits only: slip makes no mark and lengthens none. Hits that
        approach at `audible_speed_m_s` or faster, each less than `merge_gap_s` after the one
        before, are one mark at the time of the first, in seconds of the run. A chain shorter than
        the merge gap is discrete, a longer one has that duration and the centroid of its impulses.
        Amplitudes are sqrt(sum |J|^2), in N s. The ending is "rest" where the run came to rest.

        Args:
            run: Of `ifa.simulate`.
            audible_speed_m_s: Above 0.
            merge_gap_s: Above 0.

        Raises:
            IfaValueError: No hit of the run is audible, or an argument cannot be.

        Example:
            >>> import ifa
            >>> ball = ifa.bodies.get("ball")
            >>> run = ifa.simulate(ball, ifa.State([0.0, 0.0, 0.5]), until_s=1.0)
            >>> Signature.from_run(run).times_s.round(4).tolist()
            [0.3149, 0.8188]
        """
        if not isinstance(run, Run):
            raise IfaValueError(f"run: needs an ifa.Run, got {type(run).__name__}")
        gap_s = positive(merge_gap_s, "merge_gap_s")
        marks = _core.run_marks(
            run.hits.time_s,
            run.hits.impulse_n_s,
            run.hits.approach_speed_m_s,
            at_rest=run.status == "rest",
            audible_speed_m_s=positive(audible_speed_m_s, "audible_speed_m_s"),
            merge_gap_s=gap_s,
        )
        return cls(
            marks.times_s,
            marks.durations_s,
            marks.amplitudes,
            marks.centroids_s,
            marks.ending,
            merge_gap_s=gap_s,
        )

    @classmethod
    def from_dict(cls, marks: dict[str, Any], *, merge_gap_s: float = MERGE_GAP_S) -> Self:
        """The inverse of `to_dict`.

        Only `time_s` is required of an event, and amplitudes are given for all events or none. An
        orientation's `direction` may be left out: up.

        Raises:
            IfaValueError: A key is unknown or missing, a value no number, or the marks not valid.
        """
        return cls(**fields_of(marks), merge_gap_s=merge_gap_s)

    def to_dict(self) -> dict[str, Any]:
        """The marks as plain Python values: `events`, one dictionary for each mark, and `ending`.

        An event has `time_s`, `duration_s`, `amplitude` and `centroid_s`; None where unknown. Where
        constraints ask for it, it also has `position_m`, [x, y], and `orientation`, an object with
        `body_direction` and `direction` (or a list of them); what is asked at rest is
        `rest_orientation`, beside `events`.
        """
        amplitudes = [None] * len(self) if self._amplitudes is None else self._amplitudes.tolist()
        centroids = [None if np.isnan(c) else c for c in self._centroids_s.tolist()]
        rows = zip(
            self._times_s.tolist(), self._durations_s.tolist(), amplitudes, centroids, strict=True
        )
        keys = ("time_s", "duration_s", "amplitude", "centroid_s")
        asked = self._constraints
        return {
            "events": [
                dict(zip(keys, row, strict=True)) | poses.to_fields(asked, k)
                for k, row in enumerate(rows)
            ],
            "ending": self.ending,
            **poses.to_fields(asked, "rest"),
        }

    def write(self, path: FilePath) -> None:
        """Write the marks as JSON, exactly: `read` gives equal marks.

        The file appears whole or not at all.

        Raises:
            IfaValueError: The name does not end in `.json`.
            IfaFileError: The file cannot be written.
        """
        name = file_name(path)
        if Path(name).suffix.lower() != ".json":
            raise IfaValueError(f"{name}: marks are written as JSON, so its name must end in .json")
        content = self.to_dict()
        events = ",\n".join("    " + json.dumps(event) for event in content.pop("events"))
        others = ",\n".join(f'  "{key}": {json.dumps(value)}' for key, value in content.items())
        text = f'{{\n  "events": [\n{events}\n  ],\n{others}\n}}\n'
        write_text(name, text)

    def with_sound(self, path: FilePath) -> Self:
        """These marks with the amplitudes, and the centroids of spans, of a sound file.

        The amplitude of a discrete mark is the largest |sample| in the 20 ms after it, or in half
        the gap to the next mark if that is shorter (paper section 3); of a span, the largest in it.
        Centroids weight the span's time by its root mean square in bins of 1 ms.

        Raises:
            IfaFileError: The sound cannot be read.
            IfaValueError: A mark lies outside the sound, or the sound is silent at the first one.
        """
        name = file_name(path)
        try:
            amplitudes, centroids_s = _core.mark_amplitudes(name, self._times_s, self._durations_s)
        except IfaValueError as error:
            raise IfaValueError(f"{name}: {error}") from None
        return type(self)(
            self._times_s,
            self._durations_s,
            amplitudes,
            centroids_s,
            self.ending,
            merge_gap_s=self._merge_gap_s,
            constraints=self._constraints,
        )

    def __len__(self) -> int:
        return len(self._times_s)

    def __repr__(self) -> str:
        spans = int(np.count_nonzero(self._durations_s))
        asked = f", {len(self._constraints)} constraints" if self._constraints else ""
        return (
            f"<Signature: {len(self)} marks ({spans} with a duration) from {self._times_s[0]:g} s "
            f'to {self._times_s[-1]:g} s, ending "{self.ending}", '
            f"{'without' if self._amplitudes is None else 'with'} amplitudes{asked}>"
        )

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, Signature) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (type(self), self.to_dict(), self._merge_gap_s)

    def _key(self) -> tuple[Any, ...]:
        keys = ("time_s", "duration_s", "amplitude", "centroid_s")
        rows = (tuple(event[key] for key in keys) for event in self.to_dict()["events"])
        return (*rows, self.ending, *self._constraints)


def _check_ending(ending: object) -> None:
    if ending not in ("rest", "open"):
        raise IfaValueError(f'ending: must be "rest" or "open", got {ending!r}')


def _rebuilt(cls: type[Signature], marks: dict[str, Any], merge_gap_s: float) -> Signature:
    return cls.from_dict(marks, merge_gap_s=merge_gap_s)


def _read_only(values: NDArray[np.float64]) -> NDArray[np.float64]:
    values.flags.writeable = False
    return values
