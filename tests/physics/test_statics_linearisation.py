"""Derivatives of gaps, slips and contact forces against differences of the conditions themselves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP1

import contactlab
from contactlab.api import Candidates, ContactAlgorithm, ContactView, Floats, Pieces, Surface
from contactlab.model.build import build
from contactlab.model.implicit_model import ImplicitModel
from contactlab.testing.contact_derivatives import against_differences, answers_of


@dataclass(frozen=True)
class Foreign(ContactAlgorithm):
    """Mortar contact of somebody who gives no derivatives."""

    passes_patch_test: ClassVar[bool] = True

    def widths(self, slave: Surface, master: Surface) -> tuple[int, int, int]:
        return MortarP1().widths(slave, master)

    def capacity(self, slave: Surface, near: Candidates) -> int:
        return MortarP1().capacity(slave, near)

    def pieces(self, view: ContactView, out: Pieces) -> int:
        return MortarP1().pieces(view, out)


def pressed_model(changes: dict[str, Any], shake: float = 1.0) -> tuple[ImplicitModel, Floats]:
    """Disc pressed into the block by 0.05 mm with all nodes shaken, so that nothing is symmetric, and positions."""
    scene = contactlab.load_scene("disc-on-block").with_({"integrator": "newton", "level": 1} | changes)
    model = build(scene, scene.registry)
    assert isinstance(model, ImplicitModel)
    assert model.contact is not None
    draw, disc = np.random.default_rng(1), slice(0, model.bodies[0].count)
    sizes = (3e-3 * shake, 2e-3 * shake)
    start, end = (model.reference + draw.uniform(-size, size, model.reference.shape) for size in sizes)
    start[disc, 1] -= 0.045
    end[disc, 1] -= 0.05
    model.contact.begin_step(start, 0.0)
    return model, end


CASES = {
    "mortar-p0": {"contacts.0.algorithm": "mortar-p0"},
    "mortar-p1": {"contacts.0.algorithm": "mortar-p1"},
    "mortar-dual": {"contacts.0.algorithm": "mortar-dual"},
    "node-on-segment": {"contacts.0.algorithm": "node-on-segment"},
    "q2": {"contacts.0.algorithm": "mortar-p1", "bodies.disc.element": "q2", "bodies.block.element": "q2"},
    "q2-p0": {"contacts.0.algorithm": "mortar-p0", "bodies.disc.element": "q2", "bodies.block.element": "q2"},
    "q2-nodes": {
        "contacts.0.algorithm": {"use": "mortar-p1", "multipliers": "nodes"},
        "bodies.disc.element": "q2",
        "bodies.block.element": "q2",
    },
    "foreign": {"contacts.0.algorithm": "mortar-p1"},
    "vertices": {"contacts.0.algorithm": "mortar-p0"},
    "smooth-p0": {"contacts.0.algorithm": "mortar-p0", "contacts.0.smooth": True},
    "smooth-dual": {"contacts.0.algorithm": "mortar-dual", "contacts.0.smooth": True},
}
# shaken so much that the slave has vertices, whose normals are the master's; these come by differences
ROUGH = {"vertices": 3.0}


@pytest.mark.parametrize("friction", [False, True], ids=["frictionless", "friction"])
@pytest.mark.parametrize("swap", [False, True], ids=["disc-slave", "block-slave"])
@pytest.mark.parametrize("name", CASES)
def test_derivatives(name: str, swap: bool, friction: bool) -> None:
    changes: dict[str, Any] = CASES[name] | {"contacts.0.swap": swap}
    if friction:
        changes["contacts.0.friction"] = {"use": "coulomb", "mu": 0.3}
    model, position = pressed_model(changes, ROUGH.get(name, 1.0))
    contact = model.contact
    assert contact is not None
    if name == "foreign":
        contact.pairs[0].algorithm = Foreign()
    contact.evaluate(position)
    c, draw = contact.conditions, np.random.default_rng(2)
    chosen = np.flatnonzero(c.present & (c.gap < 0.0))
    assert len(chosen) >= 8
    c.force[0, chosen] = draw.uniform(1.0, 3.0, len(chosen))
    if friction:
        c.force[1, chosen] = draw.uniform(-1.0, 1.0, len(chosen))
    forces = c.force.copy()
    derivatives = contact.linearise(chosen)
    move = draw.uniform(-1.0, 1.0, position.shape)
    answers = partial(answers_of, contact, forces=forces, chosen=chosen)
    within = 1e-7 * np.array([1.0, 1.0, 100.0])
    against_differences(derivatives, answers, position, move, tuple(within), name)
    own = derivatives.normal.T @ forces[0, chosen] + (derivatives.tangent.T @ forces[1, chosen] if friction else 0.0)
    np.testing.assert_allclose(own, answers(position)[2], atol=1e-9, rtol=0.0)
