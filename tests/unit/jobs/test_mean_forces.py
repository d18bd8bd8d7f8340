"""Means in time of forces: those of all steps, not of the stored frames."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab import load_scene
from contactlab.api import Job
from contactlab.jobs.mean_forces import MEANS
from contactlab.jobs.perform import made
from contactlab.model.build import build
from contactlab.scene.scene import Scene

MASS = 8.0 * 6.0 * 1e-9  # t, of a thickness of 1 mm
SPEED = np.array([300.0, -4000.0])


def bouncing(swap: bool = False) -> Scene:
    """A soft block that bounces off a block which nothing holds, with friction."""
    soft = {"use": "neo-hookean", "young": 50.0, "poisson": 0.3, "density": 1e-9}

    def block(y: float, **rest: object) -> dict[str, object]:
        mesh = {"use": "rectangle", "x": [0.0, 8.0], "y": [y, y + 6.0], "cells": [6, 4]}
        return {"element": "q1", "material": "soft", "mesh": mesh, **rest}

    return Scene.from_data(
        {
            "format": 1, "name": "bouncing", "time": {"end": 4e-4}, "integrator": "central-difference",
            "materials": {"soft": soft}, "record": {"frames": 3, "recorders": []},
            "bodies": {"upper": block(0.3, velocity=SPEED.tolist()), "lower": block(-6.0)},
            "contacts": [{
                "slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p1",
                "friction": {"use": "coulomb", "mu": 0.1}, "swap": swap,
            }],
        },
        registry=load_scene("disc-on-block").registry,
    )  # fmt: skip


@pytest.mark.parametrize("swap", [False, True])
def test_a_mean_force_is_the_change_of_momentum_over_the_time(swap: bool) -> None:
    """Explicit steps conserve the momentum of each body but for contact; velocities are half a step behind positions.

    To round-off if nothing is pressed at the end: the last half step has no force then.
    """
    scene = bouncing(swap)
    record = made(Job("bounce", "", means=True, fields=True), scene)
    assert record.finished, record.reason
    model = build(scene, scene.registry)
    (upper,) = (slice(body.first, body.first + body.count) for body in model.bodies if body.name == "upper")
    velocity = np.asarray(record.velocity)[upper]
    change = (model.mass[upper, None] * (velocity - SPEED)).sum(axis=0)
    mean = record.watched[MEANS]["contact"][0] * (-1.0 if swap else 1.0)
    assert change[1] > 0.2 * MASS * 4000.0
    np.testing.assert_allclose(mean * record.summary["reached"]["time"], change, rtol=0.0, atol=1e-12 * abs(change[1]))
    np.testing.assert_array_equal(record.watched[MEANS]["reaction"], 0.0)
