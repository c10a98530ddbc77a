"""What a measurement was made on."""

from __future__ import annotations

import os
import platform

import numpy as np

from ifa import _core
from ifa.batch import instruction_sets


def machine() -> dict[str, str]:
    """Processor, system and versions, by the names that a report shows."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "processor": f"{_processor()}, {cores} cores",
        "instruction sets": ", ".join(instruction_sets()),
        "load before": load(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "versions": f"ifa {_core.__version__}, Python {platform.python_version()}, "
        f"numpy {np.__version__}",
    }


def load() -> str:
    """How many processes wanted to run in the last minute, on average: other work slows ours."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "not known here"


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown processor"
