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


def watched(
    work: Callable[[], Result], progress: ifa.Progress, meter: Meter | None = None
) -> Result:
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
    meter = meter or Meter(sys.stderr)
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
    _VERB = "solving"

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._live = stream.isatty()
        self._begin_s = time.monotonic()
        self._said_s = self._begin_s
        self._drawn = False

    def show(self, fraction: float) -> None:
        """Draw how much is done, from 0 to 1, or say it if it is time."""
        now_s = time.monotonic()
        more = self._more(fraction, now_s)
        elapsed_s = now_s - self._begin_s
        if self._live:
            full = round(self._WIDTH * fraction)
            bar = "#" * full + "." * (self._WIDTH - full)
            self._stream.write(
                f"\r{self._VERB} [{bar}] {100 * fraction:3.0f} %  {elapsed_s:.1f} s {more}\x1b[K"
            )
            self._stream.flush()
            self._drawn = True
        elif now_s - self._said_s >= self._LINE_EVERY_S:
            self._said_s = now_s
            self._stream.write(
                f"ifa: {100 * fraction:.0f} % after {elapsed_s:.0f} s{', ' if more else ''}{more}\n"
            )
            self._stream.flush()

    def end(self) -> None:
        """Wipe the bar."""
        if self._drawn:
            self._stream.write("\r\x1b[K")
            self._stream.flush()

    def _more(self, fraction: float, now_s: float) -> str:
        return ""


class BuildMeter(Meter):
    """Also the rate, and when it will end: from what was done since the first that was new."""

    _VERB = "building"

    def __init__(self, stream: IO[str], simulations: int) -> None:
        super().__init__(stream)
        self._simulations = simulations
        self._first: tuple[float, float] | None = None

    def _more(self, fraction: float, now_s: float) -> str:
        # What an earlier build left counts as done at once, so it must not count for the rate.
        if fraction > 0.0 and self._first is None:
            self._first = fraction, now_s
        if self._first is None or not self._first[0] < fraction < 1.0:
            return ""
        share_per_s = (fraction - self._first[0]) / (now_s - self._first[1])
        rate = share_per_s * self._simulations / ifa._core.SIMULATED_SHARE
        left_s = (1.0 - fraction) / share_per_s
        ends = time.strftime("%H:%M:%S", time.localtime(time.time() + left_s))
        return f"{rate:,.0f} simulations/s, ends {ends} (in {left_s:.0f} s)"
