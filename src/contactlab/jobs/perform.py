"""Execution of one run of a plan in a process of its own."""

from __future__ import annotations

import _thread
import shutil
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event
from time import process_time
from typing import Any

import numpy as np

from contactlab.api import Job, Record, Watch
from contactlab.errors import PartError, RequestError, SimulationFailure
from contactlab.jobs.far_end import BEGUN, WORN
from contactlab.jobs.mean_forces import MEANS, MeanForces
from contactlab.jobs.processes import Report
from contactlab.jobs.record import ended, record_of, refused, to_bytes
from contactlab.jobs.run import Run
from contactlab.jobs.system import machine, system_facts
from contactlab.parts.registry import Registry, split_spec
from contactlab.results.result_file import FILE
from contactlab.scene.scene import Scene

LEEWAY = 2.0
"""Multiple of the CPU time limit at which a run is stopped: limits count the steps, the clock counts building, too."""
# Far below the stable step of any scene and far above round-off in time: enough to call every kernel.
_WARM_UP = {"level": 1, "time.step": 1e-12, "time.end": 4e-12, "time.ramp": 1.0}

_ready: set[frozenset[str]] = set()
"""Compositions of scenes for which this process has imported and loaded everything."""


def perform(run: Run, folder: Path | None, report: Report) -> bytes:
    """Make a run, into `folder` if it leaves files; `report` gets (fraction done, step). Returns its record as bytes.

    An interrupted run in `folder` is continued, a finished one is read back, and one without results is made again.
    """
    from contactlab.api.compiled.compiler import COMPILATION

    if run.timed:
        be_ready(run, report)
    report(BEGUN)
    began, compiled = process_time(), COMPILATION.seconds
    over = Event()
    try:
        with cpu_limit(LEEWAY * run.cpu_limit) if run.cpu_limit < float("inf") else nullcontext(over) as over:
            record = _timed(run, folder, report) if run.timed else made(run.job, run.scene, folder, _progress(report))
    except CpuLimitReached:
        over.set()
    if over.is_set():
        report(WORN)
        record = ended("timed-out", f"stopped after {run.cpu_limit:g} CPU s", cpu_limit=run.cpu_limit)
        began += COMPILATION.seconds - compiled  # of a run that finished its summary has this time
    facts = {"system": system_facts(), "machine": machine(), "process_s": process_time() - began}
    return to_bytes(replace(record, summary={**record.summary, **facts}))


Progress = Callable[[float, int, float, float], None]


def made(job: Job, scene: Scene, folder: Path | None = None, progress: Progress | None = None) -> Record:
    """Run one job and return its record, whatever the outcome."""
    from contactlab.run.interruption import Interrupted
    from contactlab.run.simulation import simulate

    resume = folder is not None and folder.exists()
    if resume and folder is not None and not (folder / FILE).is_file():
        shutil.rmtree(folder)
        resume = False
    try:
        watches = watches_of(job, scene.registry) | ({MEANS: MeanForces()} if job.means else {})
        results = simulate(
            scene, folder, scene.registry, progress, resume, watch=watches, work=job.work, guards=job.guards
        )
    except RequestError as error:
        return refused(str(error))
    except SimulationFailure as error:  # before the first step: contact that starts in an overlap, say
        return ended(error.status, error.reason)
    except Interrupted as stop:
        results = stop.results
    return record_of(results, job)


def watches_of(job: Job, registry: Registry) -> dict[str, Watch]:
    """The watches of a job by name. Raises PartError if one is not installed."""
    found: dict[str, Watch] = {}
    for number, spec in enumerate(job.watch):
        use, fields = split_spec("watch", spec, f"watch.{number}")
        name = str(fields.pop("name", use))
        if name in found:
            raise PartError("two watches have the same name", where=f"job {job.name}", got=name, hint="give a name key")
        found[name] = registry.make("watch", {"use": use, **fields}, f"job {job.name}, watch.{number}")
    return found


def _progress(report: Report) -> Progress:
    return lambda fraction, step, time, energy_error: report((fraction, step))


# --- costs ---------------------------------------------------------------------------------------------


def be_ready(run: Run, report: Report = lambda message: None) -> None:
    """Import, compile and load all that a run calls: no cost of the run. `report` gets lines on the compilation."""
    if run.composition not in _ready:
        _ready.add(run.composition)
        with suppress(Exception):  # what is wrong is wrong in the run itself, and reported there
            warm_up(run.scene, report)


def warm_up(scene: Scene, report: Report) -> None:
    """Make a few tiny steps, so that every kernel of the scene is compiled and in the cache on disk."""
    from contactlab.run.compiling import compilation_told
    from contactlab.run.simulation import simulate

    with TemporaryDirectory() as folder, compilation_told(scene, report):
        simulate(scene.with_(_WARM_UP), out=Path(folder) / "run", registry=scene.registry)


def _timed(run: Run, folder: Path | None, report: Report) -> Record:
    """Make the run, and the calibration before and after it."""
    before = calibrate()
    record = made(run.job, run.scene, folder, _progress(report))
    return replace(record, summary={**record.summary, "calibration_s": min(before, calibrate())})


SIZE, TURNS = 400, 3


@cache
def _matrix() -> Any:
    """A diagonally dominant matrix (SIZE, SIZE), the same in each process."""
    k = np.arange(SIZE)
    return np.eye(SIZE) + 1.0 / (1.0 + np.abs(k[:, None] - k[None, :]) ** 1.5)


def calibrate() -> float:
    """CPU time [s] of a fixed solution and sort, the least of three: makes machines and loads comparable."""
    matrix, right = _matrix(), np.ones(SIZE)
    times = []
    for _ in range(TURNS):
        began = process_time()
        solution = np.linalg.solve(matrix, right)
        np.sort(np.tile(solution, 120))
        times.append(process_time() - began)
    return min(times)


SHORTEST = 0.05
"""Time between two looks at the clock [s], at least."""


class CpuLimitReached(Exception):
    """Raised in a run that reaches its limit of CPU time."""


@contextmanager
def cpu_limit(seconds: float) -> Iterator[threading.Event]:
    """Interrupt what runs inside, as Ctrl-C does, when this process has used this CPU time [s]; again after as much.

    Compilation does not count: the first run of an installation has all of it. A thread looks at the clock: timers of
    the system that count CPU time make that clock itself coarse while they run (4 ms on Linux). Without effect outside
    of the main thread, the only one that is interrupted. Raises CpuLimitReached, unless what runs inside ends in order:
    the event that it gets is set then, too.
    """
    if threading.current_thread() is not threading.main_thread():
        yield threading.Event()
        return
    from contactlab.api.compiled.compiler import COMPILATION

    ended, over = threading.Event(), threading.Event()

    def clock() -> float:
        return process_time() - COMPILATION.seconds

    began = clock()

    def look() -> None:
        allowed = seconds
        while not ended.wait(max(allowed - (clock() - began), SHORTEST)):
            if clock() - began >= allowed and not COMPILATION.depth:  # what goes on is not in its seconds
                over.set()
                allowed += seconds
                _thread.interrupt_main()

    watching = threading.Thread(target=look, daemon=True)
    watching.start()
    try:
        yield over
    except KeyboardInterrupt as stop:
        if over.is_set():
            raise CpuLimitReached(f"stopped after {seconds:g} CPU s") from stop
        raise
    finally:
        ended.set()
        watching.join()
