"""The simulation loop: scene in, results out."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

from contactlab.errors import ContactlabError, RequestError, SimulationFailure
from contactlab.folders import claimed_folder
from contactlab.guards import EVERY, Guards
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.provenance import parts_of, versions
from contactlab.results.frame import take_frame
from contactlab.results.recording import Recording
from contactlab.results.results import Results
from contactlab.results.summary import Clock, Counts, summarise
from contactlab.schedule import Schedule

Progress = Callable[[float, int, float, float], None]
"""Called with fraction done, step, time [s] and energy error."""


def simulate(
    scene: Any, out: str | Path | None = None, registry: Any = None, progress: Progress | None = None
) -> Results:
    """Run a scene (a `Scene`, a bundled name or a TOML file) and return its results.

    `out` is the folder for files, none are written without it. A run that fails is a result too: see
    `Results.status` and `Results.reason`. Raises RequestError (scene or part wrong) before the first step.
    """
    from contactlab.scene import load_scene

    scene = load_scene(scene) if isinstance(scene, str | Path) else scene
    registry = registry or scene.registry
    clock, began = Clock(), perf_counter()
    model = build(scene, registry)
    clock.build_s = perf_counter() - began
    labels = {f"contacts.{i}": spec.name or f"contacts.{i}" for i, spec in enumerate(scene.contacts)}
    recording = Recording(model, scene.toml(), labels, claimed_folder(Path(out)) if out is not None else None)
    counts = Counts()
    status, reason = _guarded(model, scene, recording, counts, clock, progress)
    summary = summarise(
        scene, parts_of(scene, registry), versions(scene, registry), model, recording.last, status, reason, counts, clock
    )
    results = recording.finish(summary)
    for broken in registry.run_finished(results.summary, results.folder):
        warnings.warn(f"{broken.origin}: {broken.reason}", RuntimeWarning, stacklevel=2)
    return results


def _guarded(
    model: Model, scene: Any, recording: Recording, counts: Counts, clock: Clock, progress: Progress | None
) -> tuple[str, str]:
    """Run the loop; how it ended and why."""
    try:
        clock.start()
        _advance(model, scene, recording, counts, clock, progress)
        return "finished", ""
    except SimulationFailure as failure:
        return failure.status, failure.reason
    except RequestError:
        raise
    except (ArithmeticError, LookupError, ValueError, TypeError, AttributeError, ContactlabError) as failure:
        return "failed", f"step {model.state.step}: {type(failure).__name__}: {failure}"
    finally:
        clock.stop()


def _advance(
    model: Model, scene: Any, recording: Recording, counts: Counts, clock: Clock, progress: Progress | None
) -> None:
    state, guards, schedule = model.state, Guards(model), Schedule(model, scene)
    advance = model.integrator.bind(model, state)
    recording.add(take_frame(model, 0, 0.0))
    began, swept = perf_counter(), 0
    while not schedule.done():
        step = advance(schedule.dt)
        if counts.steps == 0:
            clock.compile_s = perf_counter() - began
        counts.steps += 1
        counts.iterations += step.iterations
        counts.sweeps += step.sweeps
        guards.after_step(step)
        if counts.steps % EVERY == 0:
            guards.look()
            schedule.follow()
        if schedule.frame_due() or schedule.done():
            guards.look()
            frame = take_frame(model, len(recording.rows), (counts.sweeps - swept) / max(1, state.step - _last(recording)))
            swept = counts.sweeps
            recording.add(frame)
            if progress is not None:
                progress(schedule.fraction(), state.step, state.time, frame.energies["error"])
    schedule.verdict()


def _last(recording: Recording) -> int:
    return 0 if recording.last is None else recording.last.step
