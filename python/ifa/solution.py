"""A solve's result: the motion, how each mark was met, and how good it is."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ifa import _core, arguments
from ifa._core import IfaValueError
from ifa.body import Body
from ifa.constraints import ConstraintReport
from ifa.effects import Plan
from ifa.marks import HEARING, Signature
from ifa.sound import FilePath
from ifa.text_files import write_text


class Motion:
    """A rigid-body motion over the sound's time: exact between contacts, sampled at any time.

    Before `start_s` and after `end_s` the body is held still.
    """

    def __init__(
        self,
        core: _core.Motion,
        retime: Sequence[float] = (),
        energy_gain_j: float = 0.0,
        hearing: Mapping[str, Any] | None = None,
    ) -> None:
        """Wrap a motion of the core; motions come from `ifa.solve`."""
        self._core = core
        #: What was done to the motion, for a verifier to check: for each mark, the interval that
        #: leads to it over the same as simulated, and the energy that a contact could add.
        self.retime = tuple(retime)
        self.energy_gain_j = energy_gain_j
        #: What an event of this motion is: `events`, `audible_speed_m_s` and `merge_gap_s`.
        self.hearing = dict(HEARING if hearing is None else hearing)

    @property
    def start_s(self) -> float:
        """Where the motion begins, s; negative where it must begin before the sound."""
        return self._core.start_s

    @property
    def end_s(self) -> float:
        """Where the motion ends, s."""
        return self._core.end_s

    @cached_property
    def contact_times_s(self) -> np.ndarray:
        """(n,) the instants of all impacts, audible or not."""
        return self._core.hits()[0]

    @cached_property
    def hits(self) -> dict[str, np.ndarray]:
        """Impacts: time_s (n,), impulse_n_s (n, 3), approach_speed_m_s (n,), position_m (n, 3)."""
        names = ("time_s", "impulse_n_s", "approach_speed_m_s", "position_m")
        return dict(zip(names, self._core.hits(), strict=True))

    def sample(self, times_s: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Poses at times_s (n,): positions (n, 3) of the centre of mass, quaternions (n, 4).

        Metres; wxyz, from body to world axes, the sign of each following its predecessor's. Raises
        IfaValueError for times that are not finite.
        """
        positions, quaternions, _, _ = self._core.sample(_times(times_s))
        return positions, quaternions

    def sample_velocity(
        self, times_s: ArrayLike, side: str = "right"
    ) -> tuple[np.ndarray, np.ndarray]:
        """Velocities (n, 3), m/s, and angular velocities (n, 3), rad/s, world axes, as seen.

        At an impact they jump: side="left" is just before it, "right" just after.
        """
        if side not in ("left", "right"):
            raise IfaValueError(f'side: must be "left" or "right", got {side!r}')
        _, _, velocities, spins = self._core.sample(_times(times_s), after=side == "right")
        return velocities, spins

    def difference(
        self, other: Motion, from_s: float | None = None, to_s: float | None = None
    ) -> float:
        """How different two motions of one body are, in bounding radii of the body.

        The root mean square over the body's mass and the time from `from_s` to `to_s` (None: all
        that both motions have) of the distance between where a material point is in the two, after
        `other` is shifted in x and y and turned about z, once, so that this is least. 0 for the
        same motion elsewhere on the ground; the same either way round. To compare takes give the
        first and the last mark: the flight that leads in counts as much as what the marks ask for.
        Sampled at 240 Hz (less over more than 400 s).

        Raises IfaValueError naming the argument: `other` is no Motion or of another body (the
        material may differ), the motions have no time in common, `to_s` is not after `from_s`.
        """
        if not isinstance(other, Motion):
            raise IfaValueError("other: needs an ifa.Motion")
        if from_s is None:
            from_s = max(self.start_s, other.start_s)
        if to_s is None:
            to_s = min(self.end_s, other.end_s)
            if to_s <= arguments.number(from_s, "from_s"):
                raise IfaValueError("other: has no time in common with this motion after from_s")
        return self._core.difference(
            other._core, arguments.number(from_s, "from_s"), arguments.number(to_s, "to_s")
        )

    @cached_property
    def times_s(self) -> np.ndarray:
        """(n,) at 1 kHz or denser, with every impact instant: what OUT.json holds."""
        return self._core.dense_times()

    @cached_property
    def _dense(self) -> tuple[np.ndarray, np.ndarray]:
        return self.sample(self.times_s)

    @property
    def positions_m(self) -> np.ndarray:
        """(n, 3) positions of the centre of mass at `times_s`."""
        return self._dense[0]

    @property
    def quaternions_wxyz(self) -> np.ndarray:
        """(n, 4) orientations at `times_s`, from body to world axes."""
        return self._dense[1]


@dataclass(frozen=True)
class Event:
    """How one mark was met.

    target_s, achieved_s: the mark and the motion's hit. error_s: of the interval that leads here as
    simulated, before retiming. error_retimed_s: achieved_s - target_s. retime: that interval in the
    motion over simulated. excess: |C v_eval|^2 of the change made to the impact that leads here (1
    is the edge of plausibility); the last event's also covers the change that brings the body to
    rest. factors: velocity, orientation, time, amplitude, length and centroid, each in [0, 1]
    (paper eqs. 3 to 8).
    """

    target_s: float
    achieved_s: float
    error_s: float
    error_retimed_s: float
    retime: float
    excess: float
    factors: dict[str, float]

    @property
    def retiming(self) -> float:
        """How far `retime` is from 1, the same for faster and slower: max(r, 1/r) - 1."""
        return max(self.retime, 1.0 / self.retime) - 1.0


