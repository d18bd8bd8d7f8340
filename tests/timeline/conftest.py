"""Small runs that take a fraction of a second, with files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactlab.api.recorder import Recorder
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

# the bundled scene on a coarse mesh: about 125 steps; contact begins with the first
SMALL = {
    "bodies.disc.mesh.cells": [8, 2],
    "bodies.block.mesh.cells": [12, 2],
    "time.end": 2e-6,
    "record.frames": 10,
    "record.last": 0,  # no frames beside these
    "record.recorders": ["vtkhdf"],
}

MakeScene = Callable[..., Scene]


@pytest.fixture(scope="session")
def small_scene() -> MakeScene:
    """small_scene({"contacts.0.algorithm": ...}): the small scene with changes."""

    def make(changes: dict[str, object] | None = None) -> Scene:
        return load_scene("disc-on-block", default_registry()).with_({**SMALL, **(changes or {})})

    return make


@pytest.fixture(scope="session")
def recorded(small_scene: MakeScene, tmp_path_factory: pytest.TempPathFactory) -> Results:
    """A finished run with friction, whose files are there; nobody may change them."""
    folder: Path = tmp_path_factory.mktemp("recorded") / "run"
    return simulate(small_scene({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}), out=folder)


@pytest.fixture(scope="session")
def recorder() -> Callable[[str], Recorder]:
    """recorder("vtkhdf"): an installed recorder with its defaults."""
    return lambda name: default_registry().make("recorder", name)


@pytest.fixture(scope="session")
def assert_same_run() -> Callable[[Results, Results], None]:
    """Are two runs the same to the last bit, whatever they cost?"""
    return _assert_same_run


@pytest.fixture(scope="session")
def assert_same_files() -> Callable[[Path, Path], None]:
    """Are the text files of two runs the same to the last byte?"""
    return _assert_same_files


def _assert_same_run(a: Results, b: Results) -> None:
    """Everything but cost and the steps at which a run was taken up."""
    assert _without_cost(a.summary) == _without_cost(b.summary)
    for name in ("displacement", "velocity"):
        assert np.array_equal(getattr(a, name), getattr(b, name)), name
    _assert_same_arrays(a.history, b.history)
    _assert_same_arrays(a.stress, b.stress)
    assert a.internal_variables.keys() == b.internal_variables.keys()
    for body, fields in a.internal_variables.items():
        _assert_same_arrays(fields, b.internal_variables[body])
    for contact, history in a.contact.items():
        assert history.times == b.contact[contact].times
        assert history.curves == b.contact[contact].curves
        assert history.steps.tobytes() == b.contact[contact].steps.tobytes()
    assert list(a.events) == list(b.events)
    assert list(a.iterations) == list(b.iterations)
    _assert_same_arrays(_steps(a), _steps(b))
    _assert_same_frames(a, b)


def _assert_same_files(a: Path, b: Path) -> None:
    """The text files are the same to the last byte."""
    for name in ("history.csv", "contact.csv", "scene.toml"):
        assert (a / name).read_bytes() == (b / name).read_bytes(), name
    assert (a / "iterations.csv").is_file() == (b / "iterations.csv").is_file()
    if (a / "iterations.csv").is_file():
        assert (a / "iterations.csv").read_bytes() == (b / "iterations.csv").read_bytes()


def _without_cost(summary: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in summary.items() if name not in ("cost", "resumed_at_steps")}


def _steps(results: Results) -> dict[str, Any]:
    return {name: values for name, values in results.steps.items() if not name.startswith("cost.")}


def _assert_same_arrays(a: Any, b: Any) -> None:
    assert a.keys() == b.keys()
    for name, values in a.items():
        assert np.array_equal(values, b[name], equal_nan=True), name


def _assert_same_frames(a: Results, b: Results) -> None:
    assert len(a.frames) == len(b.frames)
    for one, other in zip(a.frames, b.frames, strict=True):
        assert (one.number, one.step, one.time) == (other.number, other.step, other.time)
        assert np.array_equal(one.displacement, other.displacement)
        assert np.array_equal(one.velocity, other.velocity)
        for body, fields in one.cells.items():
            _assert_same_arrays(fields, other.cells[body])
