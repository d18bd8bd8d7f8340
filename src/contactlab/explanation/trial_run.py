"""Trial: the first steps of a run in a separate process, and then the begin of the run, for a part of its cost.

Only a fresh process can distinguish that from what was loaded already. Its files go to a temporary folder; it also
leaves machine code in the cache, where the run itself will find it.
"""

from __future__ import annotations

import _thread
import json
import math
import pickle
import signal
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time, thread_time
from typing import TYPE_CHECKING, Any, NamedTuple

from contactlab.errors import SimulationFailure

if TYPE_CHECKING:
    from contactlab.model.held_arrays import HeldArray
    from contactlab.scene.scene import Scene

STEPS = 40  # after the first; enough to measure the cost of a step
PATIENCE = 0.5  # seconds after which fewer must do
SHARE = 0.2
"""Share of the roughly estimated cost of a run that its trial may take."""
LEAST, MOST = 0.5, 5.0
"""CPU time that a trial takes at least and at most [s]."""
CUT = "cut"
"""Status of a trial that was stopped at its limit."""
_FAR_END = "from contactlab.explanation.trial_run import main; main()"


class KernelCalls(NamedTuple):
    """A compiled kernel that was called: how often in a step on average, and whether it had to be compiled now."""

    kernel: str
    per_step: float
    compiled: bool


class PartCost(NamedTuple):
    """Wall time of a further step [s] in a part of the elements or of the contact; the part with its distribution."""

    phase: str
    what: str
    part: str
    seconds: float


class Begin(NamedTuple):
    """A run that was stopped after some CPU time, or a whole one.

    status      "finished", "cut", or how it failed
    steps, iterations  that were made
    cpu_s       CPU time of the steps without compilation [s]
    once_s      of that, what is not proportional to steps: the first frame, and closing files [s]
    done        share of the loading that was done; 0 if no frame was reached
    memory_mib  largest memory of the process [MiB]
    missing     warnings of effects that are missing, as far as the run came
    """

    status: str
    reason: str
    steps: float
    iterations: float
    cpu_s: float
    once_s: float
    done: float
    memory_mib: float
    missing: Sequence[str] = ()


@dataclass(frozen=True)
class TrialRun:
    """Imports, arrays, calls and costs of the first steps of a run.

    modules  imported modules of the project and of plugins, and top-level names of other libraries
    arrays   every array that the model, the bound integrator and the observers of the run hold
    import_s, build_s, first_step_s  wall time [s]
    step_s   CPU time of each further step [s]; without any, of the first without compiling and loading
    wall_step_s, costs  wall time of each further step [s], and of the parts in it; NaN and empty without any
    steps    further steps that were made
    begin    the begin of the run itself, with its frames and files; None if not requested
    compile_s  time of compilation within the time of building [s]
    """

    kernels: Sequence[KernelCalls]
    modules: Sequence[str]
    arrays: Sequence[HeldArray]
    import_s: float
    build_s: float
    first_step_s: float
    step_s: float
    wall_step_s: float
    costs: Sequence[PartCost]
    steps: int
    begin: Begin | None = None
    compile_s: float = 0.0

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> TrialRun:
        """Make a trial of its plain tables."""
        from contactlab.model.held_arrays import HeldArray

        found = dict(data)
        for name, row in (("kernels", KernelCalls), ("costs", PartCost), ("arrays", HeldArray)):
            found[name] = [row(*values) for values in found[name]]
        found["begin"] = None if found["begin"] is None else Begin(*found["begin"])
        return cls(**found)


def run_trial(scene: Scene, share: float = 0.0) -> TrialRun:
    """Make the first steps of `scene`, and its begin for a `share` of its cost. Raises SimulationFailure."""
    request = pickle.dumps((sys.path, pickle.dumps(scene), share))
    done = subprocess.run([sys.executable, "-P", "-c", _FAR_END], input=request, capture_output=True, check=False)
    if done.returncode:
        # raises what stands in the way of the model itself, as a run would
        from contactlab.model.build import build

        build(scene, scene.registry)
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:] or ["no message"]
        raise SimulationFailure("failed", f"the first steps: {last[0]}")
    return TrialRun.from_data(json.loads(done.stdout.splitlines()[-1]))


