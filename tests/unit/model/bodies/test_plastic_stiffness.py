"""The stiffness of plastic bodies follows the plastic branch, however little they have flowed in a load step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contactlab.model.build import build
from contactlab.scene.scene import Scene

LAW = {"use": "power-law", "young": 70000.0, "poisson": 0.3, "density": 2.7e-9, "strength": 348.0, "prestrain": 0.02,
       "exponent": 0.03}  # fmt: skip
STRETCH, MORE, PROBE = 0.02, 1e-8, 1e-9  # of the block: far beyond yield, in a last step, to try the stiffness


def block(element: str) -> Any:
    """The model of a block of unequal cells."""
    mesh = {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [3, 2], "grading": [1.5, 1.5]}
    scene = Scene.from_data(
        {
            "time": {"end": 1.0},
            "integrator": "newton",
            "materials": {"metal": LAW},
            "bodies": {"block": {"element": element, "material": "metal", "mesh": mesh}},
            "supports": [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
        }
    )
    return build(scene, scene.registry)


@pytest.mark.parametrize("element", ["q1", "q1-fbar", "q1-reduced"])
def test_it_is_the_derivative_of_forces_that_go_on_loading(element: str) -> None:
    """Central differences of stresses gave the mean of both branches, half of the elastic stiffness."""
    model = block(element)
    x = model.reference
    # all points go on being stretched, each by another amount
    field = np.stack([-0.3 * x[:, 0] * (1.0 + x[:, 1]), x[:, 1] * (1.0 + 0.2 * x[:, 0])], axis=1)

    def forces(share: float) -> Any:
        model.state["displacement"][:] = share * field
        model.internal_force(1.0)
        return model.state["internal_force"].copy()

    forces(STRETCH)
    model.accept()
    before = forces(STRETCH + MORE)
    predicted = (model.stiffness(1.0) @ field.ravel()).reshape(before.shape)
    found = (forces(STRETCH + MORE + PROBE) - before) / PROBE
    # forces of 300 N have 13 digits left in the difference's 4e-5 N: 1e-6; elastic is 20 times stiffer than plastic
    np.testing.assert_allclose(predicted, found, atol=1e-4 * np.abs(found).max(), rtol=0.0)
    elastic = forces(1e-5) / 1e-5
    assert np.abs(found).max() < 0.5 * np.abs(elastic).max()  # or the test says nothing
