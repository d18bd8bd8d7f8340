"""Runs of plans in the process of the test: none has to start where a test asks about something else."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any, ClassVar

import pytest

from contactlab import comparison
from contactlab.jobs import driver
from contactlab.jobs.processes import Call, Pool, ProcessDiedError, RaisedError, StoppedError, TimedOutError
from contactlab.jobs.scheduler import LOCAL

ENDS = (ProcessDiedError, RaisedError, StoppedError, TimedOutError)


class Inline(Pool):
    """Calls are made in this process, when they are submitted."""

    elsewhere: ClassVar[bool] = False
    size = 2

    def submit(self, call: Call) -> Future[Any]:
        """Make the call; whatever it raises is its answer."""
        done: Future[Any] = Future()
        try:
            done.set_result(call.function(*call.arguments, call.report))
        except ENDS as error:  # of a process that a test stands for
            done.set_exception(error)
        except Exception as error:
            done.set_exception(RaisedError(f"{type(error).__name__}: {error}", traceback.format_exc()))
        return done

    def stop(self) -> None:
        """Nothing runs."""

    def kill(self) -> None:
        """Nothing runs."""

    def close(self) -> None:
        """Nothing runs."""


@contextmanager
def runs_inline(report: bool = True) -> Iterator[None]:
    """No processes for runs of this machine, inside; without `report` no page and pictures of a comparison."""
    whole = driver.open_pool
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(driver, "open_pool", lambda where, *rest: Inline() if where == LOCAL else whole(where, *rest))
        if not report:
            patch.setattr(comparison, "write_report", lambda *_: None)
        yield
