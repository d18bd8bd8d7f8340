"""Who runs the calls of a comparison or a matrix: processes of this machine, or an existing dask cluster."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

from contactlab.errors import RequestError
from contactlab.studies.pool import Report, WorkerPool

LOCAL = "local"
ALLOWED = "local, dask (a cluster on this machine) or tcp://HOST:PORT of a dask scheduler"


class Pool(Protocol):
    """Runs calls side by side; each may die, hang or raise without harm to the others.

    elsewhere  whether calls may run on machines that do not see the files of this one
    """

    elsewhere: bool

    def submit(
        self,
        function: Callable[..., Any],
        *arguments: Any,
        report: Report = ...,
        limit: float | None = None,
        folder: Path | None = None,
    ) -> Future[Any]:
        """function(*arguments, report) in another process.

        report  is called with what the call reports
        limit   time that the call may take [s]
        folder  what the call writes, if it writes: one of its arguments. Its files are there when the future is done.

        The future raises RaisedError, ProcessDiedError or TimedOutError.
        """
        ...

    def stop(self) -> None:
        """Drop what has not begun and tell what runs to stop in order."""
        ...

    def kill(self) -> None:
        """Drop what has not begun and end what runs at once."""
        ...

    def __enter__(self) -> Self:
        """The pool itself."""
        ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait for what runs; after an exception, stop it."""
        ...


def checked_scheduler(scheduler: str) -> str:
    """The same. Raises RequestError where it is none, before anything is made."""
    if scheduler in (LOCAL, "dask") or scheduler.startswith(("tcp://", "tls://")):
        return scheduler
    raise RequestError("no such scheduler", where="scheduler", got=scheduler, allowed=ALLOWED)


def open_pool(scheduler: str, jobs: int, folder: Path | None = None) -> Pool:
    """The pool that `--scheduler` asks for, with `jobs` processes where it starts them itself.

    folder  where the results go: a cluster finds out by it whether its workers share this disk
    Raises RequestError for an unknown scheduler, or one that is not installed or does not answer.
    """
    if checked_scheduler(scheduler) == LOCAL:
        return WorkerPool(jobs)
    try:
        from contactlab.studies.dask_pool import DaskPool
    except ImportError as error:
        raise RequestError(
            f"dask is not installed: {error}", where="scheduler", got=scheduler, allowed="local",
            hint="pip install 'contactlab[dask]'",
        ) from error  # fmt: skip
    return DaskPool(scheduler, jobs, folder)
