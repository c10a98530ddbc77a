# SPDX-License-Identifier: GPL-3.0-or-later
"""One solve in a worker thread. No bpy here: bpy outside the main thread crashes.

The running job lives in this module and never in saved properties, so that no file can
remember a job that is gone.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

EXIT_WAIT_S = 5.0


class Job:
    """Runs `work()` in a thread; `progress` has `fraction` and `cancel()`."""

    def __init__(self, work: Callable[[], Any], progress: Any, label: str = "") -> None:
        self.label = label
        self.result: Any = None
        self.error: Exception | None = None
        self.cancelled = False
        self._progress = progress
        self._work = work
        self._thread = threading.Thread(target=self._run, name="ifa-solve", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self.result = self._work()
        except Exception as error:  # shown to the user by the main thread
            self.error = error

    @property
    def done(self) -> bool:
        return not self._thread.is_alive()

    @property
    def fraction(self) -> float:
        return float(self._progress.fraction)

    def cancel(self) -> None:
        """Returns at once; the core stops at its next look at the progress."""
        self.cancelled = True
        self._progress.cancel()

    def join(self, timeout_s: float) -> None:
        self._thread.join(timeout_s)


current: Job | None = None
failure = ""  # why the last solve of this session wrote nothing; shown until the next one


def start(work: Callable[[], Any], progress: Any, label: str = "") -> Job:
    global current
    current = Job(work, progress, label)
    return current


def running() -> Job | None:
    """The job that the panel shows, if one is under way and not cancelled."""
    return current if current is not None and not current.cancelled else None


def clear(job: Job) -> None:
    """Forget `job` once its result is taken."""
    global current
    if current is job:
        current = None


def cancel_all(wait_s: float = 0.0) -> None:
    """For quitting, loading another file and disabling the add-on."""
    global current, failure
    failure = ""
    if current is not None:
        job, current = current, None
        job.cancel()
        job.join(wait_s)