# --- in the other process ------------------------------------------------------------------------


def main() -> None:
    """Read a pickled scene from standard input, make its trial run, and print what was found as JSON."""
    sys.path[:], scene, share = pickle.load(sys.stdin.buffer)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # also in the background, where it is ignored
    trial = _trial_of(lambda: pickle.loads(scene))
    if share:
        trial = replace(trial, begin=_begin_of(pickle.loads(scene), share, trial.step_s))
    print(json.dumps(asdict(trial)))


def _begin_of(scene: Scene, share: float, step_s: float) -> Begin:
    """Run the scene for a share of its cost, whose first steps took `step_s` each.

    Memory is measured in the first steps: recorders keep theirs, and two runs of a process need more than one.
    """
    from contactlab.api.compiled.compiler import COMPILATION
    from contactlab.results.peak_memory import peak_memory_mib
    from contactlab.run.interruption import Interrupted
    from contactlab.run.simulation import simulate

    ended, memory = threading.Event(), peak_memory_mib()
    marks: list[tuple[float, float, float]] = []  # share done, steps, CPU time
    detectors: list[Any] = []

    def begun(run: Any) -> None:
        detectors.extend(run.monitor.early)
        limit = min(max(share * step_s * run.schedule.estimated_steps(), LEAST), MOST)
        threading.Thread(target=_stop_after, args=(limit, ended), daemon=True).start()

    def progress(fraction: float, step: int, *rest: float) -> None:
        marks.append((fraction, step, thread_time() - COMPILATION.seconds))

    with TemporaryDirectory() as folder:
        try:
            results = simulate(scene, out=Path(folder) / "run", progress=progress, announce=begun)
        except Interrupted as stop:
            results = stop.results
        except SimulationFailure as failure:
            return Begin(failure.status, failure.reason, 0.0, 0.0, 0.0, 0.0, 0.0, memory)
        finally:
            ended.set()
    summary, cost = results.summary, results.summary["cost"]
    done, once, seconds = 0.0, 0.0, cost["run_cpu_s"] - cost["compile_s"]
    if len(marks) > 1 and marks[-1][1] > marks[0][1]:
        done, steps, _ = marks[-1]
        once = max(0.0, seconds - (marks[-1][2] - marks[0][2]) * summary["steps"] / (steps - marks[0][1]))
    whole = results.status == "finished" or done >= 1.0
    status = "finished" if whole else CUT if results.status == "interrupted" else results.status
    missing = [warning.text for detector in detectors if (warning := detector.warning())]
    return Begin(status, results.reason, summary["steps"], summary.get("iterations", 0), seconds, once,
                 1.0 if whole else done, memory, missing)  # fmt: skip


def _stop_after(limit: float, ended: threading.Event) -> None:
    """Press Ctrl-C once after so much CPU time [s] of this process, unless the run has ended."""
    until = process_time() + limit
    while not ended.wait(max(0.01, until - process_time())):
        if process_time() >= until:
            _thread.interrupt_main()
            return


def _trial_of(load: Callable[[], Any]) -> TrialRun:
    began = perf_counter()
    kernels = count_kernel_calls()
    scene = load()
    from contactlab.api.compiled.compiler import COMPILATION
    from contactlab.model.build import build
    from contactlab.model.held_arrays import held_arrays
    from contactlab.run.prepare import prepare_run
    from contactlab.run.recorders import record_stored
    from contactlab.run.simulation import steps

    loaded = perf_counter()
    with TemporaryDirectory() as folder:
        model = build(scene, scene.registry)
        run = prepare_run(model, scene, scene.registry, Path(folder), resume=False)
        built, compiled = perf_counter(), COMPILATION.seconds
        integrator = model.bound_integrator()
        made_steps = steps(run, integrator)
        before, cpu = Counter(kernels.calls), thread_time() - COMPILATION.seconds
        run.solve_coarser_levels()
        run.store_start()
        _made(made_steps, 1)
        first, cost = perf_counter(), thread_time() - COMPILATION.seconds - cpu
        after, so_far, cpu, wall = Counter(kernels.calls), _so_far(run), thread_time(), perf_counter()
        made = _made(made_steps, STEPS)
        wall = (perf_counter() - wall) / made if made else math.nan
        if made:
            before, cost = after, (thread_time() - cpu) / made
        rows = kernels.rows(before, max(1, made))
        costs = _costs(run, so_far, made)  # which calls laws and elements once more
        run.guards.check()
        run.schedule.adapt()
        run.store()
        arrays = held_arrays(model, integrator=integrator.advance, run=run)
        record_stored(run.when_over, Path(folder), run.finish("interrupted", "trial run"))
    return TrialRun(
        kernels=[*rows, *(row for row in kernels.rows({}, 1) if row.kernel not in {r.kernel for r in rows})],
        modules=imported_modules(scene.registry.packages()),
        arrays=arrays,
        import_s=loaded - began,
        build_s=built - loaded,
        first_step_s=first - built,
        step_s=cost,
        wall_step_s=wall,
        costs=costs,
        steps=made,
        compile_s=compiled,
    )


