"""Static contact with exact or published answers: Hertz, flat punch, a rough plate, partial slip and its reversal.

Scenes and measures are those of `benchmarks/studies/statics_cases.py`; finer ones are in its table (docs/statics.md).
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from contactlab.simulation import simulate

STUDY = Path(__file__).parents[2] / "benchmarks" / "studies" / "statics_cases.py"
MORTAR = pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])


@pytest.fixture(scope="module")
def study() -> ModuleType:
    spec = importlib.util.spec_from_file_location("statics_cases", STUDY)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("algorithm", "swap"), [("mortar-p0", False), ("mortar-p1", True)])
def test_hertz_of_a_cylinder_on_a_block(study: ModuleType, algorithm: str, swap: bool) -> None:
    """Steel on aluminium, a/h about 4 and 7: largest pressure within 3 %, half-width within a cell.

    The pressure's root at the edge leaves 6 to 8 % in L2 at a/h = 4; what remains at a/R = 1/8 of the difference
    between a circle and the parabola of the theory, and of the finite block, is 1.3 %.
    """
    modulus = 1.0 / (0.91 / 210000.0 + 0.91 / 70000.0)
    made = study.hertz(algorithm, swap, 50.0, (210000.0, 70000.0), h=0.0155, zone=0.2, depth=0.012)
    found = study.hertz_measures(simulate(made), 50.0, modulus)
    assert found["iterations"] <= 8
    assert abs(found["p0 error"]) < 0.03
    assert abs(found["half-width error / h"]) < 1.0
    assert found["L2 error"] < 0.08


@MORTAR
def test_rigid_flat_punch(study: ModuleType, algorithm: str) -> None:
    """p = P/(pi (a^2 - x^2)^(1/2)) within 3 % in L2 over 0.9 a; p(0) is 0.6366 of the mean within 1 %."""
    found = study.punch_measures(simulate(study.punch(algorithm, 80)))
    assert found["L2 error, |x| < 0.9"] < 0.03
    assert found["p(0) / mean"] == pytest.approx(2.0 / np.pi, rel=0.01)
    # no more than what one nodal force does in the multipliers of a uniform mesh: 24 % for P0, 46 % for P1
    assert found["undershoot / pressure at the corner"] < {"mortar-p0": 0.24, "mortar-p1": 0.46}[algorithm]


@MORTAR
def test_plate_on_a_rough_plane(study: ModuleType, algorithm: str) -> None:
    """mu = 1: published displacements within their 5 %; open, sliding and sticking in this order from the free side."""
    found = study.plate_measures(simulate(study.plate(algorithm)))
    assert found["iterations"] <= 8
    for x in study.PUBLISHED:
        assert abs(found[f"u({1e3 * x:g})"]) < 0.05
    assert 0.0 < found["open until mm"] < found["stick from mm"] < 40.0


@pytest.mark.parametrize("mu", [2.0, 5.0, 20.0])
def test_high_friction(study: ModuleType, mu: float) -> None:
    """Equilibria are found with any friction that a user may mean; with mu = 5 the corner lifts off up to 7.5 mm."""
    results = simulate(study.plate("mortar-p0", mu))
    assert results.status == "finished"
    assert results.summary["iterations"] <= 12
    contact = results.summary["contacts"]["contacts.0"]
    assert contact["cone_violation"] < 1e-8
    if mu == 5.0:
        assert study.plate_measures(results)["open until mm"] == pytest.approx(7.5, abs=1.25)


def test_absurd_friction_is_never_accepted_silently(study: ModuleType) -> None:
    """mu = 1000: the iteration fails, and the run says so after the shortest step."""
    scene = study.plate("mortar-p0", 1000.0, cells=8)
    results = simulate(scene)
    if results.status == "finished":
        assert results.summary["contacts"]["contacts.0"]["cone_violation"] < 1e-8
    else:
        assert results.status == "not-converged"
        assert "iterations left residuals" in results.reason


def test_partial_slip_and_its_reversal(study: ModuleType) -> None:
    """Cattaneo & Mindlin, Q = 0.7 mu P, a/h = 7.5: stick half-width within a cell, |q| <= mu p to round-off.

    L2 errors of q: 8 % loaded and 10 % after full reversal are seen; at the middle of the way back, where three zones
    of a few cells alternate, 21 %.
    """
    found = study.mindlin_measures(simulate(study.mindlin("mortar-p1", False, h=0.002, steps=8)))
    assert abs(found["stick width error / h"]) < 1.0
    assert abs(found["peak error at t=2"]) < 0.06
    assert found["L2 error of q at t=2"] < 0.10
    assert found["L2 error of q at t=3"] < 0.25
    assert found["L2 error of q at t=4"] < 0.12
    assert found["cone violation"] < 1e-12
