"""Long work in a thread, with a meter on stderr, and signals that cancel it."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable
from typing import IO, TypeVar

import ifa

_POLL_S = 0.05

Result = TypeVar("Result")


def watched(work: Callable[[], Result], progress: ifa.Progress) -> Result:
    """Run `work` in a thread, showing its progress; Ctrl-C and SIGTERM cancel it."""
    outcome: list[Result] = []
    failure: list[BaseException] = []

    def run() -> None:
        try:
            outcome.append(work())
        except BaseException as error:
            failure.append(error)

    # The handlers only ask the search to stop: an exception inside Thread.join would make Python
    # 3.11 take the running thread for a finished one.
    handlers = {
        number: signal.signal(number, lambda *_: progress.cancel())
        for number in (signal.SIGINT, signal.SIGTERM)
        if threading.current_thread() is threading.main_thread()
    }
    meter = Meter(sys.stderr)
    worker = threading.Thread(target=run, daemon=True)
    try:
        worker.start()
        while worker.is_alive():
            worker.join(_POLL_S)
            meter.show(progress.fraction)
    finally:
        meter.end()
        for number, handler in handlers.items():
            signal.signal(number, handler)
    if failure:
        raise failure[0]
    return outcome[0]


class Meter:
    """A bar on a terminal, a line now and then elsewhere."""

    _WIDTH, _LINE_EVERY_S = 30, 5.0

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._live = stream.isatty()
        self._begin_s = time.monotonic()
        self._said_s = self._begin_s
        self._drawn = False

    def show(self, fraction: float) -> None:
        """Draw how much is done, from 0 to 1, or say it if it is time."""
        now_s = time.monotonic()
        elapsed_s = now_s - self._begin_s
        if self._live:
            full = round(self._WIDTH * fraction)
            bar = "#" * full + "." * (self._WIDTH - full)
            self._stream.write(f"\rsolving [{bar}] {100 * fraction:3.0f} %  {elapsed_s:.1f} s ")
            self._stream.flush()
            self._drawn = True
        elif now_s - self._said_s >= self._LINE_EVERY_S:
            self._said_s = now_s
            self._stream.write(f"ifa: {100 * fraction:.0f} % after {elapsed_s:.0f} s\n")
            self._stream.flush()

    def end(self) -> None:
        """Wipe the bar."""
        if self._drawn:
            self._stream.write("\r\x1b[K")
            self._stream.flush()
