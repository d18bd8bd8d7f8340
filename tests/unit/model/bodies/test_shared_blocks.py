"""Blocks that share their arrays show what blocks of their own would hold."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.api import Floats
from contactlab.model.bodies.body import BodyForces
from contactlab.model.build import build
from contactlab.model.memory import model_memory, restore_model
from contactlab.model.model import Model
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene

LAWS = {
    "linear-elastic": {},
    "neo-hookean": {},
    "hypoelastic": {},
    "linear-hardening": {"yield_stress": 0.002},
}


def stirred(law: str, steps: int = 12) -> Model:
    """Three blocks of cells in smooth, uneven motion, after some steps."""
    scene = Scene.from_data(
        {
            "name": "block",
            "time": {"end": 1.0, "step": 1e-3},
            "integrator": "central-difference",
            "materials": {"m": {"use": law, "young": 1.0, "poisson": 0.3, "density": 1.0, **LAWS[law]}},
            "bodies": {
                "b": {
                    "element": "q1",
                    "material": "m",
                    "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [50, 50]},
                }
            },
        }
    )
    model = build(scene, default_registry())
    x, y = model.reference.T
    model.state["velocity"][:] = np.stack([np.sin(3.0 * y), 0.5 * np.cos(2.0 * x)], axis=1)
    advance = model.bound_integrator().step
    for _ in range(steps):
        advance(1e-3)
    return model


def own(model: Model) -> tuple[Floats, Floats]:
    """Gradients and stresses of the last update as blocks of their own would hold them, by a run of trials."""
    forces = model.forces[0]
    assert len(forces.blocks) == 3
    gradients, stresses = [], []
    for block, scratch in zip(forces.blocks, forces.scratch, strict=True):
        # the update's own arrays, read right after it and before the next block overwrites them
        history = block.history.copy()
        forces._bind(block, scratch)(1e-3)
        gradients.append(block.gradient.copy())
        stresses.append(block.stress.copy())
        block.history[:] = history
    return np.concatenate(gradients, axis=1), np.concatenate(stresses, axis=1)


def seen(forces: BodyForces) -> tuple[Floats, Floats]:
    pairs = [(block.gradient.copy(), block.stress.copy()) for block in forces.current()]
    return np.concatenate([g for g, _ in pairs], axis=1), np.concatenate([s for _, s in pairs], axis=1)


@pytest.mark.parametrize("law", ["linear-elastic", "neo-hookean"])
def test_shared_arrays_are_renewed_to_the_bit(law: str) -> None:
    model = stirred(law)
    gradient, stress = seen(model.forces[0])
    expected_gradient, expected_stress = own(model)
    assert (gradient == expected_gradient).all()
    assert (stress == expected_stress).all()
    assert np.ptp(stress, axis=1).min() > 0.0  # uneven, so that blocks in the wrong place would show


@pytest.mark.parametrize("law", ["hypoelastic", "linear-hardening"])
def test_stresses_with_a_history_stay_where_they_are(law: str) -> None:
    model = stirred(law)
    forces = model.forces[0]
    assert len({id(block.stress) for block in forces.blocks}) == 3
    before = [block.stress.copy() for block in forces.blocks]
    history = forces.history.copy()
    gradient, _ = seen(forces)
    for block, stress in zip(forces.blocks, before, strict=True):
        assert (block.stress == stress).all()
    assert (forces.history == history).all()
    expected, _ = own(model)
    assert (gradient == expected).all()


@pytest.mark.parametrize("law", list(LAWS))
def test_a_restart_shows_the_same(law: str) -> None:
    model = stirred(law)
    memory = {name: array.copy() for name, array in model_memory(model).items()}
    other = stirred(law, steps=3)
    restore_model(other, memory)
    for mine, theirs in zip(seen(model.forces[0]), seen(other.forces[0]), strict=True):
        assert (mine == theirs).all()
