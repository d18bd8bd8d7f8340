"""A limit on the CPU time of a run, which is the same on a busy machine and on a quiet one."""

from __future__ import annotations

import _thread
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import process_time

SLOW = 30.0
"""Wall time that a run may take, in limits of its CPU time: machines share their cores, and a process may hang."""
SHORTEST = 0.05
"""Time between two looks at the clock [s], at least."""


class CpuLimitReached(Exception):
    """What ran was stopped at its limit."""


@contextmanager
def cpu_limit(seconds: float) -> Iterator[threading.Event]:
    """Interrupt what runs inside, as Ctrl-C does, when this process has used this CPU time [s]; again after as much.

    A thread looks at the clock: timers of the system that count CPU time make that clock itself coarse while they run
    (4 ms on Linux). Without effect outside of the main thread, the only one that is interrupted. Raises
    CpuLimitReached, unless what runs inside ends in order: the event that it gets is set then, too.
    """
    if threading.current_thread() is not threading.main_thread():
        yield threading.Event()
        return
    ended, over, began = threading.Event(), threading.Event(), process_time()

    def look() -> None:
        allowed = seconds
        while not ended.wait(max(allowed - (process_time() - began), SHORTEST)):
            if process_time() - began >= allowed:
                over.set()
                allowed += seconds
                _thread.interrupt_main()

    watching = threading.Thread(target=look, daemon=True)
    watching.start()
    try:
        yield over
    except KeyboardInterrupt as stop:
        if over.is_set():
            raise CpuLimitReached(f"stopped after {seconds:g} CPU s") from stop
        raise
    finally:
        ended.set()
        watching.join()
