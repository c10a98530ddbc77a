"""The measured costs as the package keeps them, in ifa/data/effects.json."""

from __future__ import annotations

import platform
import time
from collections.abc import Iterable

import ifa
import numpy as np
from ifa.effect_costs import Cost, CostTable
from ifa.tradeoff.machine import machine

from .measure import Row


def cost_table(rows: Iterable[Row]) -> CostTable:
    """Of each effect its first row; a row of several effects together is left out."""
    costs: dict[str, Cost] = {}
    for row in rows:
        if row.effect in ifa.EFFECTS and row.effect not in costs:
            costs[row.effect] = Cost(row.ratio, row.spread, row.scene)
    return CostTable(
        machine=machine()["processor"],
        date=time.strftime("%Y-%m-%d"),
        versions={
            "ifa": ifa.__version__,
            "Python": platform.python_version(),
            "numpy": np.__version__,
        },
        costs=costs,
    )
