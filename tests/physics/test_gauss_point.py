"""Gauss-point-to-segment contact where it meets mortars; its patch tests are among those of statics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.kernels.contact.pair import FAR
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

SWAP = pytest.mark.parametrize("swap", [False, True])
STATIC: dict[str, Any] = {"integrator": {"use": "newton", "steps": 3}, "supports.1.uy.to": -0.02}


def disc(algorithm: str | dict[str, Any], **changes: Any) -> Results:
    """The disc pressed 0.02 mm into the block, with coarse cells."""
    scene = load_scene("disc-on-block").with_({"level": 1, "record.recorders": [], **STATIC, **changes})
    results = simulate(scene.with_({"contacts.0.algorithm": algorithm}))
    assert results.status == "finished"
    return results


def force(results: Results) -> float:
    return float(abs(results.history["contacts.0.fy"][-1]))


@pytest.mark.parametrize("swap", some([False, True], [True]))
def test_forces_on_a_disc_are_those_of_a_mortar(swap: bool) -> None:
    """A sum in place of an integral, on the same surfaces: within a fifth of what the mesh errs by, 1.5 %."""
    points, mortar = (disc(name, **{"contacts.0.swap": swap}) for name in ("gauss-point", "mortar-p1"))
    assert force(points) == pytest.approx(force(mortar), rel=3e-3)
    assert points.summary["iterations"] <= mortar.summary["iterations"] + 3


def test_forces_with_quadratic_cells_and_friction_are_those_of_a_mortar() -> None:
    """One with multipliers at all nodes of an edge, too."""
    quadratic = {f"bodies.{body}.element": "q2" for body in ("disc", "block")}
    changes = {**quadratic, "contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
    points, mortar = disc("gauss-point", **changes), disc({"use": "mortar-p1", "multipliers": "nodes"}, **changes)
    assert force(points) == pytest.approx(force(mortar), rel=3e-3)


def test_penalties_lead_to_the_multipliers() -> None:
    """What surfaces overlap by goes with one over the stiffness, and so does what the force lacks."""
    exact = force(disc("gauss-point"))
    lacking = [
        1.0 - force(disc("gauss-point", **{"contacts.0.enforcement": {"use": "penalty", "factor": factor}})) / exact
        for factor in (100.0, 1000.0)
    ]
    assert 0.0 < lacking[1] < lacking[0] < 0.02
    assert lacking[0] / lacking[1] == pytest.approx(10.0, rel=0.1)


def test_explicit_steps_give_the_mean_force_of_a_mortar_and_make_no_energy() -> None:
    """The same waves through the same cells: within 3 % of the mean force, whose bounces are sampled at 51 times."""
    pushed = {"use": "forward-increment", "forces": "consistent"}
    explicit = {"integrator": "central-difference", "time.end": 1e-6, "contacts.0.enforcement": pushed}
    points, mortar = (disc(name, **explicit) for name in ("gauss-point", "mortar-p1"))
    found, expected = (results.history["contacts.0.fy"].mean() for results in (points, mortar))
    assert found == pytest.approx(expected, rel=0.03)
    made = points.history["energy.contact"].max()  # impacts take energy, and give none beyond round-off
    assert made < 1e-12 * np.abs(points.history["energy.external"]).max()


def test_flanks_of_a_disc_have_no_condition() -> None:
    """The gap counts along the normal of the slave: at half the height of a disc it is none, however high that is."""
    scene = Scene.from_data({
        "time": {"end": 1e-3}, "integrator": "central-difference",
        "materials": {"m": {"use": "neo-hookean", "young": 1.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {"disc": {"element": "q1", "material": "m", "shift": [0.0, 10.0],
                            "mesh": {"use": "disc", "radius": 10.0, "cells": [8, 2]}}},
        "rigid": {"floor": {"line": [[60.0, 0.0], [-40.0, 0.0]], "segment": 10.0}},
        "contacts": [{"slave": "disc.arc", "master": "floor", "algorithm": "gauss-point"}],
        "record": {"frames": 1, "recorders": []},
    })  # fmt: skip
    model = build(scene, default_registry())
    pair = model.contact.pairs[0]
    pair.update(model.reference, np.zeros((pair.method.memory_size, len(pair.slave.nodes))))
    held = pair.gaps[:, 0] < FAR
    height = model.reference[pair.slave.nodes, 1]
    assert held[height < 0.5].all()
    # from a cosine of 0.2 between the normals of both sides on, and half a segment of 1.96 beside
    assert not held[height > 10.0 * (1.0 - 0.2) + 1.96].any()
