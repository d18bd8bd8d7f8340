"""A dask cluster behind the interface of `Processes`: one that is there, or one started on this machine."""

from __future__ import annotations

import contextlib
import os
import pickle
import uuid
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, wait
from pathlib import Path
from typing import Any, ClassVar

import distributed

from contactlab.errors import RequestError
from contactlab.jobs import dask_worker
from contactlab.jobs.processes import Call, Pool, ProcessDiedError, RaisedError, Report, StoppedError, TimedOutError

ANSWER = 10.0
"""Seconds that a scheduler may take to answer."""


class DaskPool(Pool):
    """Calls as tasks of a cluster. A task whose worker dies is given to another one."""

    elsewhere: ClassVar[bool] = True

    def __init__(self, scheduler: str, jobs: int, folder: Path | None) -> None:
        self._name = uuid.uuid4().hex[:12]
        self._calls: dict[str, tuple[Future[Any], Report]] = {}
        self._tasks: list[Any] = []  # the scheduler forgets a task that nobody holds
        self._cluster = None if scheduler != "dask" else _own_cluster(jobs)
        try:
            self._client = distributed.Client(self._cluster or scheduler, timeout=ANSWER, set_as_default=False)
        except (OSError, ValueError) as error:
            raise RequestError(
                f"the scheduler does not answer: {error}", where="scheduler", got=scheduler,
                allowed="the address that `dask scheduler` prints, tcp://HOST:PORT",
            ) from error  # fmt: skip
        self._client.subscribe_topic(dask_worker.topic_of(self._name), self._heard)
        self._token = folder.resolve() / f".seen-by-all-{self._name}" if folder is not None else None
        if self._token is not None:
            self._token.touch()

    def submit(self, call: Call) -> Future[Any]:
        """Submit a task to the cluster; files in `folder` come back with its result if a worker does not see it."""
        mine: Future[Any] = Future()
        key = f"contactlab-{self._name}-{len(self._calls)}"
        content = pickle.dumps((call.function, call.arguments))
        self._calls[key] = mine, call.report  # before the task is there: a worker may report immediately
        task = self._client.submit(
            dask_worker.call, self._name, content, call.limit, call.folder, self._token, key=key, pure=False
        )  # fmt: skip
        self._tasks.append(task)
        task.add_done_callback(lambda done: self._ended(mine, done, call.folder))
        return mine

    def _heard(self, event: tuple[Any, Any]) -> None:
        """A call has begun, or reports."""
        key, message = event[1]
        mine, report = self._calls[key]
        if message is not None:
            report(message)
        elif not mine.running() and not mine.done():
            mine.set_running_or_notify_cancel()

    def _ended(self, mine: Future[Any], task: Any, folder: Path | None) -> None:
        try:
            kind, result, files = task.result()
            if folder is not None:
                dask_worker.unpack(files, folder)
            if kind == "done":
                mine.set_result(result)
            else:
                mine.set_exception(_ERRORS[kind](result))
        except distributed.CancelledError:
            mine.set_exception(CancelledError())
        except distributed.KilledWorker as error:
            mine.set_exception(ProcessDiedError(f"the workers that ran it died: {error}"))
        except Exception as error:
            mine.set_exception(RaisedError(f"{type(error).__name__}: {error}", ""))

    def stop(self) -> None:
        """Drop what has not begun and stop what runs in order."""
        self._client.run(dask_worker.stop, self._name, on_error="ignore")

    def kill(self) -> None:
        """Drop what has not begun and kill what runs."""
        self._client.run(dask_worker.kill, self._name, on_error="ignore")

    @property
    def size(self) -> int:  # type: ignore[override]
        """Threads of the workers that are there now."""
        return max(1, sum(map(int, self._client.nthreads().values())))

    def close(self) -> None:
        """Wait for what runs, and leave the cluster; end one of our own."""
        try:
            wait([mine for mine, _ in self._calls.values()])
            self._client.run(dask_worker.close, on_error="ignore")
        finally:
            if self._token is not None:
                self._token.unlink(missing_ok=True)
            self._client.close()
            if self._cluster is not None:
                with contextlib.suppress(TimeoutError):
                    self._cluster.close()


def _own_cluster(jobs: int) -> Any:
    """Workers of one thread each, seen by this machine alone."""
    os.environ["PYTHONSAFEPATH"] = "1"  # its processes do not look for modules in the folder they are started in
    return distributed.LocalCluster(
        n_workers=jobs, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None
    )


_ERRORS: dict[str, Callable[[Any], BaseException]] = {
    "raised": lambda result: RaisedError(*result),
    "timed-out": lambda result: TimedOutError(*result),
    "died": ProcessDiedError,
    "stopped": lambda result: StoppedError("stopped before it gave an answer"),
}
