"""Choice of the place of runs: processes of this machine, or a dask cluster."""

from __future__ import annotations

from pathlib import Path

from contactlab.errors import RequestError
from contactlab.jobs.processes import Pool, Processes

LOCAL = "local"
ALLOWED = "local, dask (a cluster on this machine) or tcp://HOST:PORT of a dask scheduler"


def checked_scheduler(scheduler: str) -> str:
    """Return the name of a scheduler. Raises RequestError for any other string, before anything is made."""
    if scheduler in (LOCAL, "dask") or scheduler.startswith(("tcp://", "tls://")):
        return scheduler
    raise RequestError("no such scheduler", where="scheduler", got=scheduler, allowed=ALLOWED)


def open_pool(scheduler: str, jobs: int, folder: Path | None = None) -> Pool:
    """The pool that `--scheduler` requests, with `jobs` processes if it starts them itself.

    folder  of the results: a cluster finds out by it whether its workers share this disk
    Raises RequestError for an unknown scheduler, or one that is not installed or does not answer.
    """
    if checked_scheduler(scheduler) == LOCAL:
        return Processes(jobs)
    try:
        from contactlab.jobs.dask_pool import DaskPool
    except ImportError as error:
        raise RequestError(
            f"dask is not installed: {error}", where="scheduler", got=scheduler, allowed="local",
            hint="pip install 'contactlab[dask]'",
        ) from error  # fmt: skip
    return DaskPool(scheduler, jobs, folder)
