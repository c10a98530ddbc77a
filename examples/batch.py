"""Throw a die many times at once: where it comes to rest, how often it hits, and how fast that was.

python examples/batch.py [throws] [seed]
"""

from __future__ import annotations

import sys
import time

import ifa
import numpy as np

FACES = ("+x", "-x", "+y", "-y", "+z", "-z")


def face_up(quaternions_wxyz: np.ndarray) -> np.ndarray:
    """(n,) index into FACES: which of the body's directions points up the most."""
    w, x, y, z = quaternions_wxyz.T
    up = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)
    return np.argmax(np.stack([up, -up], axis=2).reshape(-1, 6), axis=1)


def main(throws: int = 2000, seed: int = 0) -> None:
    body = ifa.bodies.get("d6", surface="wood")
    states = ifa.sample_states(body, throws, seed=seed)
    began = time.perf_counter()
    batch = ifa.simulate_batch(body, states, until_s=30.0)
    took_s = time.perf_counter() - began

    at_rest = batch.status == ifa.SampleStatus.REST
    print(f"{throws} throws of a {body.name}, {at_rest.sum()} at rest")
    shares = np.bincount(face_up(batch.quaternion_wxyz[at_rest]), minlength=6) / at_rest.sum()
    for face, share in zip(FACES, shares, strict=True):
        print(f"  {face} up  {share:6.1%}  {'#' * round(200 * share)}")
    low, median, high = np.percentile(batch.hit_count, [5, 50, 95])
    print(f"hits of a throw: {median:.0f}, 90 % of them {low:.0f} to {high:.0f}")
    seconds = batch.end_time_s[at_rest]
    print(f"until rest: {np.median(seconds):.2f} s, at most {seconds.max():.2f} s")
    failed = np.mean(batch.status == ifa.SampleStatus.FAILED)
    late = np.mean(batch.status == ifa.SampleStatus.TIME_LIMIT)
    rate = throws / took_s
    print(f"{rate:.0f} simulations a second; {failed:.2%} failed, {late:.2%} not at rest in 30 s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
