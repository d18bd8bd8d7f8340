"""A dask cluster serves the same calls: two workers with disks of their own, one of which is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import pytest

from contactlab.cli import main
from contactlab.comparison import compare
from contactlab.errors import RequestError
from contactlab.jobs import dask_pool
from contactlab.jobs.archive import FILE, Archive
from contactlab.jobs.dask_pool import DaskPool
from contactlab.jobs.dask_worker import SCRATCH
from contactlab.jobs.processes import Call, ProcessDiedError, RaisedError, StoppedError, TimedOutError
from contactlab.jobs.scheduler import open_pool
from contactlab.verdicts.files import verdicts

TASKS = """
    import os, time
    from pathlib import Path

    def square(x, report):
        report(("half", x))
        return x * x

    def fail(x, report):
        raise ValueError(f"no root of {x}")

    def leave(x, report):
        os._exit(x)

    def write(folder, report):
        (folder / "deep").mkdir(parents=True)
        (folder / "deep" / "found.txt").write_text(str(folder))

    def once_more(x, place, report):
        # the first time it waits until its worker is killed
        trace = Path(place) / f"tried-{x}"
        if not trace.exists():
            trace.write_text(str(os.getppid()))
            time.sleep(600)
        return x

    def sleep(report):
        report("begun")
        time.sleep(600)
