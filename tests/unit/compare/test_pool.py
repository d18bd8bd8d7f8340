"""Processes that fail, die or are interrupted cost their own call and nothing else."""

from __future__ import annotations

import os
import sys
import textwrap
from concurrent.futures import as_completed
from pathlib import Path

import pytest

from contactlab.compare.pool import ProcessDiedError, RaisedError, WorkerPool

TASKS = """
    import os, signal, sys, time

    def square(x, report):
        report(("half", x))
        print("noise on standard output", x)
        return x * x

    def fail(x, report):
        raise ValueError(f"no root of {x}")

    def leave(x, report):
        print("last words", file=sys.stderr, flush=True)
        os._exit(x)

    def kill(x, report):
        os.kill(os.getpid(), signal.SIGKILL)

    def process(x, report):
        return os.getpid(), os.environ.get("OMP_NUM_THREADS"), sys.modules["__main__"].__file__

    def patient(x, report):
        try:
            report("begun")
            time.sleep(600)
        except KeyboardInterrupt:
            return "stopped in order"
"""


@pytest.fixture
def tasks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> object:
    (tmp_path / "pool_tasks.py").write_text(textwrap.dedent(TASKS))
    monkeypatch.syspath_prepend(str(tmp_path))
    sys.modules.pop("pool_tasks", None)
    import pool_tasks

    return pool_tasks


def test_results_and_reports_come_back(tasks: object) -> None:
    heard: list[object] = []
    with WorkerPool(2) as pool:
        futures = [pool.submit(tasks.square, x, report=heard.append) for x in range(5)]
        assert sorted(f.result() for f in as_completed(futures)) == [0, 1, 4, 9, 16]
    assert sorted(heard) == [("half", x) for x in range(5)]


def test_an_exception_keeps_its_text_and_traceback(tasks: object) -> None:
    with WorkerPool(1) as pool:
        with pytest.raises(RaisedError, match="ValueError: no root of -1") as caught:
            pool.submit(tasks.fail, -1).result()
        assert "in fail" in caught.value.details
        assert pool.submit(tasks.square, 3).result() == 9


def test_a_dying_process_is_replaced_and_the_others_go_on(tasks: object) -> None:
    with WorkerPool(2) as pool:
        doomed = [pool.submit(tasks.leave, 7), pool.submit(tasks.kill, 0)]
        fine = [pool.submit(tasks.square, x) for x in range(6)]
        with pytest.raises(ProcessDiedError, match=r"exit status 7 .*last words"):
            doomed[0].result()
        with pytest.raises(ProcessDiedError, match="killed by SIGKILL"):
            doomed[1].result()
        assert [f.result() for f in fine] == [x * x for x in range(6)]


def test_processes_are_kept_fresh_and_single_threaded(tasks: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    with WorkerPool(1) as pool:
        first, second = (pool.submit(tasks.process, 0).result() for _ in range(2))
    assert first == second
    assert first[0] != os.getpid()
    assert first[1] == "1"
    assert Path(first[2]).name == "worker.py"  # the caller's own script was not imported


def test_an_interrupt_stops_runs_in_order_and_drops_the_rest(tasks: object) -> None:
    begun: list[object] = []
    with WorkerPool(1) as pool:
        running = pool.submit(tasks.patient, 0, report=lambda message: (begun.append(message), pool.interrupt()))
        waiting = pool.submit(tasks.square, 1)
        assert running.result() == "stopped in order"
    assert begun == ["begun"]
    assert waiting.cancelled()
