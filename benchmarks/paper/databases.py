"""Databases of many simulations, or of as many as there is time for."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ifa

FIRST = 1000  # simulations, before it is known how long they take
GROWTH = 2  # then so many times as many
SLOWER = 3.0  # which takes about so many times as long, as transitions grow faster than nodes


@dataclass(frozen=True)
class Built:
    """A database with its transitions, and how long they took, with all smaller ones before."""

    database: ifa.Database
    build_s: float
    prepare_s: float


def build(
    body: ifa.Body,
    folder: Path,
    simulations: int,
    budget_s: float | None,
    threads: int | None,
    **options: Any,
) -> Built:
    """A database of `simulations`, or of fewer where that would take longer than `budget_s`.

    What is in the folder is gone on from. options: of `ifa.Database.build`.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    size = simulations
    if budget_s is not None:
        size = min(simulations, max(FIRST, there(folder)))
    build_s = prepare_s = 0.0
    while True:
        began_s = time.perf_counter()
        database = ifa.Database.build(body, folder, size, threads=threads, **options)
        built_s = time.perf_counter()
        database.prepare(threads)
        prepared_s = time.perf_counter()
        build_s += built_s - began_s
        prepare_s += prepared_s - built_s
        next_s = SLOWER * (prepared_s - began_s)
        if size == simulations or (
            budget_s is not None and build_s + prepare_s + next_s > budget_s
        ):
            return Built(database, build_s, prepare_s)
        size = min(simulations, GROWTH * size)


def hearing(name: str) -> dict[str, Any]:
    """How a body of the library is sampled and heard, as `ifa.Database.build` takes it."""
    how = ifa.bodies.sampling(name)
    return {"sampling": {"cone_rad": how.cone_rad}, "merge_gap_s": how.merge_gap_s}


def there(folder: Path) -> int:
    """How many simulations a complete database in the folder has; 0 where there is none."""
    try:
        return ifa.Database.open(folder).simulations
    except ifa.IfaFileError:
        return 0
