"""Whether a faster way to simulate yields the same motions: the gate that every speed-up passes.

Both ways simulate the same states. Single contacts must agree where motions have not yet diverged
(the first two impacts); after that chaos makes each motion another, and only distributions
can agree: of the number of hits, of the intervals between them, of their impulses
(Kolmogorov-Smirnov), and of the face that the body comes to rest on (chi-squared). A hit is one of
CONVENTIONS.md: faster than 0.05 m/s.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import ifa
import numpy as np

from .measure import AUDIBLE_SPEED_M_S
from .starts import Array, up_in_body_axes

LARGEST_D = 0.02
LEAST_P = 0.01
LARGEST_ERROR_S = 1e-6
LEAST_EXPECTED = 5.0  # of a class; the usual rule for chi-squared. Rarer classes are put together
CHUNK = 1000  # samples simulated at once, with room for HITS of each: 130 MB
HITS = 2048


@dataclass(frozen=True)
class Verdict:
    """The gate's figures; `passed`: all within their limits.

    first_impacts_s: the largest error of the first two impacts of any speed (inf where one has no
    such impact). first_two_exact and first_two_s: of the first two audible hits the share of
    samples within LARGEST_ERROR_S of the reference, and the largest error. They judge nothing: in a
    few of 10,000 a soft impact and a slide come before the second audible hit, which then depends
    on the step of the slide.
    """

    count_d: float
    interval_d: float
    impulse_d: float
    face_p: float
    first_two_exact: float
    first_two_s: float
    first_impacts_s: float

    @property
    def passed(self) -> bool:
        """Whether all figures are within their limits."""
        within = max(self.count_d, self.interval_d, self.impulse_d) < LARGEST_D
        return within and self.face_p > LEAST_P and self.first_impacts_s <= LARGEST_ERROR_S

    def __str__(self) -> str:
        return (
            f"D {self.count_d:.4f} count, {self.interval_d:.4f} intervals, {self.impulse_d:.4f} "
            f"impulses; p {self.face_p:.3f} resting face; first two impacts: "
            f"{self.first_impacts_s:.1e} s at most (first two audible ones: "
            f"{self.first_two_s:.1e} s, {100.0 * self.first_two_exact:.3f} % within "
            f"{LARGEST_ERROR_S:g} s): "
            f"{'passed' if self.passed else 'FAILED'}"
        )


@dataclass(frozen=True)
class Sample:
    """What is compared of n simulations: audible hits, and the faces they rest on.

    hits (n,); first_two_s (n, 2), a large number where there are fewer; first_impacts_s (n, 2) the
    same of all impacts, soft ones too; intervals_s and
    impulses_n_s of all hits of all simulations; faces (n,) as of `resting_faces`.
    """

    hits: Array
    first_two_s: Array
    first_impacts_s: Array
    intervals_s: Array
    impulses_n_s: Array
    faces: np.ndarray


def simulated(
    body: ifa.Body, states: ifa.State, simulate: Callable[[ifa.State, ifa.Batch], object]
) -> Sample:
    """The sample of `states`, each simulated by `simulate(some of the states, out)`."""
    parts = []
    out: ifa.Batch | None = None
    for begin in range(0, len(states), CHUNK):
        some = states[begin : begin + CHUNK]
        if out is None or len(out) != len(some):
            out = ifa.Batch.allocate(len(some), HITS)
        simulate(some, out)
        parts.append(_of_batch(body, out))
    return Sample(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def compare(candidate: Sample, reference: Sample) -> Verdict:
    """The verdict on simulations, against the reference's of the same states."""
    errors_s = np.abs(candidate.first_two_s - reference.first_two_s).max(axis=1)
    faces = (candidate.faces, reference.faces)
    classes = np.unique(np.concatenate(faces))
    counts = np.array([[np.sum(face == c) for c in classes] for face in faces])
    return Verdict(
        count_d=kolmogorov_smirnov(candidate.hits, reference.hits),
        interval_d=kolmogorov_smirnov(candidate.intervals_s, reference.intervals_s),
        impulse_d=kolmogorov_smirnov(candidate.impulses_n_s, reference.impulses_n_s),
        face_p=chi_squared_p(counts),
        first_two_exact=float((errors_s <= LARGEST_ERROR_S).mean()),
        first_two_s=float(errors_s.max()),
        first_impacts_s=float(np.abs(candidate.first_impacts_s - reference.first_impacts_s).max()),
    )


