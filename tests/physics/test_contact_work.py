"""The work of contact by what it comes from: the parts are those of the power balance, and add up to the ledger's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.api.state import CONTACT_WORK
from contactlab.errors import SceneError
from contactlab.model.build import build
from contactlab.results.energies import energies

SPLIT: dict[str, Any] = {"record.contact_work": True}
FAST: dict[str, Any] = {"time.ramp": 1e-6}
FRICTION: dict[str, Any] = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
FINER: dict[str, Any] = {"bodies.block.mesh.cells": [72, 12]}


def stepped(name: str, forces: str, algorithm: str, changes: dict[str, Any], steps: int) -> tuple[Any, np.ndarray]:
    """A model after so many steps, and the parts of its contact work after each of them (steps, 4) [mJ]."""
    enforcement = {"use": "forward-increment", "forces": forces}
    changes = {"contacts.0.algorithm": algorithm, "contacts.0.enforcement": enforcement, **SPLIT, **changes}
    scene = contactlab.load_scene(name).with_(changes)
    model = build(scene, scene.registry)
    advance, dt, split = model.bound_integrator().step, 0.9 * model.stable_step(), model.split
    assert split is not None
    parts, work = np.zeros((steps, 4)), np.zeros(steps)
    for number in range(steps):
        # steps of different lengths: what counts is the mean velocity
        length = dt * (1.0 - 0.2 * (number % 3 == 0))
        split.sample(advance(length), length)
        parts[number], work[number] = split.work, model.state["work"][3]
    assert np.abs(work).max() > 0.0
    # the ledger sums nodal forces, the parts conditions
    assert np.abs(parts.sum(axis=1) - work).max() < 1e-11 * np.abs(parts).max()
    return model, parts


@pytest.mark.parametrize("forces", ["frozen", "consistent"])
@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1", "node-on-segment"])
@pytest.mark.parametrize(
    "changes", [pytest.param({}, marks=pytest.mark.full), FRICTION], ids=["frictionless", "friction"]
)
def test_parts_add_up_to_the_work_of_contact(forces: str, algorithm: str, changes: dict[str, Any]) -> None:
    stepped("disc-on-block", forces, algorithm, {**FAST, **changes}, 120)


def test_forces_of_changing_weights_are_what_a_finer_master_makes_energy_by() -> None:
    """The part that consistent forces cure, and no other one."""
    made = {}
    for forces in ("frozen", "consistent"):
        _, parts = stepped("disc-on-block", forces, "mortar-p0", {"time.ramp": 2e-6, **FINER}, 600)
        made[forces] = dict(zip(CONTACT_WORK, parts[-1], strict=True))
    frozen, consistent = made["frozen"], made["consistent"]
    assert frozen["weights"] > 5.0 * max(abs(frozen[part]) for part in ("step", "normals"))
    assert frozen["weights"] > 300.0 * abs(consistent["weights"])
    assert max(abs(consistent[part]) for part in ("step", "normals", "weights")) < 0.03 * -consistent["closing"]


def test_a_block_that_falls_flat_is_stopped_by_closing_alone() -> None:
    """Nothing turns, nothing slides: what a node that is stopped loses is closing."""
    model, parts = stepped("dropped-block", "frozen", "mortar-p0", {}, 1500)
    closing, step, normals, weights = parts[-1]
    assert closing < 0.0
    assert max(abs(normals), abs(weights)) < 1e-6 * -closing
    assert abs(step) < 0.1 * -closing
    found = energies(model)
    assert [found[f"contact.{part}"] for part in CONTACT_WORK] == parts[-1].tolist()


def test_conditions_that_come_finished_have_closing_and_the_step_alone() -> None:
    from contactlab.contact.work_split import OperatorSplit, PairSplit

    model, _ = stepped("disc-on-block", "frozen", "mortar-p0", FAST, 250)
    split = model.split
    assert split is not None
    (pair,) = split.pairs
    assert isinstance(pair, OperatorSplit)
    finished = PairSplit(pair.pair, model.reference)
    y = model.state["multipliers"][0, pair.pair.own]
    before, reached = split.position
    memory = np.zeros((0, 0))
    whole, apart = (each.parts(y, (before, memory), (reached, memory)) for each in (finished, pair))
    assert whole[2] == whole[3] == 0.0
    assert np.isclose(whole.sum(), apart.sum(), rtol=1e-9)
    assert whole[0] == pytest.approx(apart[0], rel=1e-9)


def test_only_leapfrog_steps_are_split() -> None:
    scene = contactlab.load_scene("disc-on-block").with_({**SPLIT, "integrator": "newton", "time.end": 1.0})
    with pytest.raises(SceneError, match="explicit leapfrog steps only") as refused:
        build(scene, scene.registry)
    assert "record.contact_work" in str(refused.value)
