"""What building, opening and checking a database of dice takes: `run.py FOLDER [SIMULATIONS]`.

Also replays edges spread over it, and prints how many were refused.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import time
from pathlib import Path

import ifa
import numpy as np


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="is emptied before")
    parser.add_argument("simulations", type=int, nargs="?", default=400_000)
    parser.add_argument("--body", default="d6")
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    if (options.folder / "nodes.manifest").exists() or (options.folder / "shards").exists():
        shutil.rmtree(options.folder)
    body = ifa.bodies.get(options.body)

    began_s = time.perf_counter()
    database = ifa.Database.build(
        body, options.folder, options.simulations, threads=options.threads
    )
    wall_s = time.perf_counter() - began_s
    used = resource.getrusage(resource.RUSAGE_SELF)
    on_disk = sum(path.stat().st_size for path in options.folder.iterdir())
    print(f"built {len(database):,} nodes of {options.simulations:,} simulations in {wall_s:.1f} s")
    print(
        f"  {used.ru_utime + used.ru_stime:.1f} s of cores, {used.ru_maxrss / 1e3:.0f} MB at most"
    )
    print(f"  {on_disk / 1e6:,.0f} MB on disk, {on_disk / len(database):.2f} bytes a node")

    began_s = time.perf_counter()
    ifa.Database.open(options.folder, body)
    print(f"opened in {1e3 * (time.perf_counter() - began_s):.1f} ms")
    began_s = time.perf_counter()
    database.check(options.threads)
    print(f"checked in {time.perf_counter() - began_s:.2f} s")

    leads_on = np.flatnonzero(database.columns["flags"] & 3)
    chosen = leads_on[:: max(1, len(leads_on) // 20_000)]
    refused = 0
    began_s = time.perf_counter()
    for node in chosen:
        try:
            database.replay(int(node))
        except ifa.ReplayError:
            refused += 1
    each_us = 1e6 * (time.perf_counter() - began_s) / len(chosen)
    print(f"replayed {len(chosen):,} edges, {refused} refused, {each_us:.0f} us each")


if __name__ == "__main__":
    main()