"""


@dataclass(frozen=True)
class Cluster:
    """A scheduler with two workers; `tasks` is what they can import."""

    address: str
    workers: list[subprocess.Popen[bytes]]
    tasks: ModuleType
    scratch: list[Path]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory, fake_source: str) -> Iterator[Cluster]:
    tmp_path = tmp_path_factory.mktemp("cluster")
    place = tmp_path / "tasks"
    place.mkdir()
    (place / "dask_tasks.py").write_text(textwrap.dedent(TASKS))
    (place / "fake_runs.py").write_text(fake_source)
    sys.path.insert(0, str(place))
    import dask_tasks

    sys.path.remove(str(place))
    file = tmp_path / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = ["dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-jupyter"]
    started = [_dask([*scheduler, "--scheduler-file", str(file)], {}, quiet)]
    scratch = [tmp_path / "one", tmp_path / "two"]
    for disk in scratch:
        disk.mkdir()
        worker = ["dask_worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        own = {SCRATCH: str(disk), "PYTHONPATH": str(place)}
        started.append(_dask([*worker, "--host", "127.0.0.1", "--local-directory", str(disk)], own, quiet))
    try:
        yield Cluster(_address(file), started[1:], dask_tasks, scratch)
    finally:
        for process in started:
            process.kill()
            process.wait()


def _dask(words: list[str], environment: dict[str, str], quiet: dict[str, int]) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", f"distributed.cli.{words[0]}", *words[1:]]
    return subprocess.Popen(command, env={**os.environ, **environment}, **quiet)  # type: ignore[call-overload, no-any-return]


def _address(file: Path) -> str:
    import json

    for _ in range(600):
        try:
            return str(json.loads(file.read_text())["address"])
        except (OSError, ValueError):
            time.sleep(0.1)
    raise AssertionError("the scheduler did not start")


def test_calls_raise_die_and_run_out_of_time_alone_and_files_come_back(cluster: Cluster, tmp_path: Path) -> None:
    heard: list[object] = []
    tasks = cluster.tasks
    with open_pool(cluster.address, 2, tmp_path) as pool:
        squares = [pool.submit(Call(tasks.square, (x,), report=heard.append)) for x in range(4)]
        failed, left = pool.submit(Call(tasks.fail, (-1,))), pool.submit(Call(tasks.leave, (7,)))
        late = pool.submit(Call(tasks.sleep, limit=0.2))
        folder = tmp_path / "results"
        written = pool.submit(Call(tasks.write, (folder,), folder=folder))
        assert [f.result() for f in squares] == [0, 1, 4, 9]
        with pytest.raises(RaisedError, match="ValueError: no root of -1") as caught:
            failed.result()
        assert "in fail" in caught.value.details
        with pytest.raises(ProcessDiedError, match="exit status 7"):
            left.result()
        with pytest.raises(TimedOutError):
            late.result()
        written.result()
    assert sorted(map(str, heard)) == sorted(str(("half", x)) for x in range(4))
    # written on the worker's own disk, which is empty again, and brought here
    there = Path((folder / "deep" / "found.txt").read_text())
    assert any(there.is_relative_to(disk) for disk in cluster.scratch)
    assert not there.exists()
    assert not list(tmp_path.glob(".seen-by-all*"))


def test_what_has_not_begun_is_dropped_after_a_stop(cluster: Cluster) -> None:
    with open_pool(cluster.address, 2) as pool:
        futures = [pool.submit(Call(cluster.tasks.sleep)) for _ in range(4)]
        while sum(future.running() for future in futures) < 2:
            time.sleep(0.05)
        pool.kill()
        ends = [future.exception(timeout=60) for future in futures]
    assert sum(isinstance(end, StoppedError) for end in ends) == 2
    assert sum(isinstance(end, ProcessDiedError) for end in ends) == 2


@pytest.mark.full
@pytest.mark.usefixtures("fake_runs")
def test_rows_are_the_same_whoever_ran_them(cluster: Cluster, tmp_path: Path) -> None:
    vary = {"level": [1, 9], "contacts.0.algorithm": ["node-on-segment", "mortar-p0"]}
    here = compare("disc-on-block", vary, out=tmp_path / "here", jobs=1)
    there = compare("disc-on-block", vary, out=tmp_path / "there", scheduler=cluster.address)
    for column in ("name", "status", "reason", "reaction", "cpu_s"):
        assert [str(row[column]) for row in there] == [str(row[column]) for row in here]
    with Archive(tmp_path / "there" / FILE, write=False) as archive:
        kept = list(archive.rows())
    assert sorted((row["name"], row["status"]) for row in kept) == sorted((row.name, row.status) for row in there)
    assert {row["name"]: row["values"]["reaction"] for row in kept if row["status"] == "finished"} == {
        row.name: row["reaction"] for row in there if row.status == "finished"
    }


@pytest.mark.full
def test_a_matrix_through_a_scheduler_has_the_same_verdicts(
    cluster: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["matrix", "patch", "--contact", "mortar-p1", "--contact", "node-on-segment"]
    assert main([*asked, "--out", str(tmp_path / "here"), "--jobs", "1"]) == 0
    for resumed in ([], ["--resume"]):
        out = ["--out", str(tmp_path / "there"), "--scheduler", cluster.address]
        assert main([*asked, *out, *resumed]) == 0
        assert verdicts(tmp_path / "there") == verdicts(tmp_path / "here")
    with Archive(tmp_path / "there" / FILE, write=False) as archive:
        made = [cell["made"] for cell in archive.cells()]
        runs = list(archive.runs())
    assert len(made) == 2
    assert len({run["key"] for run in runs}) == len(runs)


def test_wrong_schedulers_are_refused_before_anything_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out"
    with pytest.raises(RequestError, match="no such scheduler"):
        compare("disc-on-block", {"level": [1]}, out=out, scheduler="slurm")
    assert not out.exists()
    monkeypatch.setattr(dask_pool, "ANSWER", 0.5)
    with pytest.raises(RequestError, match="does not answer"):
        DaskPool("tcp://127.0.0.1:9", 1, None)


@pytest.mark.full
def test_a_call_of_a_worker_that_is_killed_is_served_by_another(cluster: Cluster, tmp_path: Path) -> None:
    with open_pool(cluster.address, 2) as pool:
        future = pool.submit(Call(cluster.tasks.once_more, (5, str(tmp_path))))
        trace = tmp_path / "tried-5"
        while not trace.exists() or not trace.read_text():
            time.sleep(0.05)
        (victim,) = [worker for worker in cluster.workers if worker.pid == int(trace.read_text())]
        victim.send_signal(signal.SIGKILL)
        assert future.result(timeout=60) == 5