def kolmogorov_smirnov(a: Array, b: Array) -> float:
    """D of two samples: the largest distance between their empirical distribution functions."""
    a, b = np.sort(a), np.sort(b)
    at = np.concatenate([a, b])
    return float(
        np.abs(
            np.searchsorted(a, at, side="right") / len(a)
            - np.searchsorted(b, at, side="right") / len(b)
        ).max()
    )


def chi_squared_p(counts: Array) -> float:
    """The p-value of rows of counts (2, classes) that are drawn from one distribution."""
    counts = np.asarray(counts, dtype=float)
    counts = counts[:, np.argsort(-counts.sum(axis=0), kind="stable")]
    expected = np.outer(counts.sum(axis=1), counts.sum(axis=0)) / counts.sum()
    rare = expected.min(axis=0) < LEAST_EXPECTED
    if rare.any():  # together, and with the rarest other class where that is still too few
        first = int(np.argmax(rare))
        while first > 0 and expected[:, first:].sum(axis=1).min() < LEAST_EXPECTED:
            first -= 1
        counts = np.column_stack([counts[:, :first], counts[:, first:].sum(axis=1)])
        expected = np.column_stack([expected[:, :first], expected[:, first:].sum(axis=1)])
    if counts.shape[1] < 2:
        return 1.0
    statistic = float(((counts - expected) ** 2 / expected).sum())
    return upper_gamma(0.5 * (counts.shape[1] - 1), 0.5 * statistic)


def upper_gamma(a: float, x: float) -> float:
    """The regularised upper incomplete gamma function Q(a, x); DLMF 8.7.1 and 8.9.2."""
    if x <= 0.0:
        return 1.0
    scale = math.exp(a * math.log(x) - x - math.lgamma(a))
    if x < a + 1.0:  # the series of P converges fast
        term = total = 1.0 / a
        n = a
        while term > 1e-17 * total:
            n += 1.0
            term *= x / n
            total += term
        return max(0.0, 1.0 - scale * total)
    # The continued fraction of Q, from the back: 200 levels are enough for x > a + 1, a < 1000.
    fraction = 0.0
    for k in range(200, 0, -1):
        fraction = k * (k - a) / (x + 2.0 * k + 1.0 - a - fraction)
    return scale / (x + 1.0 - a - fraction)


def resting_faces(body: ifa.Body, batch: ifa.Batch) -> np.ndarray:
    """(n,) the hull's face, from 0, that each sample rests on; -1 where it does not rest."""
    normals = face_normals(body)
    down = -up_in_body_axes(batch.quaternion_wxyz)
    faces = (down @ normals.T).argmax(axis=1)
    return np.where(batch.status == ifa.SampleStatus.REST, faces, -1)


def face_normals(body: ifa.Body) -> Array:
    """(faces, 3) outward unit normals of the hull's faces, triangles in one plane counted once."""
    a, b, c = (body.vertices_m[body.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    kept: list[Array] = []
    for normal in normals:
        if not kept or (np.array(kept) @ normal).max() < 1.0 - 1e-9:
            kept.append(normal)
    return np.array(kept)


def _of_batch(body: ifa.Body, batch: ifa.Batch) -> tuple[np.ndarray, ...]:
    """The fields of a Sample. Raises where a simulation has more hits than the batch keeps."""
    ended = batch.status <= ifa.SampleStatus.IMPACT_LIMIT  # one that failed has no hits
    counts = np.where(ended, batch.hit_count, 0)
    if counts.max() > HITS:
        raise ValueError(f"a simulation has {counts.max()} hits, there is room for {HITS}")
    audible = np.arange(HITS) < counts[:, None]
    audible &= batch.hit_approach_speed_m_s > AUDIBLE_SPEED_M_S
    times_s = [row[mask] for row, mask in zip(batch.hit_time_s, audible, strict=True)]
    absent = 1e9  # not inf: two that both lack a contact agree
    return (
        audible.sum(axis=1).astype(float),
        np.array([[*row[:2], absent, absent][:2] for row in times_s]),
        np.where(np.arange(2) < counts[:, None], batch.hit_time_s[:, :2], absent),
        np.concatenate([np.diff(row) for row in times_s]),
        np.linalg.norm(batch.hit_impulse_n_s[audible], axis=1),
        resting_faces(body, batch),
    )
