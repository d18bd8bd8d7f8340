"""What became of a run that a pool was asked for."""

from __future__ import annotations

from concurrent.futures import CancelledError, Future
from dataclasses import replace

from contactlab.studies.pool import ProcessDiedError, RaisedError, TimedOutError
from contactlab.studies.run_job import Outcome


def awaited(future: Future[Outcome], stopped: bool = False) -> Outcome:
    """Wait for a run; whatever ended its process is told as its outcome. `stopped`: the user ended the pool."""
    try:
        return future.result()
    except CancelledError:
        return Outcome("interrupted", "stopped before it began")
    except TimedOutError as error:
        return _timed_out(error)
    except ProcessDiedError as error:
        return Outcome("interrupted", "stopped by the user") if stopped else Outcome("failed", str(error))
    except RaisedError as error:
        return Outcome("failed", str(error), traceback=error.details)


def _timed_out(error: TimedOutError) -> Outcome:
    """As far as the run came when it was told to stop; one that ended all the same has ended."""
    if not isinstance(error.result, Outcome):
        return Outcome("timed-out", f"{error}; it did not answer and was killed")
    if error.result.status != "interrupted":
        return error.result
    return replace(error.result, status="timed-out", reason=f"{error}, after step {error.result.summary['steps']}")
