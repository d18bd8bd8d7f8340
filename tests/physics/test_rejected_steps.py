"""Steps taken back on purpose at random moments: the continuation is that of an undisturbed run, bit for bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.api import Floats, Integrator, StepStatus
from contactlab.model.build import build
from contactlab.model.memory import model_memory, restore_model
from contactlab.model.model import Model
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

ALGORITHMS = pytest.mark.parametrize("algorithm", ["node-on-segment", "mortar-p0", "mortar-p1"])
STEPS = 6


def pressed(algorithm: str, integrator: dict[str, Any], law: dict[str, Any]) -> Scene:
    """A disc pushed into a block with friction; laws with history below and above."""
    material = {"young": 7000.0, "poisson": 0.3, "density": 2.7e-9}
    return contactlab.load_scene("disc-on-block").with_(
        {
            "level": 1,
            "integrator": integrator,
            "time.end": 4e-6,
            "materials.soft": material | law,
            "materials.steel": {"use": "hypoelastic", "young": 70000.0, "poisson": 0.3, "density": 2.7e-9},
            "supports.1.uy.to": -0.03,
            "contacts.0.algorithm": algorithm,
            "contacts.0.friction": {"use": "coulomb", "mu": 0.2},
        }
    )


def undisturbed(scene: Scene, dt: float, steps: int) -> list[Floats]:
    """The state after every step."""
    model = build(scene, scene.registry)
    advance, states = model.bound_integrator().step, []
    for _ in range(steps):
        assert advance(dt).status is StepStatus.accepted
        states.append(model.state.snapshot())
    return states


EACH = [
    (name, use) for name in ("mortar-p0", "mortar-p1", "node-on-segment") for use in ("newton", "implicit-dynamics")
]


@pytest.mark.parametrize(
    ("algorithm", "use"), some(EACH, [("mortar-p1", "newton"), ("node-on-segment", "implicit-dynamics")])
)
def test_steps_that_fail(algorithm: str, use: str) -> None:
    """Failing for want of iterations, for too long a step, and after its iteration has begun to converge."""
    law = {"use": "power-law", "strength": 348.0, "prestrain": 0.02, "exponent": 0.03}
    # each step is as long as it is asked to be, also where nodes meet
    scene = pressed(algorithm, {"use": use} | ({"impacts": False} if use == "implicit-dynamics" else {}), law)
    dt = 4e-6 / STEPS
    expected = undisturbed(scene, dt, STEPS)
    model, draw = build(scene, scene.registry), np.random.default_rng(hash_of(algorithm))
    bound = model.bound_integrator()
    advance, motion = bound.step, bound.advance.__self__  # type: ignore[attr-defined]
    iteration = (motion.statics if use == "newton" else motion.dynamics).iteration
    moments, failed = draw.integers(0, STEPS, 4), 0
    for number, wanted in enumerate(expected):
        for moment in moments[moments == number]:
            before = model.state.snapshot()
            most, iteration.most = iteration.most, int(draw.integers(1, 4))
            step = advance(dt * (1.0 if moment % 2 else 1.7))
            iteration.most = most
            if step.status is StepStatus.accepted:  # an easy one: taken back by hand instead
                model.state.restore(before)
            else:
                failed += 1
                assert_constraints_of_positions(model)
            np.testing.assert_array_equal(model.state.buffer, before)
        assert advance(dt).status is StepStatus.accepted
        np.testing.assert_array_equal(model.state.buffer, wanted)
    assert failed >= 2


def assert_constraints_of_positions(model: Model) -> None:
    """No constraint of a trial is left: reports show those of the present positions."""
    assert model.contact is not None
    (pair,) = model.contact.pairs
    seen = pair.snapshot(model.state, model.position)
    pair.update(model.position, pair.memory_in(model.state).copy())
    again = pair.snapshot(model.state, model.position)
    for name in ("gaps", "normals", "cover", "tractions"):
        np.testing.assert_array_equal(getattr(seen, name), getattr(again, name), err_msg=name)


def hash_of(text: str) -> int:
    return int.from_bytes(text.encode(), "big") % (2**31)


@ALGORITHMS
def test_explicit_steps_taken_back(algorithm: str) -> None:
    """They never fail by themselves: some are tried twice as long, and taken back with all that a restart keeps."""
    law = {"use": "power-law", "strength": 348.0, "prestrain": 0.02, "exponent": 0.03}
    scene = pressed(algorithm, {"use": "central-difference"}, law)
    model = build(scene, scene.registry)
    dt, steps = 0.4 * model.stable_step(), 300
    expected = undisturbed(scene, dt, steps)
    advance, draw = model.bound_integrator().step, np.random.default_rng(1)
    moments = set(draw.integers(0, steps, 20).tolist())
    for number, wanted in enumerate(expected):
        if number in moments:
            memory = {name: np.copy(values) for name, values in model_memory(model).items()}
            for _ in range(int(draw.integers(1, 4))):
                advance(2.0 * dt)
            restore_model(model, memory)
        advance(dt)
        assert_same(model, wanted)


def assert_same(model: Model, wanted: Floats) -> None:
    np.testing.assert_array_equal(model.state.buffer, wanted)


def test_every_integrator_is_among_these() -> None:
    registry = contactlab.load_scene("disc-on-block").registry
    names = {
        name for name in registry.names("integrator") if issubclass(registry.part_class("integrator", name), Integrator)
    }
    assert names == {"newton", "implicit-dynamics", "central-difference"}


def test_a_load_step_that_ends_among_turned_cells_is_cut() -> None:
    """A wedge under a block: Newton's method finds a state with cells of the block turned over at their corners.

    It is an equilibrium, with 250 times the energy that the supports have supplied. The force of the slave
    that does not get there is the right one; they differ as much as two mortars do. F/N is tan(beta + phi) either way.
    """
    angle, mu, width = np.radians(10.0), 0.1, 2.0
    slope = float(np.tan(angle))
    top = width + 12.0 * slope
    blocks = {
        "wedge": (210000.0, [[-width, 0.0], [width, 0.0], [top, 12.0], [-top, 12.0]], [2, 14]),
        "block": (2000.0, [[width, 0.0], [16.0, 0.0], [16.0, 8.0], [width + 8.0 * slope, 8.0]], [4, 9]),
    }
    law = {"use": "neo-hookean", "poisson": 0.3, "density": 1e-9}
    scene = Scene.from_data(
        {
            "integrator": {"use": "newton", "steps": 10},
            "materials": {name: {**law, "young": young} for name, (young, _, _) in blocks.items()},
            "bodies": {
                name: {
                    "element": "q1",
                    "material": name,
                    "mesh": {"use": "quad-block", "corners": corners, "cells": cells},
                }
                for name, (_, corners, cells) in blocks.items()
            },
            "contacts": [
                {
                    "slave": "wedge.right",
                    "master": "block.left",
                    "algorithm": "mortar-dual",
                    "friction": {"use": "coulomb", "mu": mu},
                }
            ],
            "supports": [
                {"on": "block.right", "ux": 0.0, "uy": 0.0},
                {"on": "wedge.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -1.5}},
            ],
        }
    )
    dual, other = (simulate(scene.with_({"contacts.0.algorithm": use})) for use in ("mortar-dual", "mortar-p1"))
    assert dual.status == "finished", dual.reason
    force, expected = (np.abs(r.summary["reactions"]["block.right"]) for r in (dual, other))
    assert np.allclose(force, expected, rtol=2e-3)  # 166 N instead of 293 among turned cells
    # the flank turns by some 1e-3 as the wedge gives way, a hundredth of the block's strain of 5 %
    assert force[1] / force[0] == pytest.approx(np.tan(angle + np.arctan(mu)), rel=5e-3)


def test_bodies_that_are_unloaded_are_judged_by_what_they_gave_back() -> None:
    """A neo-hookean block pressed by half and let go: the trapezoid of its forces is off by a share of what it held.

    Uniform stress but for the held ends; the end stores nothing, and any error is large against that.
    """
    scene = Scene.from_data(
        {
            "integrator": {"use": "newton", "steps": 2},
            "time": {"history": True},
            "materials": {"rubber": {"use": "neo-hookean", "young": 10.0, "poisson": 0.3, "density": 1e-9}},
            "bodies": {
                "block": {
                    "element": "q1",
                    "material": "rubber",
                    "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [2, 2]},
                }
            },
            "supports": [
                {"on": "block.bottom", "ux": 0.0, "uy": 0.0},
                {
                    "on": "block.top",
                    "ux": 0.0,
                    "uy": {"ramp": "table", "to": -0.5, "points": [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]},
                },
            ],
        }
    )
    results = simulate(scene)
    assert results.status == "finished", results.reason
    assert not any("rejected" in event.text for event in results.events)
    # equilibrium to 1e-8 of the largest force, which is about that of the pressed block
    assert np.abs(results.summary["reactions"]["block.top"]).max() < 1e-6
