"""The driver: plans get their records, nothing is made twice, and every way to end leaves what is done."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import pytest

from contactlab.api import Record
from contactlab.errors import ContactlabWarning, RequestError
from contactlab.jobs import driver as module
from contactlab.jobs.archive import FILE, Archive
from contactlab.jobs.driver import Driver
from contactlab.jobs.processes import ProcessDiedError, RaisedError, TimedOutError
from contactlab.jobs.record import to_bytes
from contactlab.jobs.run import Run, here

RunOf = Callable[..., Run]
Plan = Generator[Any, Any, Any]


def value(one: Record) -> float:
    return float(one.summary["value"])


def total(runs: list[Run]) -> Plan:
    found = yield runs
    return sum(map(value, found))


def records(runs: list[Run]) -> Plan:
    found = yield runs
    return list(found)


def test_plans_may_ask_for_runs_and_for_plans(run_of: RunOf, made: list[str]) -> None:
    def nested() -> Plan:
        first, few, none = yield [run_of(1.0), total([run_of(2.0), run_of(3.0)]), total([])]
        (last,) = yield [run_of(value(first) + few + none)]
        return value(last)

    with Driver(jobs=2) as driver:
        found = dict(driver.results([total([run_of(5.0)]), nested()]))
    assert found == {0: 5.0, 1: 6.0}
    assert sorted(made) == ["run 1", "run 2", "run 3", "run 5", "run 6"]
    assert here(nested(), lambda run: Record("finished", "", {"value": run.scene.data["time"]["end"]})) == 6.0


def test_waiting_runs_begin_by_rank_and_equal_ones_are_made_once(run_of: RunOf, made: list[str]) -> None:
    plans = [total([run_of(1.0, rank=(2.0,))]), total([run_of(2.0, rank=(1.0,))]), total([run_of(1.0, rank=(2.0,))])]
    with Driver(jobs=1) as driver:
        assert dict(driver.results(plans)) == {0: 1.0, 1: 2.0, 2: 1.0}
    assert made == ["run 2", "run 1"]


def test_what_the_archive_holds_is_not_made_again(run_of: RunOf, made: list[str], tmp_path: Path) -> None:
    for _ in range(2):
        with Driver(tmp_path) as driver:
            assert driver.result(total([run_of(1.0), run_of(2.0, number=1), run_of(1.0)])) == 4.0
            (again,) = driver.result(records([run_of(1.0)]))
            assert again.summary["known"]
    assert made == ["run 1", "run 2"]


def test_a_run_whose_files_are_gone_is_made_again(run_of: RunOf, made: list[str], tmp_path: Path) -> None:
    run = run_of(1.0, place="runs/one")
    for _ in range(2):
        with Driver(tmp_path) as driver:
            driver.result(total([run]))
    assert made == ["run 1"]
    (tmp_path / "runs/one").rmdir()
    with Driver(tmp_path) as driver:
        driver.result(total([run]))
    assert made == ["run 1"] * 2


def test_a_timed_run_is_not_served_by_one_that_nobody_prepared(
    run_of: RunOf, made: list[str], record: Callable[..., Record], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def perform(run: Run, folder: Path | None, report: Callable[[Any], None]) -> bytes:
        made.append(run.name)
        found = record(1.0)
        del found.summary["calibration_s"]  # type: ignore[attr-defined]
        return to_bytes(found)

    with monkeypatch.context() as patch, Driver(tmp_path) as driver:
        patch.setattr(module, "perform", perform)
        driver.result(total([run_of(1.0)]))
    with Driver(tmp_path) as driver:
        driver.result(total([run_of(1.0, timed=True)]))
        driver.result(total([run_of(1.0)]))
    assert made == ["run 1"] * 2


def test_a_run_that_is_no_longer_wanted_does_not_begin(run_of: RunOf, made: list[str]) -> None:
    with Driver() as driver:
        (found,) = driver.result(records([run_of(1.0, unless=lambda: "the budget is spent")]))
    assert (found.status, found.reason) == ("not-run", "the budget is spent")
    assert made == []


ENDS = {
    "died": (ProcessDiedError("killed by SIGKILL"), "failed", "killed by SIGKILL"),
    "raised": (RaisedError("ValueError: no", "line 3"), "failed", "ValueError: no"),
    "deaf": (TimedOutError(2.0), "timed-out", "it did not answer and was killed"),
}


@pytest.mark.parametrize("name", ENDS)
def test_a_run_that_ends_badly_is_a_record_and_is_tried_again(
    name: str, run_of: RunOf, made: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    error, status, reason = ENDS[name]

    def perform(run: Run, folder: Path | None, report: Callable[[Any], None]) -> bytes:
        raise error

    with monkeypatch.context() as patch, Driver(tmp_path) as driver:
        patch.setattr(module, "perform", perform)
        (found,) = driver.result(records([run_of(1.0)]))
    assert found.status == status
    assert reason in found.reason
    assert found.summary.get("traceback", "line 3") == "line 3"
    with Driver(tmp_path) as driver:
        assert driver.result(total([run_of(1.0)])) == 1.0


@pytest.mark.usefixtures("made")
def test_over_its_time_it_has_come_so_far(
    run_of: RunOf, record: Callable[..., Record], monkeypatch: pytest.MonkeyPatch
) -> None:
    stopped, whole = to_bytes(record(1.0, "interrupted")), to_bytes(record(1.0))

    def perform(run: Run, folder: Path | None, report: Callable[[Any], None]) -> bytes:
        raise TimedOutError(2.0, stopped if run.name == "run 1" else whole)

    monkeypatch.setattr(module, "perform", perform)
    with Driver() as driver:
        first, second = driver.result(records([run_of(1.0), run_of(2.0)]))
    assert (first.status, first.reason) == ("timed-out", "stopped after its time limit of 2 s, after step 3")
    assert second.status == "finished"  # it was just done


def test_what_cannot_be_sent_to_a_process_is_a_failed_run(run_of: RunOf, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "perform", lambda run, folder, report: b"")
    with Driver(jobs=1) as driver:
        (found,) = driver.result(records([run_of(1.0)]))
    assert found.status == "failed"
    assert "pickle" in found.reason


def test_the_limit_of_cpu_time_is_remembered(
    run_of: RunOf, made: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def perform(run: Run, folder: Path | None, report: Callable[[Any], None]) -> bytes:
        made.append(f"{run.name} within {run.cpu_limit:g}")
        summary = {"cpu_limit": run.cpu_limit, "machine": module.machine(), "process_s": 1.0}
        return to_bytes(Record("timed-out", "stopped", summary))

    monkeypatch.setattr(module, "perform", perform)
    for limit in (1.0, 1.0, 2.0):
        with Driver(tmp_path) as driver:
            (found,) = driver.result(records([run_of(1.0, cpu_limit=limit)]))
        assert found.status == "timed-out"
    assert made == ["run 1 within 1", "run 1 within 2"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_after_ctrl_c_plans_end_with_what_there_is(
    number: int, run_of: RunOf, made: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = signal.getsignal(number)

    def one(run: Run) -> Plan:
        (found,) = yield [run]
        if found.finished:
            os.kill(os.getpid(), number)
        (further,) = yield [run_of(value(found) + 100.0)] if found.finished else [run]
        return found.status, further.status

    with Driver(tmp_path, jobs=1) as driver:
        found = dict(driver.results(one(run_of(float(k))) for k in (1, 2, 3)))
    assert driver.interrupted
    assert found[0] == ("finished", "interrupted")
    assert found[2] == ("interrupted", "interrupted")
    assert len(made) < 3
    assert signal.getsignal(number) is before
    with Driver(tmp_path) as driver:
        assert driver.result(total([run_of(float(k)) for k in (1, 2, 3)])) == 6.0
    assert sorted(made) == ["run 1", "run 2", "run 3"]


def test_a_damaged_record_is_named_and_made_again(run_of: RunOf, made: list[str], tmp_path: Path) -> None:
    with Driver(tmp_path) as driver:
        driver.result(total([run_of(1.0), run_of(2.0)]))
    path = tmp_path / FILE
    with Archive(path, write=False) as archive:
        blob = archive._file.execute("select record from runs where name = 'run 2'").fetchone()[0]
    data = bytearray(path.read_bytes())
    data[data.index(blob[:64]) + 40] ^= 4
    path.write_bytes(data)
    made.clear()
    with pytest.warns(ContactlabWarning, match="runs: run 2.*are run again"), Driver(tmp_path) as driver:
        assert driver.result(total([run_of(1.0), run_of(2.0)])) == 3.0
    assert made == ["run 2"]
    assert list(tmp_path.glob(f"{FILE}.damaged-*"))


def test_there_is_time_for_something_else_once_when_the_first_runs_are_under_way(
    run_of: RunOf, made: list[str]
) -> None:
    with Driver(jobs=2) as driver:
        driver.meanwhile = lambda: made.append("meanwhile")
        driver.result(total([run_of(float(k)) for k in range(1, 5)]))
    assert made == ["run 1", "run 2", "meanwhile", "run 3", "run 4"]


def test_one_command_at_a_time_works_in_a_folder(tmp_path: Path) -> None:
    with Driver(tmp_path), pytest.raises(RequestError, match="another command is writing"):
        Driver(tmp_path).__enter__()
    with Driver(tmp_path):
        pass


def test_an_error_of_a_plan_ends_all(run_of: RunOf, made: list[str]) -> None:
    def wrong() -> Plan:
        yield [run_of(1.0)]
        raise RequestError("no such thing")

    with pytest.raises(RequestError, match="no such thing"), Driver() as driver:
        driver.result(wrong())


def test_wrong_requests_are_refused_before_anything_is_made(tmp_path: Path) -> None:
    for wrong in ({"jobs": 0}, {"time_limit": 0.0}, {"scheduler": "slurm"}):
        with pytest.raises(RequestError):
            Driver(tmp_path, **wrong)
    assert not list(tmp_path.iterdir())
