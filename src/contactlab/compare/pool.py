"""Fresh Python processes that run functions side by side, and outlive any one of them dying.

Each thread of a `concurrent.futures` pool owns one process, so a process that is killed costs
exactly the call it was serving and its exit status is known. (One shared process pool would fail
every pending call at once and not tell which one was to blame.)
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
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from contactlab.compare import worker as far_end
from contactlab.compare.worker import receive, send

Report = Callable[[Any], None]

_THREAD_VARIABLES = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class ProcessDiedError(RuntimeError):
    """A process ended without an answer; the text says how."""


class RaisedError(RuntimeError):
    """The function raised in the other process; `details` holds the traceback from there."""

    def __init__(self, text: str, details: str) -> None:
        super().__init__(text)
        self.details = details


class Worker:
    """One process, started at the first call, kept for the next ones."""

    def __init__(self) -> None:
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the process, ends with it
        # Its own session: an interrupt typed at the terminal reaches it once, through `interrupt`.
        self._process = subprocess.Popen(
            [sys.executable, "-P", far_end.__file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            start_new_session=True,
            env=_environment(),
        )
        self._send(sys.path)

    @property
    def alive(self) -> bool:
        """True while the process runs."""
        return self._process.poll() is None

    def call(self, function: Callable[..., Any], arguments: tuple[Any, ...], report: Report) -> Any:
        """function(*arguments, report) over there. Raises RaisedError or ProcessDiedError."""
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

    def interrupt(self) -> None:
        """Ask the process to stop its run in order, as Ctrl-C does."""
        if self.alive:
            self._process.send_signal(signal.SIGINT)

    def close(self, patience: float = 5.0) -> None:
        """End the process: politely, and by force after `patience` seconds."""
        if self._process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self._process.stdin.close()
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _send(self, message: Any) -> None:
        assert self._process.stdin is not None
        try:
            send(self._process.stdin, message)
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


class WorkerPool:
    """`jobs` processes behind the interface of `concurrent.futures`."""

    def __init__(self, jobs: int) -> None:
        self._threads = ThreadPoolExecutor(max_workers=jobs, thread_name_prefix="contactlab-compare")
        self._idle: queue.SimpleQueue[Worker] = queue.SimpleQueue()
        self._workers: list[Worker] = []

    def submit(
        self, function: Callable[..., Any], *arguments: Any, report: Report = lambda message: None
    ) -> Future[Any]:
        """function(*arguments, report) in a process; `report` is called in a thread of this one.

        The future raises RaisedError or ProcessDiedError; other calls are not touched by either.
        """
        return self._threads.submit(self._run, function, arguments, report)

    def _run(self, function: Callable[..., Any], arguments: tuple[Any, ...], report: Report) -> Any:
        worker = self._take()
        try:
            return worker.call(function, arguments, report)
        finally:
            if worker.alive:
                self._idle.put(worker)

    def _take(self) -> Worker:
        try:
            return self._idle.get_nowait()
        except queue.Empty:
            worker = Worker()
            self._workers.append(worker)
            return worker

    def interrupt(self) -> None:
        """Drop what has not begun and ask what runs to stop in order."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for worker in self._workers:
            worker.interrupt()

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *exception: object) -> None:
        if exception[0] is not None:
            self.interrupt()
        self._threads.shutdown(wait=True, cancel_futures=True)
        for worker in self._workers:
            worker.close()
