"""Processes that run functions side by side, each outliving the death or hanging of any other.

loky starts and feeds them: an executor of one process for each, because an executor of several fails all of their calls
if one of them dies. A pipe of our own carries reports, and the request to stop (`far_end`).
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import re
import signal
import tempfile
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import Pipe
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, ClassVar, Self

from contactlab.jobs import far_end
from contactlab.jobs.far_end import BEGUN, STOP, WORN

PREPARATION = 600.0
"""Seconds that a process may take to import and compile before the time of its call begins."""
GRACE = 5.0
"""Seconds that a call may take to stop in order before its process is killed."""
_THREAD_VARIABLES = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_SAFE = {"PYTHONSAFEPATH": "1"}
"""Prevents modules of the working folder from replacing Python's own."""
_SINGLE = {"LOKY_MAX_MEMORY_LEAK_SIZE": "1e18"}
"""A process is not replaced because its runs need memory."""

Report = Callable[[Any], None]


class ProcessDiedError(RuntimeError):
    """A process ended without an answer; the message says how."""


class StoppedError(RuntimeError):
    """A call was stopped and gave no answer."""


class RaisedError(RuntimeError):
    """The function raised in the other process; `details` holds the traceback from there."""

    def __init__(self, text: str, details: str) -> None:
        super().__init__(text)
        self.details = details


class TimedOutError(RuntimeError):
    """A call was stopped at its time limit; `result` is its answer to the request to stop, None if there was none."""

    def __init__(self, limit: float, result: Any = None) -> None:
        super().__init__(f"stopped after its time limit of {limit:g} s")
        self.limit, self.result = limit, result


@dataclass(frozen=True)
class Call:
    """function(*arguments, report) in another process.

    report  is called here with what the call reports
    limit   time that the call may take [s], from its report `BEGUN`; None for any
    folder  one of the arguments that the call writes to, if any; its files are there when the future is done
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    report: Report = lambda message: None
    limit: float | None = None
    folder: Path | None = None


class Pool(ABC):
    """Runs calls side by side; each may die, hang or raise without harm to the others.

    size       calls at a time
    elsewhere  whether calls may run on machines that do not see the files of this one
    """

    size: int
    elsewhere: ClassVar[bool]

    @abstractmethod
    def submit(self, call: Call) -> Future[Any]:
        """Begin a call as soon as a process is free.

        The future raises RaisedError, ProcessDiedError, TimedOutError or StoppedError.
        """

    @abstractmethod
    def stop(self) -> None:
        """Drop what has not begun and ask what runs to stop in order."""

    @abstractmethod
    def kill(self) -> None:
        """Drop what has not begun and kill what runs."""

    @abstractmethod
    def close(self) -> None:
        """Wait for what runs, and end all processes."""

    def __enter__(self) -> Self:
        """Return the pool."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close; after an exception, stop first."""
        try:
            if kind is not None:
                self.stop()
            self.close()
        except KeyboardInterrupt:
            self.kill()
            raise


