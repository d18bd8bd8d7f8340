"""Checks of watches: they change nothing, and keep their memory so that a restart finds it."""

from __future__ import annotations

import pickle
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api import Step, StepStatus, Watch
from contactlab.model.build import build
from contactlab.run.simulation import simulate
from contactlab.run.watches import Watching
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.assertions import Check, require

STEPS, DT = 60, 4e-8


def small_scene() -> Scene:
    """An arc that is pressed on a block and drawn aside, for a few steps: upper and lower."""
    scene = load_scene(Path(str(files("contactlab") / "data" / "checks" / "pressed.toml")))
    return scene.with_({"time.step": DT, "time.end": STEPS * DT})


def looks_only(watch: Watch) -> None:
    """A watched run is the same to the last bit as one that is not."""
    watched, plain = (simulate(small_scene(), watch=watches) for watches in ({"watch": watch}, {}))
    require(np.array_equal(watched.displacement, plain.displacement), "displacements differ when it looks")
    require(np.array_equal(watched.velocity, plain.velocity), "velocities differ when it looks")


def finds_arrays(watch: Watch) -> None:
    """Results are arrays by name, the same in a second run."""
    first, second = (simulate(small_scene(), watch={"watch": watch}).watched["watch"] for _ in range(2))
    require(len(first) > 0, "it found nothing in the run")
    for name, values in first.items():
        require(np.array_equal(values, second[name], equal_nan=True), f"{name} differs between two equal runs")


def remembers(watch: Watch) -> None:
    """Memory is the only state: restored in a new run half-way, the watch ends with the same numbers."""
    whole, parts = _stepped(watch, None), _stepped(watch, STEPS // 2)
    for name, values in whole.items():
        require(np.array_equal(values, parts[name], equal_nan=True), f"{name} differs after a restart")


def _stepped(watch: Watch, restart_at: int | None) -> dict[str, Any]:
    """Return what it found after some steps; at step `restart_at` its memory moves to another copy."""
    scene = small_scene()
    model = build(scene, scene.registry)
    advance, watching = model.bound_integrator().step, Watching(model, {"watch": watch})
    for number in range(STEPS):
        if number == restart_at:
            saved = {name: values.copy() for name, values in watching.saved().items()}
            watching = Watching(model, {"watch": pickle.loads(pickle.dumps(watch))})
            shapes = {name: values.shape for name, values in watching.saved().items()}
            require(shapes == {n: v.shape for n, v in saved.items()}, "shapes of its memory change while it runs")
            watching.restore(saved)
        step: Step = advance(DT)
        require(step.status is StepStatus.accepted, "the step was not accepted")
        for look in watching.every_step:
            look(step, DT)
    return watching.found()["watch"]


def writes_in_place(watch: Watch) -> None:
    """Steps write to the arrays that `begin` gave; a new array under the same name is not what a run saves."""
    scene = small_scene()
    model = build(scene, scene.registry)
    advance, watching = model.bound_integrator().step, Watching(model, {"watch": watch})
    memory = watching.saved()
    for _ in range(STEPS):
        step = advance(DT)
        for look in watching.every_step:
            look(step, DT)
    new = [name for name, values in watching.saved().items() if not np.shares_memory(values, memory[name])]
    require(not any(memory[name].size for name in new), f"{', '.join(new)}: another array, needed: values in place")


CHECKS: tuple[Check, ...] = (finds_arrays, looks_only, remembers, writes_in_place)
"""All checks of watches."""
