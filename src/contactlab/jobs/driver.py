"""The driver: carries out plans of runs on processes of this machine or on a dask cluster.

All plans are advanced in the thread of the caller; runs that wait form one queue by rank. What the archive holds is not
run again, and runs with the same key are made once. After Ctrl-C all further runs are answered by records of status
"interrupted", so that plans end by themselves.
"""

from __future__ import annotations

import heapq
import os
import signal
import sys
import threading
import traceback
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from queue import Empty, SimpleQueue
from types import FrameType
from typing import Any, Self

from contactlab.api import Record
from contactlab.errors import ContactlabWarning, RequestError
from contactlab.jobs.archive import FILE, Archive, StoredRun, in_words
from contactlab.jobs.far_end import BEGUN
from contactlab.jobs.perform import perform
from contactlab.jobs.processes import Call, Pool, ProcessDiedError, RaisedError, StoppedError, TimedOutError
from contactlab.jobs.progress import Progress
from contactlab.jobs.record import ended, from_bytes, record_of
from contactlab.jobs.run import Plan, Run
from contactlab.jobs.scheduler import LOCAL, checked_scheduler, open_pool
from contactlab.jobs.system import machine
from contactlab.parts.machine import usable_cores

NOT_BEGUN = "stopped before it began"
SLOW = 30.0
"""Wall time that a run may take, in limits of its CPU time: machines share their cores, and a process may hang."""
LOOK = 0.1
"""Seconds from one look at signals to the next."""


@dataclass
class _Task:
    """A plan at work: `slot` is its place among the answers of its parent, or its number."""

    plan: Plan
    parent: _Task | None
    slot: int
    answers: list[Any] = field(default_factory=list)
    open: int = 0


@dataclass(order=True)
class _Waiting:
    """A run in the queue, with the plans that requested it."""

    rank: tuple[float, ...]
    number: int
    run: Run = field(compare=False)
    asked_by: list[tuple[_Task, int]] = field(compare=False)


