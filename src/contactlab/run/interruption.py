"""Ctrl-C and SIGTERM end a run in order: after the step, with its state saved."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupted(KeyboardInterrupt):
    """A run was stopped by a signal; `results` are those up to there.

    It is a KeyboardInterrupt, so that a script that runs several scenes ends as its user wanted.
    """

    def __init__(self, results: Any) -> None:
        super().__init__(results.reason)
        self.results = results


class Interruption:
    """While it is entered, the first signal calls `stop`; a second Ctrl-C interrupts at once.

    Signals can be caught in the main thread alone; elsewhere they keep their meaning. `name` is that
    of the signal, empty if none came.
    """

    def __init__(self, stop: Callable[[], None]) -> None:
        self.stop = stop
        self.name = ""
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Interruption:
        if threading.current_thread() is threading.main_thread():
            for number in SIGNALS:
                # a process that was told to ignore Ctrl-C (one in the background) goes on ignoring it
                if signal.getsignal(number) != signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self.name:
            raise KeyboardInterrupt
        self.name = signal.Signals(number).name
        self.stop()
