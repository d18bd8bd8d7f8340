"""Fresh Python processes that run functions side by side, and outlive any one of them dying or hanging.

Each thread of a `concurrent.futures` pool owns one process, so a process that is killed costs
exactly the call it was serving and its exit status is known. (One shared process pool would fail
every pending call at once and not tell which one was to blame.) A call may have a time limit: it is
told to stop, and when it does not, its process is killed.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from typing import Any, ClassVar

from contactlab.studies import worker as far_end
from contactlab.studies.call import Call, Pool, Report
from contactlab.studies.worker import BEGUN, STOP, WORN, receive, send

_THREAD_VARIABLES = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


PREPARATION = 600.0  # s that a process may take to import and compile before the time of its call begins
GRACE = 5.0  # s that a call may take to stop in order before its process is killed


class ProcessDiedError(RuntimeError):
    """A process ended without an answer; the text says how."""


class RaisedError(RuntimeError):
    """The function raised in the other process; `details` holds the traceback from there."""

    def __init__(self, text: str, details: str) -> None:
        super().__init__(text)
        self.details = details


class TimedOutError(RuntimeError):
    """A call was stopped at its time limit; `result` is what it gave when it was told to stop, None if nothing."""

    def __init__(self, limit: float, result: Any = None) -> None:
        super().__init__(f"stopped after its time limit of {limit:g} s")
        self.result = result


class Worker:
    """One process, started at the first call, kept for the next ones."""

    def __init__(self) -> None:
        self.overtime = self.worn = False
        self._sending = threading.Lock()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the process, ends with it
        # Its own session: an interrupt typed at the terminal does not reach it, `stop` does.
        self._process = subprocess.Popen(
            [sys.executable, "-P", far_end.__file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            start_new_session=True,
            env=_environment(),
        )
        assert self._process.stdin is not None
        self._pipe = self._process.stdin
        self._send(sys.path)

    @property
    def alive(self) -> bool:
        """True while the process runs."""
        return self._process.poll() is None

    def call(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], report: Report, limit: float | None = None
    ) -> Any:
        """Run function(*arguments, report) over there. Raises RaisedError, ProcessDiedError or TimedOutError."""
        if limit is None:
            return self._answer(function, arguments, report)
        timers = [self._timer(PREPARATION + limit)]

        def heard(message: Any) -> None:
            if message == BEGUN:
                timers.pop().cancel()
                timers.append(self._timer(limit))
            elif message == WORN:
                self.worn = True
            else:
                report(message)

        try:
            result = self._answer(function, arguments, heard)
        except ProcessDiedError:
            if self.overtime:
                raise TimedOutError(limit) from None
            raise
        finally:
            timers.pop().cancel()
        if self.overtime:
            raise TimedOutError(limit, result)
        return result

    def _timer(self, seconds: float) -> threading.Timer:
        timer = threading.Timer(seconds, self._over_time)
        timer.daemon = True
        timer.start()
        return timer

    def _over_time(self) -> None:
        """The call has had its time: from here on this process serves no other."""
        self.overtime = True
        self.stop()
        try:
            self._process.wait(GRACE)
        except subprocess.TimeoutExpired:
            self.kill()

    def _answer(self, function: Callable[..., Any], arguments: tuple[Any, ...], report: Report) -> Any:
        # Pickled apart, so that an import error over there is an answer and not a broken pipe.
        self._send(pickle.dumps((function, arguments)))
        while True:
            kind, *content = self._receive()
            if kind == "report":
                report(content[0])
            elif kind == "raised":
                raise RaisedError(*content)
            else:
                return content[0]

    def stop(self) -> None:
        """Tell the process to stop its call in order, as Ctrl-C would; it serves no other after it."""
        # a process that is halted may not have read its last call yet: nothing is waited for
        if self._sending.acquire(timeout=1.0):
            try:
                send(self._pipe, STOP)
            except (OSError, ValueError):
                pass  # it has ended already
            finally:
                self._sending.release()

    def kill(self) -> None:
        """End the process and all that it has started, at once; one that is halted, too."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def close(self, patience: float = GRACE) -> None:
        """End the process: politely, and by force after `patience` seconds."""
        with contextlib.suppress(OSError):
            self._pipe.close()
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self.kill()

    def _send(self, message: Any) -> None:
        try:
            with self._sending:
                send(self._pipe, message)
        except BrokenPipeError:
            raise self._death() from None

    def _receive(self) -> Any:
        assert self._process.stdout is not None
        try:
            return receive(self._process.stdout)
        except EOFError:
            raise self._death() from None

    def _death(self) -> ProcessDiedError:
        code = self._process.wait()
        self._errors.seek(0)
        last_words = self._errors.read().decode(errors="replace").strip().splitlines()[-1:]
        return ProcessDiedError(": ".join([_how_it_ended(code), *last_words]))


def _how_it_ended(code: int) -> str:
    if code >= 0:
        return f"the process left with exit status {code} before the run was over"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    hint = ", perhaps because memory ran out" if name == "SIGKILL" else ""
    return f"the process was killed by {name}{hint}"


def _environment() -> dict[str, str]:
    """The caller's, with one thread per process where the caller does not ask for more."""
    return {**dict.fromkeys(_THREAD_VARIABLES, "1"), **os.environ}


class WorkerPool(Pool):
    """`jobs` processes behind the interface of `concurrent.futures`."""

    elsewhere: ClassVar[bool] = False

    def __init__(self, jobs: int) -> None:
        self._threads = ThreadPoolExecutor(max_workers=jobs, thread_name_prefix="contactlab-compare")
        self._idle: queue.SimpleQueue[Worker] = queue.SimpleQueue()
        self._workers: list[Worker] = []
        self._lock = threading.Lock()
        self._closed = False

    def submit(self, call: Call) -> Future[Any]:
        """In a process; `report` is called in a thread of this one. `folder` is on this disk and needs no care."""
        return self._threads.submit(self._run, call)

    def _run(self, call: Call) -> Any:
        worker = self._take()
        try:
            return worker.call(call.function, call.arguments, call.report, call.limit)
        finally:
            if worker.overtime or worker.worn:
                worker.close(patience=0.0)
            elif worker.alive:
                self._idle.put(worker)

    def _take(self) -> Worker:
        try:
            return self._idle.get_nowait()
        except queue.Empty:
            pass
        with self._lock:
            if self._closed:
                raise CancelledError
            worker = Worker()
            self._workers.append(worker)
            return worker

    def stop(self) -> None:
        """Drop what has not begun and tell what runs to stop in order."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for worker in self._workers:
            worker.stop()

    def kill(self) -> None:
        """Drop what has not begun and end every process at once."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._closed = True
            for worker in self._workers:
                worker.kill()

    def __exit__(self, *exception: object) -> None:
        try:
            if exception[0] is not None:
                self.stop()
            self._threads.shutdown(wait=True, cancel_futures=True)
            for worker in self._workers:
                worker.close()
        except KeyboardInterrupt:
            self.kill()
            raise
