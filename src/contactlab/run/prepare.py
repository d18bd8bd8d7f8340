"""Preparation of a run before its first step: build its parts, open its files, or restore the run saved there."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

from contactlab.api import Layout
from contactlab.errors import ContactlabWarning
from contactlab.missing_effects.monitor import EffectMonitor
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.model.sizes import check_frame_size
from contactlab.parts.provenance import parts_of, versions
from contactlab.parts.registry import Registry
from contactlab.results.files import HistoryFile, write_scene
from contactlab.results.frame import layout_of
from contactlab.results.journal import Journal
from contactlab.results.results import Results
from contactlab.run.attempts import Attempts
from contactlab.run.guards import Guards
from contactlab.run.kept_states import KeptStates
from contactlab.run.recorders import at_work, check_disk_space, open_recordings, recorders_of, when_over
from contactlab.run.restart import changed_versions, saved_run
from contactlab.run.run import Run
from contactlab.run.schedule import Schedule
from contactlab.run.watches import Watching
from contactlab.scene.scene import Scene


def prepare_run(
    model: Model,
    scene: Scene,
    registry: Registry,
    folder: Path | None,
    resume: bool,
    watching: Watching | None = None,
    attempts: Attempts | None = None,
) -> Run:
    """A run of `model`, whose recorders write to `folder`; with `resume` the run that is saved there.

    attempts  with other integrators before, of a scene that leaves the choice to the run

    Raises RequestError if the folder cannot be used or holds something else.
    """
    run = Run(model, schedule_of(model, scene), Guards(model, scene.time.step), EffectMonitor(scene, model), watching)
    if attempts is not None:
        run.attempts, run.clock.before = attempts, attempts.cost
    if run.schedule.skips:
        from contactlab.model.implicit_model import ImplicitModel
        from contactlab.run.nested import NestedStart

        assert isinstance(model, ImplicitModel)
        run.nested = NestedStart(scene, registry, model, run.schedule.stopped)
    recorders = recorders_of(scene, registry) if folder is not None else {}
    # the scene with the recorders that it really has, for the list of parts
    specs = tuple({"use": name.partition(" ")[0]} for name in recorders)
    used = replace(scene, record=replace(scene.record, recorders=specs))
    layout = layout_of(model, scene, parts_of(used, registry), versions(used, registry))
    # there is never a frame without a step: room for more would be taken for nothing
    steps = run.schedule.estimated_steps()
    if run.schedule.control is not None:
        steps = max(steps, scene.record.frames)  # that follow their error, and end at each
    budget = layout.budget if scene.record.budget is None else scene.record.budget
    layout = replace(layout, frames=min(layout.frames, steps), budget=budget)
    check_frame_size(layout.frames, len(layout.nodes), scene.where("record.frames"))
    working = at_work(recorders)
    wanted = {
        "steps": frozenset(name for name, recorder in working.items() if recorder.every_step),
        "contact_steps": frozenset(name for name, recorder in working.items() if recorder.every_contact),
        "iterates": frozenset(name for name, recorder in working.items() if recorder.every_iterate),
        "last_steps": frozenset(name for name, recorder in working.items() if recorder.every_field),
    }
    if folder is None:
        run.journal = Journal(model, layout, {}, wanted, share=run.schedule.share)
        return run
    window = None
    if wanted["contact_steps"] and layout.contacts and layout.budget:
        from contactlab.results.record_plan import Window

        window = Window.of(scene.record, layout)
    memory = sum(array.nbytes for array in run.saved().values())
    record = window.disk_bytes(layout, steps) if window is not None else 0.0
    iterates = None
    if wanted["iterates"] and not model.explicit:
        from contactlab.run.iterations import iterate_plan, iterates_on_disk, record_iterates

        iterates = iterate_plan(model, layout)
        record += iterates_on_disk(model, iterates, layout, steps) if iterates is not None else 0.0
    run.when_over = when_over(recorders)
    check_disk_space({**working, **run.when_over}, folder, layout, steps, memory, record, scene.where("record.frames"))
    claimed = HistoryFile(folder)
    past = _take_up(run, layout, folder) if resume else None
    write_scene(folder, layout.scene)
    recordings = open_recordings(recorders, folder, layout, past)
    run.journal = Journal(model, layout, recordings, wanted, claimed, past, window, run.schedule.share)
    if past is not None:
        run.journal.restore(run.saved_memory)
    if iterates is not None:
        record_iterates(run, iterates, scene.record)
    if wanted["last_steps"] and scene.record.last != 0:
        _keep_last_steps(run, scene, registry, folder)
    return run


def _keep_last_steps(run: Run, scene: Scene, registry: Registry, folder: Path) -> None:
    from contactlab.run.last_steps import LastSteps, length_of

    length = length_of(scene.record, run.journal.layout)
    if length:
        run.last_steps = LastSteps(
            run.model, length, lambda: build(scene, registry), run.schedule.share, scene.record.warnings == "all"
        )
        run.last_steps.begin(folder)
        run.kept = KeptStates(run.last_steps.states)


def _take_up(run: Run, layout: Layout, folder: Path) -> Results | None:
    """Restore the run that is saved in the folder, and return its results; None if nothing is saved."""
    saved = saved_run(folder)
    if saved is None:
        return None
    past, checkpoint = saved
    run.restore(checkpoint.memory, checkpoint.summary, folder)
    for change in changed_versions(past.layout, layout):
        warnings.warn(f"results may differ in their last digits: {change}", ContactlabWarning, stacklevel=4)
    return past


def schedule_of(model: Model, scene: Scene) -> Schedule:
    """The schedule that suits the scene's integrator."""
    if model.explicit:
        return Schedule(model, scene)
    from contactlab.run.load_steps import LoadSchedule

    return LoadSchedule(model, scene)
