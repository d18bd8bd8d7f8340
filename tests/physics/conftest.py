"""Runs that several tests look at are made once, whichever worker process asks first."""

from __future__ import annotations

import fcntl
import json
import os
import pickle
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import contactlab
from contactlab.api import StepStatus
from contactlab.model.build import build
from contactlab.model.memory import model_memory, restore_model
from contactlab.parts.registry import Registry, default_registry
from contactlab.results.results import ContactCurve
from contactlab.scene.scene import Scene

MORTARS = ("mortar-p0", "mortar-p1")
"""One code with two bases: a test of both runs with either by turns, and with both in the full tier."""

PERIODS = 15.0
"""Ramp of a run with a history in periods of its lowest mode: `auto` takes 100, these settle with 15."""


class Ran(NamedTuple):
    """What tests need of a run."""

    summary: dict[str, Any]
    curve: ContactCurve
    history: Mapping[str, Any]

    @property
    def status(self) -> str:
        return str(self.summary["status"])

    def reaction(self, support: str) -> tuple[float, float]:
        fx, fy = self.summary["reactions"][support]
        return float(fx), float(fy)


@pytest.hookimpl(tryfirst=True)  # before tests are left out by their marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark one of two tests that differ in the basis of the mortar alone as long."""
    here = {item.nodeid: item for item in items if item.path.is_relative_to(Path(__file__).parent)}
    others = {name: name.replace(*MORTARS) for name in here if MORTARS[0] in name}
    both = ((name, other) for name, other in others.items() if other in here)
    whole = [pair for pair in both if not any(here[name].get_closest_marker("full") for name in pair)]
    for turn, pair in enumerate(whole):
        here[pair[turn % 2]].add_marker("full")


Runs = Callable[..., Ran]


def short_ramp(scene: Scene) -> Scene:
    """The scene with a ramp of `PERIODS` of its own lowest mode; as it is in statics, and where `auto` is faster."""
    if scene.integrator["use"] == "newton":
        return scene
    model = build(scene, default_registry())
    return scene.with_({"time.ramp": PERIODS * model.timing.period}) if model.history else scene


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """runs(changes, auto=False): disc-on-block with these keys, computed once however many tests ask."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # common to all workers
    kept: dict[str, Ran] = {}

    def run(changes: Mapping[str, Any], auto: bool = False) -> Ran:
        key = f"{json.dumps(dict(changes), sort_keys=True)} {auto}"
        if key not in kept:
            kept[key] = _once(folder / f"run-{abs(hash_of(key)):x}", changes, auto)
        return kept[key]

    return run


def hash_of(key: str) -> int:
    """The same in every process, unlike `hash`."""
    return int.from_bytes(key.encode(), "big") % (2**61 - 1)


def _once(path: Path, changes: Mapping[str, Any], auto: bool) -> Ran:
    with path.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.exists():
            path.write_bytes(pickle.dumps(tuple(_run(changes, auto))))
        return Ran(*pickle.loads(path.read_bytes()))


def _run(changes: Mapping[str, Any], auto: bool) -> Ran:
    scene = contactlab.load_scene("disc-on-block").with_(changes)
    scene = scene.with_({"record.frames": 5})
    results = contactlab.simulate(scene if auto else short_ramp(scene))
    return Ran(results.summary, results.contact["contacts.0"].last, results.history)


@pytest.fixture
def taken_up() -> Callable[[Scene, Registry, float, int], tuple[Any, dict[str, Any]]]:
    """Make steps of a scene, take it up half-way by new parts, with steps that are rejected or taken back between.

    States are the same bits. Given are the model of the run as it was and its memory half-way.
    """

    def check(scene: Scene, registry: Registry, dt: float, steps: int) -> tuple[Any, dict[str, Any]]:
        model, use = build(scene, registry), scene.integrator["use"]
        bound, states = model.bound_integrator(), []
        for number in range(steps):
            if number == steps // 2:
                saved = {name: np.copy(values) for name, values in model_memory(model).items()}
            assert bound.step(dt).status is StepStatus.accepted
            states.append(model.state.snapshot())

        other = build(scene, registry)
        restore_model(other, saved)
        again = other.bound_integrator()
        for number in range(steps // 2, steps):
            before = {name: np.copy(values) for name, values in model_memory(other).items()}
            if use == "central-difference":
                again.step(0.5 * dt)
                restore_model(other, before)
            else:
                motion = again.advance.__self__  # type: ignore[attr-defined]
                iteration = (motion.statics if use == "newton" else motion.dynamics).iteration
                most, iteration.most = iteration.most, 1
                if again.step(1.7 * dt).status is StepStatus.accepted:  # an easy one: taken back by hand
                    restore_model(other, before)
                iteration.most = most
                np.testing.assert_array_equal(other.state.buffer, states[number - 1])
            assert again.step(dt).status is StepStatus.accepted
            np.testing.assert_array_equal(other.state.buffer, states[number])
        return model, saved

    return check
