"""Integrators of third parties in whole runs: right ones run with contact, others are refused or stopped by name."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from from_source import subject_of

from contactlab import load_scene, simulate
from contactlab.api import Step
from contactlab.cli import main
from contactlab.errors import SimulationFailure
from contactlab.model.build import build

PLAIN = "integrator outside plain-leapfrog/src/plain_leapfrog/integrator.py:PlainLeapfrog"
SMALL: dict[str, Any] = {
    "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.end": 3e-6, "record.frames": 3,
    "record.recorders": [],
}  # fmt: skip


def run(changes: dict[str, Any], folder: Path, *pieces: str, shipped: bool = False) -> Any:
    """By the outside leapfrog with pieces of its source exchanged, or by the shipped one."""
    registry = subject_of(PLAIN, folder, pieces).registry
    integrator = "central-difference" if shipped else "strange"
    scene = load_scene("disc-on-block", registry=registry)
    return simulate(scene.with_({**SMALL, **changes, "integrator": integrator}))


@pytest.mark.parametrize(
    "changes",
    [
        {"contacts.0.algorithm": "mortar-p1"},
        {"contacts.0.algorithm": "mortar-p0", "contacts.0.friction": {"use": "coulomb", "mu": 0.3}},
        {"contacts.0.algorithm": "node-on-segment", "contacts.0.swap": True, "materials.soft.use": "hypoelastic"},
    ],
    ids=["mortar", "friction", "rate"],
)
def test_a_leapfrog_in_numpy_runs_like_the_shipped_one(changes: dict[str, Any], tmp_path: Path) -> None:
    changes = changes | {"contacts.0.enforcement": {"use": "forward-increment", "forces": "frozen"}}
    own, shipped = (run(changes, tmp_path, shipped=shipped) for shipped in (False, True))
    assert own.status == shipped.status == "finished", own.reason
    assert own.summary["steps"] == shipped.summary["steps"] > 100
    assert shipped.history["contacts.0.max_pressure"][-1] > 0.0
    largest = np.abs(shipped.history["disc.top.fy"]).max()
    for name, values in shipped.history.items():
        if name in ("energy.error", "sweeps"):
            continue
        # the same operations in another order: round-off that contact passes on for some hundred steps
        size = largest if name.endswith((".fx", ".fy")) else np.nanmax(np.abs(values), initial=1e-12)
        assert np.allclose(own.history[name], values, rtol=0.0, atol=1e-8 * size, equal_nan=True), name
    assert own.history["energy.error"].max() < 1e-9
    assert own.summary["reactions"].keys() == shipped.summary["reactions"].keys()


END = "return Step(work, reaction)"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (END, f'self.state["clock"][:2] += dt, 1.0\n        {END}', "step 1: PlainLeapfrog: its step wrote the clock"),
        (END, "return None", "step 1: PlainLeapfrog: its step gave NoneType, needed: Step"),
        (END, "return Step(None, reaction)", "its step was accepted and gave no work, needed: Step(work=...)"),
        (END, "return Step(work[:5], reaction)", "PlainLeapfrog: its step gave work of shape (5,), needed: (7,)"),
        (END, "return Step(work, None)", "its step was accepted and gave no reaction, needed: Step(reaction=...)"),
        (END, "return Step(work, reaction, StepStatus.gave_up)", "step 0: the shortest step failed"),
        (
            "v += compliance * force / dt",
            'state["displacement"][:] += compliance * force',
            "contact forces are unbounded",
        ),
    ],
)
def test_what_breaks_the_contract_ends_the_run_by_name(old: str, new: str, words: str, tmp_path: Path) -> None:
    pieces = old, new, "State, Step\n", "State, Step, StepStatus\n"
    ended = run({"contacts.0.algorithm": "mortar-p1"}, tmp_path, *pieces)
    assert ended.status in ("failed", "diverged")
    assert words in ended.reason


@pytest.mark.parametrize("dt", [0.0, 1e-30, float("nan"), float("inf"), -1.0])
def test_a_clock_that_stands_ends_the_run(dt: float) -> None:
    """A step below the round-off of time, or that is no number, would let a run go on for ever."""
    scene = load_scene("disc-on-block").with_(SMALL)
    model = build(scene, scene.registry)
    integrator = model.bound_integrator()
    for _ in range(3):
        assert type(integrator.step(1e-9)) is Step
    before = model.state.snapshot()
    with pytest.raises(SimulationFailure, match=r"step 3: the clock stands at 3e-09 s"):
        integrator.step(dt)
    assert np.array_equal(model.state.buffer, before)


VERSION_1 = """
    from dataclasses import dataclass
    from typing import ClassVar

    from contactlab.api import ExplicitEnforcement, Integrator
    from contactlab.api.plugin import Part, hookimpl

    @dataclass(frozen=True)
    class Old(Integrator):
        needs: ClassVar[type] = ExplicitEnforcement
        default_enforcement: ClassVar[str] = "forward-increment"
        order: ClassVar[int] = 2
        inertia: ClassVar[bool] = True
        explicit: ClassVar[bool] = True

        def bind(self, equations, state):
            return lambda dt: None

    @hookimpl
    def contactlab_parts():
        return [Part("integrator", "old", "FILE:Old", "of version 1" API)]
"""


@pytest.mark.parametrize(
    ("api", "words"),
    [
        (", api=1", "it is written for version 1 of the contract, this is version 2; to change: derive from Explicit"),
        ("", "does not derive from contactlab.api.ExplicitIntegrator or contactlab.api.ImplicitIntegrator; to change:"),
    ],
    ids=["says so", "does not say so"],
)
def test_a_part_of_version_1_is_refused_with_what_to_change(
    api: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / f"old{len(api)}.py"
    file.write_text(textwrap.dedent(VERSION_1).replace("FILE", file.stem).replace(" API", api))
    command = ["run", "disc-on-block", "--with", str(file), "--set", "integrator=old", "--out", str(tmp_path / "run")]
    assert main(command) == 2
    shown = " ".join(capsys.readouterr().err.split())
    assert words in shown
    assert "give work and reaction in every accepted Step" in shown
    assert "Traceback" not in shown
