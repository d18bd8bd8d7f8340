"""Processes that fail, die or are interrupted cost their own call and nothing else."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import as_completed
from pathlib import Path

import pytest

from contactlab.jobs import processes as pool_module
from contactlab.jobs.processes import Call, ProcessDiedError, Processes, RaisedError, TimedOutError

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
        caller = [name for name in sys.modules if "pytest" in name]
        return os.getpid(), os.environ.get("OMP_NUM_THREADS"), caller, sys.flags.safe_path

    def halt(x, report):
        report(os.getpid())
        report("begun")
        os.kill(os.getpid(), signal.SIGSTOP)

    def deaf(x, report):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        report(os.getpid())
        report("begun")
        time.sleep(600)

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
    with Processes(2) as pool:
        futures = [pool.submit(Call(tasks.square, (x,), report=heard.append)) for x in range(5)]
        assert sorted(f.result() for f in as_completed(futures)) == [0, 1, 4, 9, 16]
    assert sorted(heard) == [("half", x) for x in range(5)]


def test_an_exception_keeps_its_text_and_traceback(tasks: object) -> None:
    with Processes(1) as pool:
        with pytest.raises(RaisedError, match="ValueError: no root of -1") as caught:
            pool.submit(Call(tasks.fail, (-1,))).result()
        assert "in fail" in caught.value.details
        assert pool.submit(Call(tasks.square, (3,))).result() == 9


def test_a_dying_process_is_replaced_and_the_others_go_on(tasks: object) -> None:
    with Processes(2) as pool:
        doomed = [pool.submit(Call(tasks.leave, (7,))), pool.submit(Call(tasks.kill, (0,)))]
        fine = [pool.submit(Call(tasks.square, (x,))) for x in range(6)]
        with pytest.raises(ProcessDiedError, match=r"exit status 7 .*last words"):
            doomed[0].result()
        with pytest.raises(ProcessDiedError, match="killed by SIGKILL"):
            doomed[1].result()
        assert [f.result() for f in fine] == [x * x for x in range(6)]


def test_processes_are_kept_fresh_and_single_threaded(tasks: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    with Processes(1) as pool:
        first, second = (pool.submit(Call(tasks.process, (0,))).result() for _ in range(2))
    assert first == second
    assert first[0] != os.getpid()
    assert first[1] == "1"
    assert first[2] == []  # the caller's own script was not imported
    assert first[3]


def test_an_interrupt_stops_runs_in_order_and_drops_the_rest(tasks: object) -> None:
    begun: list[object] = []
    with Processes(1) as pool:
        running = pool.submit(Call(tasks.patient, (0,), report=lambda message: (begun.append(message), pool.stop())))
        waiting = pool.submit(Call(tasks.square, (1,)))
        assert running.result() == "stopped in order"
    assert begun == ["begun"]
    assert waiting.cancelled()


def is_there(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.parametrize("way", ["halt", "deaf"])
def test_a_call_that_hangs_costs_its_time_and_nothing_else(
    way: str, tasks: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pool_module, "GRACE", 0.2)
    seen: list[int] = []
    began = time.monotonic()
    with Processes(2) as pool:
        hung = pool.submit(Call(getattr(tasks, way), (0,), report=seen.append, limit=1.0))
        fine = [pool.submit(Call(tasks.square, (x,), limit=60.0)) for x in range(6)]
        with pytest.raises(TimedOutError, match="time limit of 1 s") as caught:
            hung.result()
        assert [f.result() for f in fine] == [x * x for x in range(6)]
    assert caught.value.result is None
    assert time.monotonic() - began < 20.0  # 1 s and the grace, on a busy machine
    assert not is_there(seen[0])


def test_a_call_over_its_time_may_end_in_order(tasks: object) -> None:
    with Processes(1) as pool:
        with pytest.raises(TimedOutError) as caught:
            pool.submit(Call(tasks.patient, (0,), limit=0.5)).result()
        assert caught.value.result == "stopped in order"
        assert pool.submit(Call(tasks.square, (3,))).result() == 9  # by another process


def test_nobody_is_left_behind(tasks: object) -> None:
    seen: list[int] = []
    with Processes(2) as pool:
        calls = [
            pool.submit(Call(tasks.halt, (0,), report=seen.append)),
            pool.submit(Call(tasks.deaf, (0,), report=seen.append)),
        ]
        while len(seen) < 4:
            time.sleep(0.01)
        pool.stop()
        pool.kill()
        for call in calls:
            with pytest.raises(ProcessDiedError):
                call.result()
    assert not any(is_there(process) for process in seen if process != "begun")


def test_processes_that_were_started_without_ctrl_c_are_told_to_stop(tmp_path: Path, tasks: object) -> None:
    """In the background of a script SIGINT is ignored, by children, too."""
    program = """
        import pool_tasks
        from contactlab.jobs.processes import Call
        from contactlab.jobs.processes import Processes
        with Processes(1) as pool:
            running = pool.submit(Call(pool_tasks.patient, (0,), report=lambda message: pool.stop()))
            print(running.result(timeout=30))
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
        env={**os.environ, "PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.stdout == "stopped in order\n", done.stderr
