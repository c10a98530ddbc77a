"""Many simulations at once: random states to start from, and runs into reusable arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from ifa import _core, arguments
from ifa._core import IfaValueError
from ifa.body import Body
from ifa.simulation import GRAVITY_M_S2, Hits, State, gravity_vector, state_arrays, time_limit

_HITS = 64
_MOST_SAMPLES = 2**31 - 1
_SAMPLING: dict[str, Any] = {
    "cone_rad": np.pi / 6.0,
    "speed_m_s": (0.5, 4.0),
    "spin_rad_s": (0.0, 20.0),
}  # the paper's, section 5.1
_MOST_HITS = 100_000  # the engine stops a run there


class SampleStatus(IntEnum):
    """How a sample ended; all but NOT_RUN are `Run.status` in capitals.

    FAILED: the engine gave it up, and it has neither an end nor hits. NOT_RUN: the batch was
    cancelled before it was done. CONTACT: sustained contact began, and is off.
    """

    REST = 0
    TIME_LIMIT = 1
    IMPACT_LIMIT = 2
    FAILED = 3
    NOT_RUN = 4
    CONTACT = 5


@dataclass(frozen=True, eq=False)
class Batch:
    """What `simulate_batch` yields for n samples and m hits of each; row i is sample i's.

    status (n,) uint8, codes of SampleStatus. end_time_s (n,): when it ended; where that is at rest,
    when rest began. position_m (n, 3), quaternion_wxyz (n, 4), velocity_m_s (n, 3),
    angular_velocity_rad_s (n, 3): the state at the end, as in State; the sign of the quaternion is
    free. hit_count (n,) int32: all its hits, also those beyond the m that are kept. hit_time_s
    (n, m), hit_impulse_n_s (n, m, 3), hit_approach_speed_m_s (n, m), hit_position_m (n, m, 3): as
    in Hits; beyond a sample's hits they hold what was there before. float64 where nothing is said.
    """

    status: np.ndarray
    end_time_s: np.ndarray
    position_m: np.ndarray
    quaternion_wxyz: np.ndarray
    velocity_m_s: np.ndarray
    angular_velocity_rad_s: np.ndarray
    hit_count: np.ndarray
    hit_time_s: np.ndarray
    hit_impulse_n_s: np.ndarray
    hit_approach_speed_m_s: np.ndarray
    hit_position_m: np.ndarray

    @classmethod
    def allocate(cls, n: int, hits: int = _HITS) -> Batch:
        """Arrays for n samples and `hits` hits of each, to be filled (and filled again) as `out`.

        All zeros, but NOT_RUN and the unit quaternion. Raises IfaValueError naming the argument.
        """
        n = arguments.whole(n, "n", _MOST_SAMPLES)
        hits = arguments.whole(hits, "hits", _MOST_HITS)
        batch = cls(**{name: np.zeros(shape, t) for name, (t, shape) in _layout(n, hits).items()})
        batch.status[:] = SampleStatus.NOT_RUN
        batch.quaternion_wxyz[:, 0] = 1.0
        return batch

    def __len__(self) -> int:
        """The number of samples."""
        return len(self.status)

    @property
    def states(self) -> State:
        """A copy of the states at the end, n rows."""
        return State(
            self.position_m, self.quaternion_wxyz, self.velocity_m_s, self.angular_velocity_rad_s
        )

    def hits(self, i: int) -> Hits:
        """The hits of sample i that were kept, as views of this batch's arrays.

        There were more where `hit_count[i]` is larger. Failed or not run: none.
        """
        nothing = self.status[i] in (SampleStatus.FAILED, SampleStatus.NOT_RUN)
        count = 0 if nothing else int(self.hit_count[i])
        kept = min(count, self.hit_time_s.shape[1])
        return Hits(
            self.hit_time_s[i, :kept],
            self.hit_impulse_n_s[i, :kept],
            self.hit_approach_speed_m_s[i, :kept],
            self.hit_position_m[i, :kept],
        )


def sample_states(
    body: Body,
    n: int,
    seed: int = 0,
    first: int = 0,
    *,
    cone_rad: float = _SAMPLING["cone_rad"],
    speed_m_s: tuple[float, float] = _SAMPLING["speed_m_s"],
    spin_rad_s: tuple[float, float] = _SAMPLING["spin_rad_s"],
    threads: int | None = None,
) -> State:
    """Random states just before a contact (paper section 5.1), a State with n rows.

    The orientation is uniform, the lowest point touches the ground, the centre of mass is above the
    origin. The velocity is cosine-weighted within `cone_rad` about straight down (0 to pi/2; 80
    degrees suit bodies that roll), its size uniform in `speed_m_s` (least, most). The spin is of
    any direction, its size uniform in `spin_rad_s`. Row k is sample `first + k` of the seed,
    whatever n and `threads` are. Raises IfaValueError naming the argument.
    """
    if not isinstance(body, Body):
        raise IfaValueError("body: needs an ifa.Body")
    n = arguments.whole(n, "n", _MOST_SAMPLES)
    return State(
        *_core.sample_states(
            body._core,
            n,
            seed=arguments.whole(seed, "seed", 2**64 - 1),
            first=arguments.whole(first, "first", 2**64 - max(n, 1)),
            **sampling_options(
                {"cone_rad": cone_rad, "speed_m_s": speed_m_s, "spin_rad_s": spin_rad_s}
            ),
            threads=arguments.threads(threads),
        )
    )


def sampling_options(given: Mapping[str, Any] | None) -> dict[str, Any]:
    """`cone_rad`, `speed_m_s` and `spin_rad_s`, checked; those of `sample_states` where absent."""
    if given is not None and not isinstance(given, Mapping):
        raise IfaValueError(f"sampling: needs a mapping or None, got {given!r}")
    options = {**_SAMPLING, **(given or {})}
    arguments.only_known(options, _SAMPLING)
    cone = arguments.number(options["cone_rad"], "cone_rad")
    if not 0.0 <= cone <= np.pi / 2.0:
        raise IfaValueError(f"cone_rad: must be from 0 to pi/2, got {cone:g}")
    ranges = {name: _range(options[name], name) for name in ("speed_m_s", "spin_rad_s")}
    return {"cone_rad": cone, **ranges}


def instruction_sets() -> tuple[str, ...]:
    """The instruction sets for which batches are compiled and that run here, the widest last."""
    return tuple(_core.instruction_sets())


def simulate_batch(
    body: Body | Sequence[Body],
    states: State,
    *,
    step_s: float = 1e-3,
    until_s: float | None = None,
    gravity_m_s2: ArrayLike = GRAVITY_M_S2,
    hits: int | None = None,
    threads: int | None = None,
    instruction_set: str | None = None,
    out: Batch | None = None,
    progress: _core.Progress | None = None,
) -> Batch:
    """`simulate` from each of n states, on threads and without the GIL.

    body: one, or a sequence of n. states: n rows (0 is fine). step_s, until_s, gravity_m_s2: as in
    `simulate`. hits: how many are kept of each sample (None: 64, or what `out` has room for).
    threads: 1 or more, None is one for each core. instruction_set: "scalar", "sse2", "avx2" or
    "avx512", which simulate 1, 2, 4 or 8 samples of one body side by side; None is the widest that
    this processor has (`instruction_sets` lists them). The bytes of a sample depend on its own body
    and state only: not on the threads, the order, the set, or what else is in the batch.

    out: a Batch whose arrays are written into and which is then returned, for example of an earlier
    call or of the caller's own memory. They must have the types and shapes of `Batch.allocate(n,
    hits)`, be C-contiguous and writable and not overlap; they are never copied. What a sample does
    not have stays as it was.

    progress: read its `fraction` and call its `cancel()` from another thread. After Cancelled (or
    Ctrl-C) the samples of `out` that were done are whole and the status of the others is NOT_RUN.
    Raises IfaValueError naming the argument and row, before anything is simulated or written.
    """
    if not isinstance(states, State) or states.position_m.ndim != 2:
        raise IfaValueError("states: needs an ifa.State of n rows, with position_m of shape (n, 3)")
    bodies = _bodies(body, len(states))
    gravity = gravity_vector(gravity_m_s2)
    step = arguments.positive(step_s, "step_s")
    limit = time_limit(until_s, gravity)
    workers = arguments.threads(threads)
    room = None if hits is None else arguments.whole(hits, "hits", _MOST_HITS)
    if instruction_set is not None and instruction_set not in instruction_sets():
        raise IfaValueError(
            f"instruction_set: {instruction_set!r} does not run here; there are "
            f"{', '.join(instruction_sets())}"
        )
    arguments.check_progress(progress)
    if out is None:
        out = Batch.allocate(len(states), _HITS if room is None else room)
    else:
        _check(out, len(states), room)
    _core.simulate_batch(
        [one._core for one in bodies],
        *state_arrays(states),
        step_s=step,
        until_s=limit,
        gravity_m_s2=gravity,
        hits=out.hit_time_s.shape[1],
        threads=workers,
        instruction_set=instruction_set or "",
        out=vars(out),
        progress=progress,
    )
    return out


def _layout(n: int, m: int) -> dict[str, tuple[DTypeLike, tuple[int, ...]]]:
    """The type and shape of each array of a Batch."""
    return {
        "status": (np.uint8, (n,)),
        "end_time_s": (np.float64, (n,)),
        "position_m": (np.float64, (n, 3)),
        "quaternion_wxyz": (np.float64, (n, 4)),
        "velocity_m_s": (np.float64, (n, 3)),
        "angular_velocity_rad_s": (np.float64, (n, 3)),
        "hit_count": (np.int32, (n,)),
        "hit_time_s": (np.float64, (n, m)),
        "hit_impulse_n_s": (np.float64, (n, m, 3)),
        "hit_approach_speed_m_s": (np.float64, (n, m)),
        "hit_position_m": (np.float64, (n, m, 3)),
    }


def _check(out: Any, n: int, hits: int | None) -> None:
    """Refuse arrays that the core could not write n samples into, the bad one named."""
    if not isinstance(out, Batch):
        raise IfaValueError(f"out: needs an ifa.Batch or None, got {out!r}")
    if hits is None:
        shape = np.shape(out.hit_time_s)
        hits = shape[1] if len(shape) == 2 else _HITS
    for name, (dtype, shape) in _layout(n, hits).items():
        given = getattr(out, name)
        if not isinstance(given, np.ndarray):
            raise IfaValueError(f"out.{name}: needs a numpy array, got {type(given).__name__}")
        if given.dtype != dtype:
            wanted = np.dtype(dtype).name
            raise IfaValueError(f"out.{name}: needs dtype {wanted}, got {given.dtype}")
        if given.shape != shape:
            raise IfaValueError(f"out.{name}: needs shape {shape}, got {given.shape}")
        if not (given.flags.c_contiguous and given.flags.aligned):
            raise IfaValueError(f"out.{name}: must be C-contiguous and aligned")
        if not given.flags.writeable:
            raise IfaValueError(f"out.{name}: must be writable")
    for a, b in combinations([field.name for field in fields(Batch)], 2):
        if np.may_share_memory(getattr(out, a), getattr(out, b)):  # exact for contiguous arrays
            raise IfaValueError(f"out.{b}: must not overlap out.{a}")


def _bodies(body: Any, n: int) -> Sequence[Body]:
    """One body, or n of them."""
    if isinstance(body, Body):
        return [body]
    if not isinstance(body, Sequence) or isinstance(body, str):
        raise IfaValueError(f"body: needs an ifa.Body or a sequence of them, got {body!r}")
    for row, one in enumerate(body):
        if not isinstance(one, Body):
            raise IfaValueError(f"body: row {row} must be an ifa.Body, got {one!r}")
    if len(body) != n:
        raise IfaValueError(f"body: needs one, or one for each of the {n} states, got {len(body)}")
    return body


def _range(value: Any, field: str) -> tuple[float, float]:
    """(least, most), both finite and 0 or more."""
    least, most = arguments.array(value, field, (2,))
    if not 0.0 <= least <= most < np.inf:
        raise IfaValueError(f"{field}: needs 0 <= least <= most, got ({least:g}, {most:g})")
    return float(least), float(most)
