"""Which forces explicit contact takes, and that the short ways to conjugate ones lead where the long one does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.explain.explain import explain
from contactlab.model.build import build
from contactlab.model.contact.conjugate_system import ConjugateContactSystem
from contactlab.model.model import Model

FINE = {"bodies.block.mesh.cells": [72, 12]}  # 2.7 times shorter than the disc's


def model_of(changes: dict[str, Any], forces: str | None = None, name: str = "disc-on-block") -> Model:
    own = {"contacts.0.enforcement": {"use": "forward-increment", "forces": forces}} if forces else {}
    scene = contactlab.load_scene(name).with_(changes | own)
    return build(scene, scene.registry)


@pytest.mark.parametrize(
    ("changes", "forces", "conjugate"),
    [
        ({}, None, False),
        (FINE, None, True),
        (FINE, "published", False),
        ({}, "conjugate", True),
        (FINE | {"contacts.0.swap": True}, None, False),
        # half segments of quadratic edges count
        ({"bodies.block.element": "q2"}, None, True),
        ({"integrator.forces": "conjugate"}, None, True),
    ],
)
def test_forces_are_conjugate_where_a_master_is_much_finer(
    changes: dict[str, Any], forces: str | None, conjugate: bool
) -> None:
    contact = model_of(changes, forces).contact
    assert contact is not None
    assert isinstance(contact, ConjugateContactSystem) == contact.conjugate == conjugate


def test_a_master_that_cannot_move_has_no_waves() -> None:
    walls = {"rigid.box": {"line": [[-2.0, -2.0], [-2.0, 2.0], [2.0, 2.0], [2.0, -2.0], [-2.0, -2.0]], "segment": 0.01}}
    contact = model_of(walls, name="disc-in-box").contact
    assert contact is not None
    assert contact.finer == 0.0
    assert not contact.conjugate


@pytest.mark.parametrize(
    ("changes", "says"),
    [({}, "published; slave segments are 1.4 times"), (FINE, "conjugate; slave segments are 2.7 times")],
)
def test_explain_says_which(changes: dict[str, Any], says: str) -> None:
    scene = contactlab.load_scene("disc-on-block").with_(changes)
    assert explain(scene, scene.registry).scene.contact_forces.startswith(says)


@pytest.mark.parametrize("algorithm", ["node-on-segment", "mortar-p0"])
def test_short_ways_lead_where_full_rows_do(algorithm: str) -> None:
    """Of closest points by columns, of mortar methods by ends; 200 steps with contact from the first on."""
    short, full = (model_of({"contacts.0.algorithm": algorithm}, "conjugate") for _ in range(2))
    assert isinstance(short.contact, ConjugateContactSystem)
    assert isinstance(full.contact, ConjugateContactSystem)
    full.contact.told = full.contact.constant = full.contact.factored = None
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
    """As explicit runs with the same forces, 3899.28 N (test_conjugate_forces); published ones give 3896.2."""
    own = {
        "integrator": {"use": "newton", "steps": 5},
        "contacts.0.enforcement": {"use": "active-set", "forces": "conjugate"},
    }
    results = contactlab.simulate(contactlab.load_scene("disc-on-block").with_(FINE | own))
    assert results.status == "finished"
    assert results.summary["reactions"]["block.bottom"][1] == pytest.approx(3899.28, abs=0.02)
