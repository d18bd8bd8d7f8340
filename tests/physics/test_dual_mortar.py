"""Dual multipliers on disc-on-block: pressures of the reference, no swings, friction, and short rows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarDual
from tiers import some

import contactlab
from contactlab.studies.measures import mutual_difference
from contactlab.studies.profile import Profile
from contactlab.testing.surfaces import chains, conditions, dense

COARSE = {"bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2]}


def pressed(algorithm: str, **changes: Any) -> contactlab.Results:
    keys = {"contacts.0.algorithm": algorithm, "record.frames": 1, **changes}
    results = contactlab.simulate(contactlab.load_scene("disc-on-block").with_(keys))
    assert results.status == "finished", results.reason
    return results


@pytest.mark.parametrize("swap", some([False, True], [True]), ids=["disc-slave", "block-slave"])
def test_pressures_differ_from_linear_ones_by_the_error_of_the_mesh(swap: bool) -> None:
    """In statics at level 2, where linear multipliers are 0.9 to 1.0 % off; dual ones never pull."""
    keys = {"contacts.0.swap": swap, "integrator": "newton", "level": 2}
    curves = [pressed(name, **keys).contact["contacts.0"].last for name in ("mortar-p1", "mortar-dual")]
    linear, dual = (Profile.of_curve(curve, "pressure") for curve in curves)
    assert mutual_difference(dual, linear) < 0.02  # two errors of 1 %
    assert curves[1].pressure.min() > -1e-12 * curves[1].pressure.max()  # round-off of T


@pytest.mark.parametrize("swap", some([False, True], [False]), ids=["disc-slave", "block-slave"])
def test_explicit_friction_ends_at_the_force_of_statics(swap: bool) -> None:
    """Either way the bodies are in equilibrium at the end; histories differ, and with them what has slid: 1 %."""
    keys = {"contacts.0.swap": swap, "contacts.0.friction": {"use": "coulomb", "mu": 0.2}, **COARSE}
    explicit = pressed("mortar-dual", **keys, **{"time.ramp": 1.1e-5})  # some 15 periods
    statics = pressed("mortar-dual", integrator={"use": "newton", "steps": 10}, **keys)
    one, other = (results.summary["reactions"]["disc.top"][1] for results in (explicit, statics))
    assert one == pytest.approx(other, rel=1e-2)
    assert explicit.summary["balance"]["ledger_error"] < 1e-6
    assert explicit.summary["balance"]["friction"] > 0.0


def test_a_condition_names_only_what_lies_opposite_its_segments() -> None:
    """Four master nodes where segments are as long as the slave's; inverses of P0 and P1 reach along the chain."""
    slave, master = 0.1 * np.arange(21), 0.1 * (np.arange(-1, 23) + 0.37)
    at = chains(*(np.stack([x, np.zeros(len(x))], axis=1) for x in (slave, master)))
    rows = conditions(MortarDual(), at)
    weights = np.abs(dense(rows, rows.normal_weight, len(at.nodes))[..., 1])[:, len(slave) :]
    assert ((weights > 1e-12).sum(axis=1)[1:-1] == 4).all()
