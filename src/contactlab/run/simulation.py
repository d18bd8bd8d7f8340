"""The simulation loop: scene in, results out."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from time import perf_counter

from contactlab.api import Step, StepStatus, Watch
from contactlab.arguments import NAME, arguments
from contactlab.errors import (
    ContactlabError,
    ContactlabWarning,
    NotFiniteError,
    RequestError,
    SimulationFailure,
    WrongAnswer,
    one_line,
)
from contactlab.model.build import build
from contactlab.model.model import BoundIntegrator
from contactlab.parts.error_origin import part_at_fault, part_errors
from contactlab.parts.machine import with_one_blas_thread
from contactlab.parts.registry import Registry
from contactlab.results.peak_memory import reset_peak
from contactlab.results.results import Results
from contactlab.run.ahead import compile_ahead
from contactlab.run.attempts import Attempts
from contactlab.run.folders import run_folder
from contactlab.run.guards import EVERY
from contactlab.run.in_order import InOrder, as_begun
from contactlab.run.interruption import Interrupted, Interruption
from contactlab.run.prepare import prepare_run
from contactlab.run.recorders import record_stored, recorders_of, when_over
from contactlab.run.restart import finished_results
from contactlab.run.run import Run
from contactlab.run.watches import NoGuards, Watching, WorkLimit
from contactlab.scene.auto import is_auto
from contactlab.scene.scene import Scene, load_scene
from contactlab.views import view

MOST = 52  # steps that are repeated: from one look at the model to the next, and what a fault takes to be seen

OURS = (ArithmeticError, LookupError, ValueError, TypeError, AttributeError, ContactlabError)
"""Errors that a wrong array ends in; any other error that no part raised is shown as a bug of the core."""

NOTHING_WATCHED: Mapping[str, Watch] = {}

Progress = Callable[[float, int, float, float], None]
"""Called with fraction done, step, time [s] and energy error."""


@arguments(
    scene=(Scene, *NAME), out=NAME, registry=Registry, resume=bool, watch=Mapping, work=Real, guards=bool,
)  # fmt: skip
@with_one_blas_thread
def simulate(
    scene: Scene,
    out: str | Path | None = None,
    registry: Registry | None = None,
    progress: Progress | None = None,
    resume: bool = False,
    watch: Mapping[str, Watch] = NOTHING_WATCHED,
    work: float = math.inf,
    guards: bool = True,
    announce: Callable[[Run], None] | None = None,
) -> Results:
    """Run a scene (a `Scene`, a bundled name or a TOML file) and return its results.

    `out` is the folder for files, none are written without it. With `resume` an interrupted run in `out`
    continues where it was saved, a finished run is read back, and a run starts in an empty folder.
    `watch` are watches by name, whose findings are `Results.watched`. `work` is the number of steps and iterations
    after which the run ends as "timed-out". Without `guards` nothing stops a run whose numbers go wild. `announce` is
    called with the run before its first step.
    A run that fails is a result too: see `Results.status` and `Results.reason`. Raises RequestError
    (scene, part or folder wrong) before the first step, and Interrupted, which carries the results,
    after Ctrl-C, SIGTERM or SIGHUP. BLAS has one thread meanwhile, so that bits do not depend on their number.
    With `integrator = "auto"` the results are those of the first integrator that gets through.
    """
    scene = load_scene(scene) if isinstance(scene, str | Path) else scene
    registry = registry or scene.registry
    if progress is None and "ipykernel" in sys.modules and view("notebook.bar.in_notebook")():
        progress = view("notebook.bar.notebook_bar")(scene.name)
    folder = run_folder(out, resume)
    if resume and folder is not None:
        scene = as_begun(scene, folder)
    simulation = _Simulation(registry, folder, progress, watch, work, guards, announce)
    if is_auto(scene.integrator):
        results = InOrder(scene, folder, simulation.run, simulation.interrupted).results(resume)
    else:
        results = simulation.run(scene, resume)
    if not simulation.made:
        return results
    for broken in registry.run_finished(results.summary, results.folder):
        warnings.warn(f"{broken.origin}: {broken.reason}", ContactlabWarning, stacklevel=2)
    if simulation.interrupted():  # a run that was over by then is whole, but whoever asked for more does not want it
        raise Interrupted(results)
    return results


@dataclass
class _Simulation:
    """The runs of one call of `simulate`, whose arguments these are.

    made    whether there was any that was not just read back
    signal  that ended the last one, empty without any
    """

    registry: Registry
    folder: Path | None
    progress: Progress | None
    watch: Mapping[str, Watch]
    work: float
    guards: bool
    announce: Callable[[Run], None] | None
    made: bool = False
    signal: str = ""

    def interrupted(self) -> bool:
        """Return whether a signal ended a run."""
        return bool(self.signal)

    def run(self, scene: Scene, resume: bool, attempts: Attempts | None = None) -> Results:
        """Make one run, after `attempts` with other integrators; with `resume` what is stored is not made again."""
        registry, folder = self.registry, self.folder
        if resume and not self.watch and folder is not None and (over := finished_results(folder, scene)) is not None:
            missing = when_over(recorders_of(scene, registry))
            missing = {name: r for name, r in missing.items() if not (folder / r.shown_file).is_file()}
            record_stored(missing, folder, over)  # it was killed after its last step
            return over
        self.made, began = True, perf_counter()
        reset_peak()
        with Interruption() as interruption:
            compile_ahead(scene)
            model = build(scene, registry)
            if attempts is not None:
                attempts.refuse_motion(model, scene)
            with part_errors(registry):
                watching = Watching(model, self.watch) if self.watch else None
                run = prepare_run(model, scene, registry, folder, resume, watching, attempts)
            if self.work < math.inf:
                run.work_limit = WorkLimit(run.counts, self.work - (attempts.work if attempts is not None else 0))
            if not self.guards:
                run.guards = NoGuards()
            run.clock.build_s = perf_counter() - began
            if self.announce is not None:
                self.announce(run)
            interruption.ends_by(run.schedule.stop)
            try:
                status, reason = _guarded(run, registry, interruption, self.progress)
            except RequestError:
                run.journal.release()
                raise
            run.failed(status)
            results = run.finish(status, reason)
            if folder is not None and run.when_over and results.frames:
                record_stored(run.when_over, folder, results)
        results.watched = watching.found() if watching is not None else {}
        self.signal = interruption.name
        return results


def _guarded(run: Run, registry: Registry, interruption: Interruption, progress: Progress | None) -> tuple[str, str]:
    """Run the loop; returns how it ended and why."""
    try:
        run.clock.start()
        _advance(run, progress)
        if interruption.name:
            return "interrupted", run.pause(f"stopped by {interruption.name}")
        run.conclude()
        if progress is not None:  # the last frame may lie some steps before the end
            progress(1.0, run.model.state.step, run.model.state.time, run.energy_error)
        return "finished", ""
    except NotFiniteError as failure:
        found = wrong_answer(run)
        return ("failed", found) if found else (failure.status, failure.reason)
    except SimulationFailure as failure:
        return failure.status, failure.reason
    except RequestError as failure:
        if not run.counts.steps:
            raise
        return "failed", f"step {run.model.state.step}: {one_line(failure, name=False)}"
    except WrongAnswer as failure:  # it names the part; the line is the caller's
        seen = f"step {run.model.state.step}: {failure}"
        return "failed", wrong_answer(run) or seen
    except (Exception, SystemExit) as failure:
        place = part_at_fault(failure, registry)
        if not place and not isinstance(failure, OURS):
            raise
        raised = f"{place}: the part raised " if place else ""
        return "failed", f"step {run.model.state.step}: {raised}{one_line(failure)}"


def _advance(run: Run, progress: Progress | None) -> None:
    model, schedule, guards, counts = run.model, run.schedule, run.guards, run.counts
    integrator = model.bound_integrator()
    save_every, save = run.saves
    run.solve_coarser_levels()
    run.store_start()
    for _ in steps(run, integrator):
        if counts.steps % EVERY == 0:
            guards.check()
            schedule.adapt()
            run.keep()
            run.listen()
        if schedule.frame_due():
            guards.check()
            run.listen()
            run.store()
            if progress is not None:
                progress(schedule.fraction(), model.state.step, model.state.time, run.energy_error)
        if counts.steps % save_every == 0:
            save()  # after the frame of this step: what is saved has all of its frames


def wrong_answer(run: Run) -> str:
    """Step, part and method of the first answer since the kept state that is not finite; empty if all are finite.

    Called after a run: its state afterwards is the state of the step at fault, or unchanged.
    """
    kept = run.kept.newest
    if kept is None:
        return ""
    from contactlab.model.examination import Examined

    model = run.model
    kept.bring_back(model)
    step = model.state.step
    advance = model.bound_integrator(Examined(model)).step
    for number in range(step + 1, step + MOST + 1):
        try:
            advance(run.schedule.dt)
        except WrongAnswer as found:
            return f"step {number}: {found}"
        except Exception:
            return ""  # no part's answer is to blame: report what stopped the run in the first place
    return ""


def steps(run: Run, integrator: BoundIntegrator) -> Iterator[Step]:
    """Yield accepted steps until the run ends, each counted, guarded and sampled; retry failed steps with a cut."""
    schedule, guards, counts, every_step = run.schedule, run.guards, run.counts, run.every_step
    begin, judged = run.step_judge() or (None, None)
    while not schedule.done():
        if begin is not None:
            begin()
        step = integrator.step(schedule.dt)
        if judged is not None:
            step = judged(step)
        if step.trace:
            run.iterated(step)
        if step.status is not StepStatus.accepted:
            run.taken_back(step)
            continue
        counts.steps += 1
        counts.iterations += step.iterations
        counts.sweeps += step.sweeps
        guards.after_step(step)
        for sample in every_step:
            sample(step, schedule.dt)
        yield step
