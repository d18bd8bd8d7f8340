"""Limits on CPU time: what computes is stopped, what waits is not."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from time import process_time, sleep

import pytest

from contactlab.accuracy.point import Task, run_point
from contactlab.accuracy.run import run_accuracy
from contactlab.accuracy.study import CaseChoice, CaseStudy, Contender
from contactlab.parts.registry import default_registry
from contactlab.studies.cpu_limit import CpuLimitReached, cpu_limit
from contactlab.studies.worker import WORN

LONGEST = 5.0  # CPU s after which a test gives up


@pytest.fixture(autouse=True)
def _heard() -> Iterator[None]:
    """Ctrl-C as in a process of a study; one in the background of a shell is told to ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def compute() -> None:
    began = process_time()
    while process_time() - began < LONGEST:
        pass


def test_what_computes_is_stopped() -> None:
    began = process_time()
    with pytest.raises(CpuLimitReached, match=r"stopped after 0\.1 CPU s"), cpu_limit(0.1):
        compute()
    assert 0.1 <= process_time() - began < LONGEST


def test_who_does_not_hear_is_told_again() -> None:
    def stubborn() -> None:
        try:
            compute()
        except KeyboardInterrupt:
            compute()

    with pytest.raises(CpuLimitReached), cpu_limit(0.1):
        stubborn()


def test_waiting_is_free() -> None:
    """On a machine with other work a run waits most of the time."""
    with cpu_limit(0.1):
        sleep(0.4)


def test_the_clock_stays_fine() -> None:
    """Short runs cost a few milliseconds: steps of the clock must be far below."""
    with cpu_limit(100.0):
        began = process_time()
        while (after := process_time()) == began:
            pass
    assert after - began < 1e-3


def test_ctrl_c_stays_ctrl_c() -> None:
    with pytest.raises(KeyboardInterrupt), cpu_limit(100.0):
        raise KeyboardInterrupt


def test_a_point_that_is_stopped_is_timed_out_and_not_tried_again(tmp_path: Path) -> None:
    contender = Contender("statics", "q1", "newton", "mortar-p0")
    task = Task(CaseChoice(use="hertz"), contender, False, 1, 0.01)
    heard: list[object] = []
    point, made = run_point(task, default_registry(), None, heard.append)
    assert heard[-1] == WORN  # it was interrupted anywhere: its process serves no other call
    assert (point.status, point.reason) == ("timed-out", "stopped after 0.02 CPU s")
    assert [run.key for run in made] == [task.key()]
    study = CaseStudy((task.choice,), (contender,), levels=(1,), join=False, limit=0.01)
    first, again = (run_accuracy(study, default_registry(), tmp_path, 1, lambda *told: None) for _ in range(2))
    assert {point.status for point in (*first.points, *again.points)} == {"timed-out"}
    assert all(point.spent > 0.0 for point in first.points)
    assert not any(point.spent for point in again.points)
