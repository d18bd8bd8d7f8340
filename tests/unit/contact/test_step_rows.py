"""Conditions of a step of a motion: which multipliers have one, and what happens to those that had one before."""

from __future__ import annotations

import numpy as np
import pytest

import contactlab
from contactlab.contact.implicit_system import ImplicitContactSystem
from contactlab.model.build import build


@pytest.mark.parametrize("algorithm", ["node-on-segment", "mortar-p0"])
def test_a_multiplier_whose_node_has_left_the_master_has_no_force(algorithm: str) -> None:
    """A step starts with a slider half over the end of its base, all multipliers at 1 N, and leads back onto it.

    Conditions need a gap where the step starts; that there is one in its middle is not enough.
    """
    scene = contactlab.load_scene("corner-slide").with_(
        {"integrator": "implicit-dynamics", "contacts.0.algorithm": algorithm}
    )
    model = build(scene, scene.registry)
    contact, at = model.contact, model.reference.copy()
    assert isinstance(contact, ImplicitContactSystem)
    assert contact.consistent
    contact.begin_step(at, 1e-9)
    contact.evaluate(at)
    before = contact.conditions.present.copy()
    contact.multipliers[0] = np.where(before, 1.0, 0.0)

    slider = np.unique(next(body.cells for body in model.bodies if body.name == "slider"))
    at[slider, 0] += 6.0
    model.state["velocity"][slider, 0] = -6.0 / 0.5e-9
    contact.begin_step(at, 1e-9)
    contact.evaluate(at)
    left = before & ~contact.conditions.present
    assert left.any()
    assert contact.conditions.present.any()
    pressed = np.flatnonzero(contact.conditions.force[0])
    assert not left[pressed].any()
    assert contact.linearise(pressed.astype(np.int32)).gap.shape[0] == len(pressed)
