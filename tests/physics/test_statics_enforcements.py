"""Penalty and augmented Lagrangian against exact multipliers: the same problem, springs in between."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

FRICTION = pytest.mark.parametrize("mu", some([0.0, 0.2], [0.2]))


@cache
def disc(enforcement: str, factor: float = 0.0, mu: float = 0.0, algorithm: str = "mortar-p1") -> Results:
    """Deep disc-on-block, level 1, two load steps."""
    spec: Any = {"use": enforcement, "factor": factor} if factor else enforcement
    friction = {"contacts.0.friction": {"use": "coulomb", "mu": mu}} if mu else {}
    changes = {"level": 1, "integrator": {"use": "newton", "steps": 2}, "contacts.0.algorithm": algorithm}
    changes |= {"contacts.0.enforcement": spec, "record.frames": 1}
    return simulate(contactlab.load_scene("disc-on-block").with_(changes | friction))


def reaction(results: Results) -> float:
    return float(results.summary["reactions"]["block.bottom"][1])


@FRICTION
@pytest.mark.parametrize("factor", some([10.0, 1e3], [10.0]))
def test_augmented_lagrangian_ends_at_exact_multipliers(factor: float, mu: float) -> None:
    """To the tolerance of the iteration, 1e-8, times the contraction that is left with the softest springs."""
    exact, found = disc("active-set", mu=mu), disc("augmented-lagrangian", factor, mu)
    assert found.status == "finished"
    assert reaction(found) == pytest.approx(reaction(exact), rel=1e-7)
    a, b = (results.contact["contacts.0"].last for results in (found, exact))
    np.testing.assert_allclose(a.pressure, b.pressure, atol=1e-6 * b.pressure.max(), rtol=0.0)
    np.testing.assert_allclose(a.shear, b.shear, atol=1e-6 * b.pressure.max(), rtol=0.0)


@pytest.mark.parametrize(("algorithm", "mu"), some([("mortar-p0", 0.0), ("mortar-p1", 0.2)], [("mortar-p1", 0.2)]))
def test_penalty_approaches_exact_multipliers(algorithm: str, mu: float) -> None:
    """The error is that of the springs' shortening: a tenth for ten times the stiffness, to the next order."""
    exact = reaction(disc("active-set", mu=mu, algorithm=algorithm))
    errors = [1.0 - reaction(disc("penalty", factor, mu, algorithm)) / exact for factor in (1e2, 1e3, 1e4)]
    assert 0.0 < errors[0] < 0.003
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.1)


def test_stiff_springs_need_few_iterations() -> None:
    """Statuses are decided as with exact multipliers: no jumping in and out of contact."""
    exact = disc("active-set").summary["iterations"]
    assert disc("penalty", 1e4).summary["iterations"] <= exact + 2


def test_derived_stiffness_is_told() -> None:
    least, most = disc("penalty", 100.0).summary["contacts"]["contacts.0"]["stiffness"]
    assert 0.0 < least < most < 1e6
