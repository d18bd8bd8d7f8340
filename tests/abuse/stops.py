"""Runs that are interrupted at a chosen step."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from contactlab.run.schedule import Schedule


@contextmanager
def stopped_at(step: int) -> Iterator[None]:
    """Send this process a Ctrl-C after `step` steps of the next run."""
    ask = Schedule.frame_due

    def frame_due(self: Schedule) -> bool:
        if self.state.step == step:
            signal.raise_signal(signal.SIGINT)
        return ask(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Schedule, "frame_due", frame_due)
        yield
