"""Limits on CPU time: what computes is stopped, what waits is not."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import nullcontext, suppress
from time import process_time, sleep

import pytest

from contactlab.api import Job
from contactlab.api.compiled.compiler import COMPILATION
from contactlab.jobs.far_end import WORN
from contactlab.jobs.perform import CpuLimitReached, cpu_limit, perform
from contactlab.jobs.record import from_bytes
from contactlab.jobs.run import Run
from contactlab.scene.scene import load_scene

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


def compile_and_compute(compiling: float, computing: float) -> None:
    for seconds in (compiling, computing):
        with COMPILATION if seconds == compiling else nullcontext():
            began = process_time()
            while process_time() - began < seconds:
                pass


@pytest.mark.full
def test_compilation_is_free() -> None:
    with cpu_limit(0.3):
        compile_and_compute(0.6, 0.05)
    with pytest.raises(CpuLimitReached), cpu_limit(0.3):
        compile_and_compute(0.6, LONGEST)


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


def test_a_run_that_is_stopped_is_timed_out() -> None:
    """In its process, whose next run would meet what the interrupt left: it serves no other."""
    scene = load_scene("disc-on-block").with_({"integrator": "newton", "record.recorders": []})
    heard: list[object] = []
    record = from_bytes(perform(Run(Job("disc", ""), scene, "disc", cpu_limit=0.01), None, heard.append))
    assert heard[-1] == WORN
    assert (record.status, record.reason) == ("timed-out", "stopped after 0.01 CPU s")
    assert record.summary["cpu_limit"] == 0.01


def test_what_ends_in_order_at_its_limit_is_told() -> None:
    with cpu_limit(0.05) as over, suppress(KeyboardInterrupt):
        compute()
    assert over.is_set()
