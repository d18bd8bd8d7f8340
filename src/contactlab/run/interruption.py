"""Ctrl-C, SIGTERM and SIGHUP (a terminal that is closed) end a run in order: after the step, with its state saved.

Little of the standard library is imported: the program listens before it imports anything else.
"""

from __future__ import annotations

import signal
import sys
import threading

TYPE_CHECKING = False  # the module typing takes longer to import than all of this
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType, TracebackType
    from typing import Any

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
AGAIN = 0.02  # s after which an interrupt that Python dropped is repeated

_unanswered: list[str] = []


class Interrupted(KeyboardInterrupt):
    """A run was stopped by a signal; `results` are those up to there.

    It is a KeyboardInterrupt, so that a script that runs several scenes ends as its user wanted.
    """

    def __init__(self, results: Any) -> None:
        super().__init__(results.reason)
        self.results = results


def _interrupt(number: int, frame: FrameType | None) -> None:
    _unanswered.append(signal.Signals(number).name)
    raise KeyboardInterrupt


def _repeat_if_dropped(dropped: Any) -> None:
    """Python drops what is raised in a destructor or a weak reference's callback: the interrupt comes once more."""
    if dropped.exc_type is KeyboardInterrupt:
        main = threading.main_thread().ident or 0
        timer = threading.Timer(AGAIN, signal.pthread_kill, (main, signal.SIGINT))
        timer.daemon = True
        timer.start()
    else:
        sys.__unraisablehook__(dropped)


def _listen(handler: Callable[[int, FrameType | None], None]) -> dict[signal.Signals, Any]:
    """Let `handler` have the signals that this process does not ignore; return the handlers before."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    heard = [number for number in SIGNALS if signal.getsignal(number) not in (signal.SIG_IGN, None)]
    return {number: signal.signal(number, handler) for number in heard}


def interrupt_on_signals() -> None:
    """From here on each of the signals raises KeyboardInterrupt, and none is lost; for programs."""
    _listen(_interrupt)
    sys.unraisablehook = _repeat_if_dropped


def unanswered() -> bool:
    """Return whether a signal came that ended nothing, as the code that it interrupted dropped it; clear it."""
    found = bool(_unanswered)
    _unanswered.clear()
    return found


class Interruption:
    """Context in which a signal ends a run: immediately while it is built, by `stop` once that is known.

    A second signal interrupts immediately. Signals can be caught in the main thread alone; elsewhere they keep their
    meaning. `name` is the name of the signal, empty if none came.
    """

    def __init__(self) -> None:
        self.name = _unanswered[-1] if _unanswered else ""
        self.stop: Callable[[], None] | None = None
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Interruption:
        self._before = _listen(self._handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)

    def ends_by(self, stop: Callable[[], None]) -> None:
        """From here on a signal calls `stop`, as one does that came before and was dropped."""
        self.stop = stop
        if self.name:
            _unanswered.clear()
            stop()

    def _handle(self, number: int, frame: FrameType | None) -> None:
        again, self.name = bool(self.name), signal.Signals(number).name
        if self.stop is None or again:
            raise KeyboardInterrupt
        self.stop()
