"""Disc on block in statics: Newton iterations, quadratic convergence, and the reference of the shallow case."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

MORTAR = pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
SWAP = pytest.mark.parametrize("swap", [False, True], ids=["disc-slave", "block-slave"])


def disc(algorithm: str, swap: bool, *, depth: float, steps: int, level: int = 2, **changes: Any) -> Results:
    """A static run of disc-on-block."""
    scene = contactlab.load_scene("disc-on-block").with_(
        {
            "level": level,
            "integrator": {"use": "newton", "steps": steps},
            "contacts.0.algorithm": algorithm,
            "contacts.0.swap": swap,
            "supports.1.uy.to": -depth,
            "record.frames": 1,
        }
        | changes
    )
    return simulate(scene)


@cache
def in_steps(algorithm: str, swap: bool, steps: int) -> Results:
    """To the paper's depth."""
    return disc(algorithm, swap, depth=0.1581, steps=steps)


def reaction(results: Results) -> float:
    return float(results.summary["reactions"]["block.bottom"][1])


@MORTAR
@SWAP
@pytest.mark.parametrize(("level", "error"), [(1, 0.035), pytest.param(2, 0.006, marks=pytest.mark.full), (4, 0.0015)])
def test_shallow_in_one_load_step(algorithm: str, swap: bool, level: int, error: float) -> None:
    """At most 8 iterations, and the reaction of independent high-order codes, 60.321 +- 0.002 N/mm.

    Allowed errors are 1.5 times what the better of two published codes' coarse meshes cannot avoid: contact spans
    3, 6 and 12 segments of the slave.
    """
    results = disc(algorithm, swap, depth=0.01, steps=1, level=level)
    assert results.status == "finished"
    assert results.summary["iterations"] <= 8
    assert reaction(results) == pytest.approx(60.321, rel=error)


@MORTAR
@SWAP
def test_deep_in_five_load_steps(algorithm: str, swap: bool) -> None:
    results = in_steps(algorithm, swap, 5)
    assert results.summary["steps"] == 5
    assert results.summary["iterations"] <= 30


@MORTAR
@SWAP
def test_deep_in_one_load_step(algorithm: str, swap: bool) -> None:
    """Through cut-backs if need be; the same reaction as in five steps (elastic, frictionless: no history)."""
    one, five = (in_steps(algorithm, swap, steps) for steps in (1, 5))
    assert one.status == "finished"
    assert reaction(one) == pytest.approx(reaction(five), rel=1e-8)


@MORTAR
@pytest.mark.parametrize("swap", some([False, True], [False]), ids=["disc-slave", "block-slave"])
def test_quadratic_convergence(algorithm: str, swap: bool) -> None:
    """Once sets are settled each residual falls by the square of the factor before: log ratio 2 +- 0.2.

    Looked at in triples that begin in the asymptotic range and end above the round-off of the forces, of two runs so
    that no single one decides the median.
    """
    ratios = []
    for steps in (5, 10):
        rows = in_steps(algorithm, swap, steps).iterations
        for first, second, third in zip(rows, rows[1:], rows[2:], strict=False):
            settled = second.changed == third.changed == 0 and first.step == third.step
            if settled and first.force < 5e-3 and third.force > 1e-12:
                ratios.append(np.log(third.force / second.force) / np.log(second.force / first.force))
    assert len(ratios) >= 3
    assert np.median(ratios) == pytest.approx(2.0, abs=0.2)


@MORTAR
def test_results_do_not_depend_on_the_scale_of_the_contact_stiffness(algorithm: str) -> None:
    """It decides which condition is closed while iterating, not where the iteration ends."""
    found = [
        disc(algorithm, False, depth=0.05, steps=2, level=1, **{"contacts.0.enforcement": spec})
        for spec in ({"use": "active-set", "scale": scale} for scale in (1e-2, 1.0, 1e2))
    ]
    for other in (found[0], found[2]):
        assert reaction(other) == pytest.approx(reaction(found[1]), rel=1e-8)
        a, b = (results.contact["contacts.0"].last.pressure for results in (other, found[1]))
        np.testing.assert_allclose(a, b, atol=1e-8 * b.max(), rtol=0.0)


@pytest.mark.parametrize(
    ("algorithm", "swap", "level"),
    some(
        [(algorithm, swap, 1) for algorithm in ("mortar-p0", "mortar-p1") for swap in (False, True)]
        + [("mortar-p0", False, 2), ("mortar-p1", True, 2)],
        [("mortar-p1", True, 1)],
    ),
)
def test_coulomb_friction_does_not_depend_on_the_number_of_load_steps(algorithm: str, swap: bool, level: int) -> None:
    """Deep with mu = 0.2: 8 and 20 steps agree within 0.1 %."""
    counts = (8, 20)
    friction = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
    found = [disc(algorithm, swap, depth=0.1581, steps=steps, level=level, **friction) for steps in counts]
    assert all(results.status == "finished" for results in found)
    # the shear of 8 steps is off by some per cent, which is told
    assert {warning.code for warning in found[0].warnings} <= {"friction-steps"}
    assert not any(results.events for results in found[1:])
    assert [reaction(results) for results in found] == pytest.approx([reaction(found[-1])] * len(counts), rel=1e-3)