class Process:
    """Process that serves calls one after another."""

    def __init__(self) -> None:
        from loky.process_executor import ProcessPoolExecutor

        self.used_up = False
        self._number = 0
        self._here, there = Pipe()
        handle, name = tempfile.mkstemp(prefix="contactlab-", suffix=".log")
        os.close(handle)
        self._output = Path(name)
        variables = {**dict.fromkeys(_THREAD_VARIABLES, "1"), **os.environ, **_SAFE, **_SINGLE}
        self._executor = ProcessPoolExecutor(1, initializer=far_end.begin, initargs=(there, name), env=variables)
        with _environment(_SAFE):  # the process that tracks the resources of the others inherits it
            self._executor.submit(os.getpid)
        there.close()  # the other end is open in the process alone: its death is noticed immediately

    def call(self, call: Call) -> Any:
        """Run a call over there. Raises RaisedError, ProcessDiedError, TimedOutError or StoppedError."""
        try:
            future = self._executor.submit(far_end.serve, pickle.dumps((call.function, call.arguments)))
        except RuntimeError as error:  # it died between two calls, or was killed
            raise self._death(error) from None
        late = self._heard(call)
        try:
            kind, *content = future.result()
        except (BrokenProcessPool, RuntimeError, CancelledError) as error:
            if late:
                assert call.limit is not None
                raise TimedOutError(call.limit) from None
            raise self._death(error) from None
        if late:
            assert call.limit is not None
            raise TimedOutError(call.limit, content[0] if kind == "done" else None)
        if kind == "done":
            return content[0]
        self.used_up = self.used_up or kind == "stopped"
        raise RaisedError(*content) if kind == "raised" else StoppedError("stopped before it gave an answer")

    def _heard(self, call: Call) -> bool:
        """Listen until the call has ended or its process is gone; returns whether it was over its time."""
        limit = call.limit
        deadline = None if limit is None else monotonic() + PREPARATION + limit
        late = False
        while True:
            left = 1.0 if deadline is None else min(1.0, deadline - monotonic())
            try:
                kind, message = self._here.recv() if self._here.poll(max(0.0, left)) else ("", 0)
            except (EOFError, OSError):
                self.used_up = True
                return late
            if kind == far_end.ENDED:
                return late
            if kind == far_end.PROCESS:
                self._number = message
            elif kind == "report" and message == BEGUN and limit is not None and not late:
                deadline = monotonic() + limit
            elif kind == "report" and message == WORN:
                self.used_up = True
            if kind == "report" and message != WORN:
                call.report(message)
            if deadline is not None and monotonic() >= deadline:
                if late:
                    self.kill()
                    deadline = None
                else:  # from here on this process serves no other
                    late = self.used_up = True
                    deadline = monotonic() + GRACE
                    self.stop()

    def stop(self) -> None:
        """Ask the process to stop its call in order, as Ctrl-C would; it serves no other."""
        self.used_up = True
        with contextlib.suppress(OSError, ValueError):
            self._here.send(STOP)

    def kill(self) -> None:
        """Kill the process and all that it has started, even if it is halted."""
        self.used_up = True
        if self._number and hasattr(os, "killpg"):
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._number, signal.SIGKILL)
        else:
            self._executor.shutdown(wait=False, kill_workers=True)  # `close` could wait no longer

    def close(self) -> None:
        """End the process, which serves no call; kill it if it no longer listens."""
        with contextlib.suppress(OSError):
            self._here.close()
        self._executor.shutdown(wait=True, kill_workers=self.used_up)
        self._output.unlink(missing_ok=True)

    def _death(self, error: BaseException) -> ProcessDiedError:
        self.used_up = True
        found = re.search(r"\{(\w+)\((-?\d+)\)", str(error))
        # the last line that the process wrote, if any
        try:
            last = self._output.read_text(errors="replace").strip().splitlines()[-1:]
        except OSError:
            last = []
        return ProcessDiedError(": ".join([_how_it_ended(found), *last]))


def _how_it_ended(found: re.Match[str] | None) -> str:
    """Name the signal or exit status of a process."""
    if found is None:
        return "the process ended before the run"
    name, code = found[1], int(found[2])
    if code >= 0:
        return f"the process stopped with exit status {code} before the run ended"
    hint = ", perhaps because memory ran out" if name == "SIGKILL" else ""
    return f"the process was killed by {name if name != 'UNKNOWN' else f'signal {-code}'}{hint}"


_changing = threading.Lock()


@contextmanager
def _environment(variables: dict[str, str]) -> Iterator[None]:
    """Set environment variables for what is started meanwhile."""
    with _changing:
        before = {name: os.environ.get(name) for name in variables}
        os.environ.update(variables)
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value


class Processes(Pool):
    """Processes of this machine, started when they are needed and kept for the next calls."""

    elsewhere: ClassVar[bool] = False

    def __init__(self, size: int) -> None:
        self.size = size
        self._threads = ThreadPoolExecutor(max_workers=size, thread_name_prefix="contactlab-process")
        self._idle: queue.SimpleQueue[Process] = queue.SimpleQueue()
        self._all: list[Process] = []
        self._lock = threading.Lock()
        self._closed = False

    def submit(self, call: Call) -> Future[Any]:
        """Begin a call; `report` is called in a thread of this process. Its folder is on this disk."""
        return self._threads.submit(self._run, call)

    def _run(self, call: Call) -> Any:
        process = self._taken()
        try:
            return process.call(call)
        finally:
            if process.used_up:
                with self._lock:
                    self._all.remove(process)
                process.close()
            else:
                self._idle.put(process)

    def _taken(self) -> Process:
        with contextlib.suppress(queue.Empty):
            return self._idle.get_nowait()
        with self._lock:
            if self._closed:
                raise CancelledError
            process = Process()
            self._all.append(process)
            return process

    def stop(self) -> None:
        """Drop what has not begun and ask what runs to stop in order."""
        self._end(Process.stop)

    def kill(self) -> None:
        """Drop what has not begun and kill every process."""
        self._end(Process.kill)

    def _end(self, how: Callable[[Process], None]) -> None:
        self._threads.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._closed = True
            for process in self._all:
                how(process)

    def close(self) -> None:
        """Wait for what runs, and end all processes."""
        self._threads.shutdown(wait=True, cancel_futures=True)
        with self._lock:
            for process in self._all:
                process.close()
            self._all.clear()
