# SPDX-License-Identifier: GPL-3.0-or-later
"""Several bodies solved in one go: one piece of work for the thread, one progress. No bpy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from . import core


@dataclass(frozen=True)
class Task:
    """One body to be solved."""

    name: str  # of the object
    inputs: core.Inputs
    reuse: Any = None


class Progress:
    """Of tasks one after another, each with a progress of the core."""

    def __init__(self, ifa: ModuleType, number: int) -> None:
        self._parts = [ifa.Progress() for _ in range(number)]
        self._done = 0

    def part(self, index: int) -> Any:
        self._done = index
        return self._parts[index]

    @property
    def fraction(self) -> float:
        return (self._done + float(self._parts[self._done].fraction)) / len(self._parts)

    def cancel(self) -> None:
        for part in self._parts:
            part.cancel()


def run(
    ifa: ModuleType,
    tasks: list[Task],
    progress: Progress,
    call: Callable[[ModuleType, Task, Any], Any],
) -> list[Any]:
    """What `call(ifa, task, progress)` gives for each, or the error of those that failed.

    One body's bad marks do not keep the others from being solved. Raises ifa.Cancelled.
    """
    results: list[Any] = []
    for index, task in enumerate(tasks):
        try:
            results.append(call(ifa, task, progress.part(index)))
        except ifa.Cancelled:
            raise
        except ifa.IfaError as error:
            results.append(error)
    return results


def solve(ifa: ModuleType, task: Task, progress: Any) -> core.Outcome:
    return core.solve(ifa, task.inputs, progress, task.reuse)


def explain(ifa: ModuleType, task: Task, progress: Any) -> Any:
    return core.explain(ifa, task.inputs, progress)


def predict(ifa: ModuleType, task: Task, progress: Any) -> dict[str, Any]:
    return core.predict(ifa, task.inputs, progress)