def _so_far(run: Any) -> tuple[float, dict[str, dict[str, float]]]:
    """Seconds of all elements, and of contact by what is done in it and the part that does it."""
    from contactlab.results.cost import of_contact

    return run.model.seconds, of_contact(run.model, run.journal.layout)


def _costs(run: Any, before: tuple[float, dict[str, dict[str, float]]], steps: int) -> list[PartCost]:
    """Return the cost of each part per step, over the last `steps`."""
    from contactlab.results.cost import of_elements

    if not steps:
        return []
    seconds, contact = _so_far(run)
    lately = (seconds - before[0]) / seconds if seconds else 0.0
    costs = [
        PartCost("elements", what, part, lately * whole / steps)
        for what, parts in of_elements(run.model, run.journal.layout).items()
        for part, whole in parts.items()
    ]
    return costs + [
        PartCost("contact", what, part, (whole - before[1].get(what, {}).get(part, 0.0)) / steps)
        for what, parts in contact.items()
        for part, whole in parts.items()
    ]


def _made(made: Iterator[Any], most: int) -> int:
    """Make steps for a while, at least one where there are any; how many."""
    count, until = 0, perf_counter() + PATIENCE
    for _ in islice(made, most):
        count += 1
        if perf_counter() > until:
            break
    return count


def imported_modules(packages: Collection[str] = ()) -> list[str]:
    """Modules outside the standard library: all of the project and of the packages of plugins that are given.

    Modules of libraries are listed by their top-level name, or by the part of SciPy.
    """
    names = set()
    for name in list(sys.modules):
        top, *inner = name.split(".")
        if top in sys.stdlib_module_names or top.startswith(("_", "cython")):
            continue
        if top.startswith("contactlab") or top in packages:
            names.add(name)
        elif top == "scipy":
            # numba asks for SciPy's version: only what is inside it weighs anything
            names |= {f"scipy.{part}" for part in inner[:1] if part == "sparse"}
        else:
            names.add(top)
    return sorted(names - {"contactlab.explanation.trial_run"})


@dataclass(frozen=True)
class KernelCounter:
    """Calls from Python of kernels, by module and name, in the order of their first call."""

    calls: Counter[str]
    kernels: dict[str, Any]

    def rows(self, before: Mapping[str, int], steps: int) -> list[KernelCalls]:
        """Every kernel that was called at all, with its calls in each of `steps` steps since `before`."""
        return [
            KernelCalls(name, (calls - before.get(name, 0)) / steps, bool(self.kernels[name].stats.cache_misses))
            for name, calls in self.calls.items()
        ]


def count_kernel_calls() -> KernelCounter:
    """Count the calls of every kernel from now on, for the rest of this process."""
    module: Any = import_module("contactlab.api.compiled.kernel")
    counter, plain = KernelCounter(Counter(), {}), module.Kernel.__call__

    def counted(self: Any, *arguments: Any, **named: Any) -> Any:
        name = f"{self.py_func.__module__}.{self.py_func.__name__}"
        counter.calls[name] += 1
        counter.kernels[name] = self
        return plain(self, *arguments, **named)

    module.Kernel.__call__ = counted
    return counter