class Driver:
    """Carries out plans; one at a time works in a folder.

    folder      of the archive and the results folders; None: no files
    jobs        runs at a time; one per core by default
    time_limit  wall time of a run from the end of its preparations [s]
    interrupted whether Ctrl-C or SIGTERM ended it before its time
    meanwhile   called once, when the first runs are under way and this process has to wait

    Raises RequestError for a wrong request, or if another command writes to the folder.
    """

    def __init__(
        self, folder: Path | None = None, jobs: int | None = None, scheduler: str = LOCAL,
        time_limit: float | None = None, progress: Progress | None = None,
    ) -> None:  # fmt: skip
        if jobs is not None and jobs < 1:
            raise RequestError("there must be at least one process", where="jobs", got=jobs, allowed="1 or more")
        if time_limit is not None and not 0.0 < time_limit < float("inf"):
            raise RequestError("no time to run in", where="time_limit", got=time_limit, allowed="seconds, above 0")
        self.folder, self.size, self.time_limit = folder, jobs or usable_cores(), time_limit
        self.scheduler, self.progress = checked_scheduler(scheduler), progress or Progress()
        self.interrupted = False
        self.meanwhile: Callable[[], None] | None = None
        self._archive: Archive | None = None
        self._pool: Pool | None = None
        self._lock: Any = None
        self._signals: dict[Any, Any] = {}
        self._asked_to_stop = 0
        self._numbers = iter(range(sys.maxsize))
        self._queue: list[_Waiting] = []
        self._under_way: dict[tuple[str, str], _Waiting] = {}
        self._advancing: deque[tuple[_Task, list[Any] | None]] = deque()
        self._events: SimpleQueue[tuple[_Waiting, Future[bytes] | None]] = SimpleQueue()
        self._ready: set[frozenset[str]] = set()
        self._preparing: set[frozenset[str]] = set()

    # --- opening and closing -----------------------------------------------------------------------

    def __enter__(self) -> Self:
        if self.folder is not None:
            self._lock = _claimed(self.folder)
            if (self.folder / FILE).exists() and self.archive is not None and self.archive.damage:
                told = f"{in_words(self.archive.damage)}; damaged entries are run again when requested"
                warnings.warn(f"{self.folder / FILE}: {told}", ContactlabWarning, stacklevel=2)
        if threading.current_thread() is threading.main_thread():
            for name in ("SIGINT", "SIGTERM", "SIGHUP"):
                number = getattr(signal, name, None)
                # a process that ignores one (in the background, under nohup) continues to ignore it
                if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                    self._signals[number] = signal.signal(number, self._signalled)
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        try:
            if self._pool is not None:
                if kind is not None:
                    self._pool.kill()
                self._pool.close()
        finally:
            for number, before in self._signals.items():
                signal.signal(number, before)
            if self._archive is not None:
                self._archive.close()
            if self._lock is not None:
                os.close(self._lock)
            self.progress.close()

    @property
    def archive(self) -> Archive | None:
        """The archive of the folder, made when it is first needed; None without a folder."""
        if self._archive is None and self.folder is not None:
            self._archive = Archive(self.folder / FILE)
        return self._archive

    def _signalled(self, number: int, frame: FrameType | None) -> None:
        self._asked_to_stop += 1
        if self._asked_to_stop > 2 or (self._asked_to_stop > 1 and not self.interrupted):
            raise KeyboardInterrupt  # what should have seen the first one hangs

    # --- plans -------------------------------------------------------------------------------------

    def result(self, plan: Plan) -> Any:
        """Carry out one plan."""
        for _, found in self.results([plan]):
            return found
        raise AssertionError("a plan has a result")

    def results(self, plans: Iterable[Plan]) -> Iterator[tuple[int, Any]]:
        """Carry out plans side by side; number and result of each as it ends."""
        for number, plan in enumerate(plans):
            self._advancing.append((_Task(plan, None, number), None))
        while True:
            while self._advancing:
                ended_plan = self._advance(*self._advancing.popleft())
                if ended_plan is not None:
                    yield ended_plan
                self._look()
            if not self._queue and not self._under_way:
                return
            self._fill()
            self._wait()

    def _advance(self, task: _Task, answers: list[Any] | None) -> tuple[int, Any] | None:
        """Take a plan to its next request; its number and result if it is one of the caller's and has ended."""
        try:
            asked = list(next(task.plan) if answers is None else task.plan.send(answers))
        except StopIteration as end:
            if task.parent is None:
                return task.slot, end.value
            self._answer(task.parent, task.slot, end.value)
            return None
        task.answers, task.open = [None] * len(asked), len(asked)
        if not asked:
            self._advancing.append((task, []))
        for slot, one in enumerate(asked):
            if isinstance(one, Generator):
                self._advancing.append((_Task(one, task, slot), None))
            else:
                self._ask(one, task, slot)
        return None

    def _answer(self, task: _Task, slot: int, answer: Any) -> None:
        task.answers[slot] = answer
        task.open -= 1
        if not task.open:
            self._advancing.append((task, task.answers))

    # --- runs --------------------------------------------------------------------------------------

    def _ask(self, run: Run, task: _Task, slot: int) -> None:
        if self.interrupted:
            self._answer(task, slot, ended("interrupted", NOT_BEGUN))
            return
        known = self._known(run)
        if known is not None:
            self._answer(task, slot, known)
            return
        same = self._under_way.get(run.identity)
        if same is not None:
            same.asked_by.append((task, slot))
            return
        waiting = _Waiting(run.rank, next(self._numbers), run, [(task, slot)])
        heapq.heappush(self._queue, waiting)

    def _known(self, run: Run) -> Record | None:
        """Return the archive's record of a run that would be made in the same way."""
        kept = self._archive
        if kept is None or self.folder is None:
            return None
        if run.place and not (self.folder / run.place / run.proof).exists():
            return None
        where = machine() if self.scheduler == LOCAL else None
        record = kept.record(run.key, where)
        if record is None and run.cpu_limit < float("inf"):
            record = kept.record(run.limit_key, where)
        elif record is not None and run.timed and "calibration_s" not in record.summary:
            return None  # its time is from a run without preparation
        return None if record is None else replace(record, summary={**record.summary, "known": True})

    def _fill(self) -> None:
        """Begin runs while processes are free, runs of the lowest rank first."""
        left: list[_Waiting] = []
        # what a cluster offers may change
        while self._queue and len(self._under_way) < (self._pool or self).size and not self.interrupted:
            waiting = heapq.heappop(self._queue)
            run = waiting.run
            if run.identity in self._under_way:
                self._under_way[run.identity].asked_by.extend(waiting.asked_by)
            elif (known := self._known(run)) is not None:  # made meanwhile for another plan
                self._settle(waiting, known)
            elif why := run.unless():
                self._settle(waiting, ended("not-run", why))
            elif run.timed and self._has_to_wait(run):
                left.append(waiting)
            else:
                self._submit(waiting)
        for waiting in left:
            heapq.heappush(self._queue, waiting)

    def _has_to_wait(self, run: Run) -> bool:
        """Return whether another run compiles: kernels that several runs need are compiled once."""
        if run.composition in self._ready:
            return False
        if self._preparing:
            return True
        self._preparing.add(run.composition)
        return False

    def _submit(self, waiting: _Waiting) -> None:
        run = waiting.run
        if self._pool is None:
            self._pool = open_pool(self.scheduler, self.size, self.folder)
        place = (self.folder / run.place).resolve() if self.folder is not None and run.place else None
        limits = [self.time_limit or float("inf"), SLOW * run.cpu_limit]
        limit = min(limits) if min(limits) < float("inf") else None
        self._under_way[run.identity] = waiting
        self.progress.begun(run.name)

        def report(message: Any) -> None:
            if message == BEGUN:
                self._events.put((waiting, None))
            elif isinstance(message, str):
                self.progress.say(message)
            else:
                self.progress.advance(run.name, *message)

        bare = replace(run, unless=Run.unless)  # without what another process does not need
        future = self._pool.submit(Call(perform, (bare, place), report, limit, place))
        future.add_done_callback(lambda done: self._events.put((waiting, done)))

    def _wait(self) -> None:
        """Wait until something has happened, or a moment."""
        if not self._under_way:
            return
        if self.meanwhile is not None:
            first, self.meanwhile = self.meanwhile, None
            first()
        with suppress(Empty):
            waiting, future = self._events.get(timeout=LOOK)
            self._preparing.discard(waiting.run.composition)
            if waiting.run.composition not in self._ready:
                self._ready.add(waiting.run.composition)
                self.progress.say("")
            if future is not None:
                self._take(waiting, future)
        self._look()

    def _take(self, waiting: _Waiting, future: Future[bytes]) -> None:
        """Take in the outcome of a run, and put it into the archive."""
        run = waiting.run
        del self._under_way[run.identity]
        record, content = self._outcome(run, future)
        if content is not None and self.archive is not None:
            summary = record.summary
            key = run.limit_key if "cpu_limit" in summary else run.key
            work = summary.get("steps", 0) + summary.get("iterations", 0)
            cpu = summary["process_s"] - float(summary.get("cost", {}).get("compile_s", 0.0))
            end = (record.status, record.reason, work, cpu, content)
            self.archive.add_run(StoredRun(key, run.name, run.scene.toml(), *end, summary["machine"]))
        self._settle(waiting, record)

    def _settle(self, waiting: _Waiting, record: Record) -> None:
        self.progress.ended(waiting.run.name)
        for task, slot in waiting.asked_by:
            self._answer(task, slot, record)

    def _outcome(self, run: Run, future: Future[bytes]) -> tuple[Record, bytes | None]:
        """The record of a run, and its bytes if it is one that need not be made again."""
        try:
            content = future.result()
        except TimedOutError as error:
            return self._over_time(run, error), None
        except (CancelledError, StoppedError):
            return ended("interrupted", NOT_BEGUN), None
        except ProcessDiedError as error:
            return self._stored_all_the_same(run) or (
                ended("interrupted", "stopped by the user") if self.interrupted else ended("failed", str(error))
            ), None
        except RaisedError as error:
            return ended("failed", str(error), traceback=error.details), None
        except Exception as error:  # it could not be sent there, or its answer not back
            return ended("failed", f"{type(error).__name__}: {error}", traceback=traceback.format_exc()), None
        record = from_bytes(content)
        return record, content if record.status != "interrupted" else None

    def _over_time(self, run: Run, error: TimedOutError) -> Record:
        """Return the record of a run stopped at its time limit; if it finished all the same, it has finished."""
        if not isinstance(error.result, bytes):
            return self._stored_all_the_same(run) or ended("timed-out", f"{error}; it did not answer and was killed")
        record = from_bytes(error.result)
        if record.status != "interrupted":
            return record
        return replace(record, status="timed-out", reason=f"{error}, after step {record.summary['steps']}")

    def _stored_all_the_same(self, run: Run) -> Record | None:
        """The record of a run that was killed after its results folder was complete."""
        if self.folder is None or not run.place:
            return None
        from contactlab.run.restart import finished_results

        with suppress(RequestError):
            results = finished_results((self.folder / run.place).resolve(), run.scene)
            return None if results is None else record_of(results, run.job)
        return None

    # --- stopping ----------------------------------------------------------------------------------

    def _look(self) -> None:
        """Stop on request: in order the first time, by killing processes the second time."""
        if self._asked_to_stop and not self.interrupted:
            self.interrupted = True
            if self._under_way:
                names = [waiting.run.name for waiting in self._under_way.values()]
                shown = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
                saved = "1 run has saved its state" if len(names) == 1 else f"{len(names)} runs have saved their states"
                print(
                    f"contactlab: stopping when {saved}: {shown} (Ctrl-C again kills them)",
                    file=sys.stderr,
                )
            for waiting in self._queue:
                self._settle(waiting, ended("interrupted", NOT_BEGUN))
            self._queue.clear()
            if self._pool is not None:
                self._pool.stop()
        elif self._asked_to_stop > 1 and self._under_way and self._pool is not None:
            print("contactlab: killing the runs; their last saved states are kept", file=sys.stderr, flush=True)
            self._asked_to_stop = 1
            self._pool.kill()


def _claimed(folder: Path) -> int | None:
    """Lock a folder for one command; the system releases the lock even if the process is killed."""
    try:
        import fcntl
    except ImportError:
        return None
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(handle)
        raise RequestError(
            "another command is writing to this folder", where=f"results folder {folder}",
            hint="wait for it, or name another folder",
        ) from error  # fmt: skip
    return handle
