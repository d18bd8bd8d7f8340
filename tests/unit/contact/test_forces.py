"""Which forces explicit contact takes, and that the short ways to consistent ones lead where the long one does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.contact.consistent_system import ConsistentContactSystem
from contactlab.explanation.explain import explain
from contactlab.model.build import build
from contactlab.model.model import Model

FINE = {"bodies.block.mesh.cells": [72, 12]}  # 2.7 times shorter than the disc's


def model_of(changes: dict[str, Any], forces: str | None = None, name: str = "disc-on-block") -> Model:
    own = {"contacts.0.enforcement": {"use": "forward-increment", "forces": forces}} if forces else {}
    scene = contactlab.load_scene(name).with_(changes | own)
    return build(scene, scene.registry)


@pytest.mark.parametrize(
    ("name", "changes", "consistent"),
    [
        ("dropped-block", {}, True),
        ("disc-on-block", {}, False),  # the paper's, which says so
        ("disc-on-block", {"integrator.forces": "auto"}, True),
        *(("disc-on-block", {"integrator.forces": key}, True) for key in ("consistent", "consistent")),
        *(("dropped-block", {"integrator.forces": key}, False) for key in ("frozen", "published")),
        # the contact's own key decides
        ("disc-on-block", {"contacts.0.enforcement": "forward-increment"}, True),
        ("dropped-block", {"contacts.0.enforcement": {"use": "forward-increment", "forces": "frozen"}}, False),
    ],
)
def test_forces_are_consistent_unless_a_scene_says_otherwise(
    name: str, changes: dict[str, Any], consistent: bool
) -> None:
    contact = model_of(changes, name=name).contact
    assert contact is not None
    assert isinstance(contact, ConsistentContactSystem) == contact.consistent == consistent
    scene = contactlab.load_scene(name).with_(changes)
    assert explain(scene, scene.registry).scene.contact_forces == ("consistent" if consistent else "frozen")


@pytest.mark.parametrize(("integrator", "in_time"), [("newton", False), ("implicit-dynamics", True)])
@pytest.mark.parametrize(("forces", "consistent"), [("auto", None), ("consistent", True), ("frozen", False)])
def test_steps_that_iterate_are_consistent_in_time(
    integrator: str, in_time: bool, forces: str, consistent: bool | None
) -> None:
    changes = {"integrator": integrator, "contacts.0.enforcement": {"use": "active-set", "forces": forces}}
    contact: Any = model_of(changes | {"time.end": 1e-3}).contact
    assert contact.consistent == (in_time if consistent is None else consistent)


@pytest.mark.parametrize("algorithm", ["node-on-segment", "mortar-p0"])
def test_short_ways_lead_where_full_rows_do(algorithm: str) -> None:
    """Of closest points by columns, of mortar methods by ends; 200 steps with contact from the first on."""
    short, full = (model_of({"contacts.0.algorithm": algorithm}, "consistent") for _ in range(2))
    assert isinstance(short.contact, ConsistentContactSystem)
    assert isinstance(full.contact, ConsistentContactSystem)
    full.contact.reduced, full.contact.factored = (), None
    for model in (short, full):
        advance, dt = model.bound_integrator().step, 0.9 * model.stable_step()
        for _ in range(200):
            advance(dt)
    assert short.contact.factored is not None
    assert short.contact.factored.count > 0
    assert full.contact.rows.count > 0
    assert short.state["multipliers"].max() > 0.0
    largest = np.abs(short.state["displacement"]).max()
    # both solve to 1e-10 of a segment; by ends the stretch of the slave is left out, 1e-4 of the rest
    atol = 1e-4 if algorithm == "mortar-p0" else 1e-9
    np.testing.assert_allclose(
        short.state["displacement"] / largest, full.state["displacement"] / largest, rtol=0.0, atol=atol
    )


def test_newton_pushes_along_derivatives_of_gaps() -> None:
    """As explicit runs with the same forces, 3899.28 N (test_consistent_forces); frozen ones give 3896.2."""
    own = {
        "integrator": {"use": "newton", "steps": 5},
        "contacts.0.enforcement": {"use": "active-set", "forces": "consistent"},
    }
    results = contactlab.simulate(contactlab.load_scene("disc-on-block").with_(FINE | own))
    assert results.status == "finished"
    assert results.summary["reactions"]["block.bottom"][1] == pytest.approx(3899.28, abs=0.02)
