"""The record of a pair, held against the same numbers put together by NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contactlab.api.contact_steps import contact_record
from contactlab.api.frame import STICK
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.results.contact_nodes import node_values
from contactlab.results.contact_sampler import ContactSampler
from contactlab.results.frame import layout_of
from contactlab.results.record_plan import Window
from contactlab.results.slips import slips_of
from contactlab.scene.scene import load_scene

SMALL = {"bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.end": 8e-6}


@pytest.mark.parametrize("friction", [None, {"use": "coulomb", "mu": 0.1}, {"use": "coulomb", "mu": 0.8}])
@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1", "node-on-segment"])
def test_record_pair_is_what_numpy_finds(algorithm: str, friction: Any) -> None:
    changes = {"contacts.0.algorithm": algorithm, **({"contacts.0.friction": friction} if friction else {})}
    scene = load_scene("disc-on-block").with_({**SMALL, **changes})
    model = build(scene, default_registry())
    layout = layout_of(model, scene, {}, {})
    blocks: list[Any] = []
    sampler = ContactSampler(model, layout, Window(), blocks.append)
    step, dt = model.bound_integrator().step, 0.9 * model.stable_step()
    for _ in range(30):
        sampler.sample(step(dt), dt)
    sampler.flush()
    (rows,) = (block["contacts.0"] for block in blocks)
    assert rows.dtype == contact_record(layout.contacts[0])
    assert rows["step"].tolist() == list(range(1, 31))
    (pair,) = model.contact.pairs  # type: ignore[union-attr]
    found = node_values(pair, pair.snapshot(model.state, model.position))
    assert found["state"].any()
    for name in set(found) & set(rows.dtype.names or ()):
        np.testing.assert_array_equal(rows[name][-1], found[name].astype(rows.dtype[name].base), err_msg=name)
    if friction:
        slips = pair.slips_at_nodes(slips_of(model)[: pair.slots], pair.snapshot(model.state, model.position).gaps)
        # sums in another order: round-off of positions (1 mm) and half a unit of single precision
        np.testing.assert_allclose(rows["slip"][-1], slips, rtol=2.0**-23, atol=1e-15)
        assert np.abs(slips).max() > 1e-9
    sticking = rows["state"] == STICK
    if sticking.any():  # what sticks does not slide, beyond the tolerance of the solver, in damped steps either
        assert friction
        assert np.abs(rows["slip"][sticking]).max() < 1e-8 * pair.size