@dataclass(frozen=True)
class Stage:
    """What a solve had after one of its rungs.

    time_s: since it began; like `Solution.solve_s` it differs between runs. rung: that had just
    been run. score, succeeded, plausible: of the best motion so far.
    """

    time_s: float
    rung: int
    score: float
    succeeded: bool
    plausible: bool


@dataclass(frozen=True)
class Prediction:
    """What `ifa.predict` expects of a solve.

    time_s: how long it takes on this machine. error: of its motion, 1 - Score (0 is perfect, 1 no
    motion). reached: the calibration came to the end of this climb, so that both figures are what
    it saw there. calibration_s: how long it took, once for all that it predicts.
    """

    accuracy: str
    time_s: float
    error: float
    reached: bool
    calibration_s: float


@dataclass(frozen=True)
class Solution:
    """A motion and how good it is; CONVENTIONS.md defines every figure."""

    motion: Motion
    body: Body  # with the material the motion was made with
    marks: Signature
    score: float
    score_without_sound: float
    succeeded: bool
    plausible: bool
    events: list[Event]
    max_abs_error_s: float
    missed_hits: int
    extra_hits: int
    max_penetration_m: float
    max_energy_gain_j: float
    solve_s: float
    simulated_s: float
    effects: Plan
    restitution: float
    friction: float
    seed: int
    rung: int
    energy_gain_j: float = 0.0
    method: str = "forward"
    #: Name of the preset; None where there is none (method="graph").
    accuracy: str | None = None
    #: What was expected of this solve, if anything was.
    prediction: Prediction | None = None
    #: Of method="graph": `kind`, the `score` of the path in the graph, before its splices were
    #: connected, and the `bound` that no other path of the graph exceeds.
    search: dict[str, Any] = field(default_factory=dict)
    #: How each constraint of the marks was met, in their order.
    constraints: tuple[ConstraintReport, ...] = ()
    #: How the solve got there, rung by rung: what was the best when. Only of the solve's own
    #: motion, not of further takes; not part of OUT.json.
    history: tuple[Stage, ...] = field(default=(), repr=False, compare=False)
    #: Further takes: motions clearly different from this one and from one another, best first.
    others: tuple[Solution, ...] = field(default=(), repr=False, compare=False)
    #: What `ifa.solve(..., reuse=solution)` goes on from.
    kept: Any = field(default=None, repr=False, compare=False)

    @property
    def error(self) -> float:
        """1 - Score: 0 is perfect, 1 a motion that misses a mark. What `ifa.predict` predicts."""
        return 1.0 - self.score

    @property
    def constraints_met(self) -> bool:
        """Whether every constraint is met: positions within 1 cm, orientations within 4 degrees.

        Neither `succeeded` nor `plausible` asks for it.
        """
        return all(report.met for report in self.constraints)

    @property
    def takes(self) -> tuple[Solution, ...]:
        """This motion, the same for any number of takes, and the others, best first."""
        return (self, *self.others)

    def to_dict(self) -> dict[str, Any]:
        """What `ifa solve --json` prints: every figure, JSON-ready, without the motion.

        `hearing` says what an event is: `events`, `audible_speed_m_s` and `merge_gap_s`.
        `constraints` and `constraints_met` are there where constraints are, `predicted` (time_s,
        error) where a prediction was made.
        """
        left_out = {
            "motion",
            "body",
            "marks",
            "others",
            "kept",
            "history",
            "constraints",
            "prediction",
        }
        names = [item.name for item in fields(self) if item.name not in left_out]
        out = {name: getattr(self, name) for name in names}
        out["events"] = [vars(event) for event in self.events]
        out["effects"] = self.effects.to_dict()
        if self.constraints:
            out["constraints"] = [report.to_dict() for report in self.constraints]
            out["constraints_met"] = self.constraints_met
        if self.prediction is not None:
            out["predicted"] = {"time_s": self.prediction.time_s, "error": self.prediction.error}
        out["hearing"] = self.motion.hearing
        out["version"] = _core.__version__
        return out

    def write(self, path: FilePath) -> None:
        """Write OUT.json: `to_dict`, body, marks, hits, and poses at 1 kHz or denser.

        Raises IfaFileError; nothing half-written is left.
        """
        if Path(path).suffix.lower() != ".json":
            raise IfaValueError(f"{path}: this version writes .json")
        motion = self.motion
        out = self.to_dict()
        out["body"] = self.body.to_dict()
        out["marks"] = self.marks.to_dict()
        out["hits"] = {name: values.tolist() for name, values in motion.hits.items()}
        out["times_s"] = motion.times_s.tolist()
        out["positions_m"] = motion.positions_m.tolist()
        out["quaternions_wxyz"] = motion.quaternions_wxyz.tolist()
        write_text(path, json.dumps(out, allow_nan=False) + "\n")


def _times(times_s: ArrayLike) -> np.ndarray:
    return arguments.array(times_s, "times_s", (None,))
