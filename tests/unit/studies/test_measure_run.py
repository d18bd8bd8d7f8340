"""From a summary and a curve to the numbers of a row."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from contactlab.results.results import ContactCurve
from contactlab.studies.measure_run import driven_support, measure_run, reaction_against_pressure, sides
from contactlab.studies.profile import Profile
from contactlab.studies.reference import Reference

SCENE: dict[str, Any] = {
    "symmetry": "x",
    "contacts": [{"slave": "upper.bottom", "master": "lower.top", "swap": False}],
    "supports": [{"on": "lower.bottom", "uy": 0.0}, {"on": "upper.top", "uy": {"ramp": "parabola", "to": -1.0}}],
}
FORCES = {"lower.bottom": np.array([0.0, 98.0]), "upper.top": np.array([3.0, -100.0])}


def test_the_driven_support_is_the_one_that_moves() -> None:
    assert driven_support(SCENE, FORCES) == "upper.top"
    still = {**SCENE, "supports": [{"on": "lower.bottom", "uy": 0.0}]}
    assert driven_support(still, FORCES) == "upper.top"  # the larger force
    assert driven_support(still, {}) == ""


def test_swap_exchanges_the_sides() -> None:
    assert sides(SCENE["contacts"][0]) == ("upper.bottom", "lower.top")
    assert sides({**SCENE["contacts"][0], "swap": True}) == ("lower.top", "upper.bottom")


def test_reaction_against_pressure_is_that_of_a_body_without_loads() -> None:
    """Support and contact do not balance where a load acts as well: it was told as an error of 53 % once."""
    bodies: dict[str, Any] = {"upper": {}, "lower": {}}
    pressure = np.array([0.0, 100.0])
    loaded = {**SCENE, "bodies": bodies, "loads": [{"on": "upper.side", "pressure": 1.0}]}
    assert reaction_against_pressure(loaded, FORCES, 0, pressure) == pytest.approx(2.0 / 98.0)  # of the other body
    heavy = {**SCENE, "bodies": bodies, "effects": [{"use": "gravity", "on": []}]}
    assert math.isnan(reaction_against_pressure(heavy, FORCES, 0, pressure))


def test_reaction_against_pressure_is_the_lack_of_balance_of_the_slave_body() -> None:
    # slave: R + P = (3, -100) + (-3, 99) = (0, -1)
    share = reaction_against_pressure(SCENE, FORCES, 0, np.array([-3.0, 99.0]))
    assert share == pytest.approx(1.0 / math.hypot(3.0, 100.0))


def test_a_free_slave_body_is_balanced_on_the_master_side() -> None:
    below = {"lower.bottom": FORCES["lower.bottom"]}
    # master: R - P = (0, 98) - (0, 100)
    assert reaction_against_pressure(SCENE, below, 0, np.array([0.0, 100.0])) == pytest.approx(2.0 / 98.0)
    assert math.isnan(reaction_against_pressure(SCENE, {}, 0, np.array([0.0, 100.0])))


def test_a_body_with_two_contacts_has_no_balance_with_one_of_them() -> None:
    two = {**SCENE, "contacts": [*SCENE["contacts"], {"slave": "upper.side", "master": "lower.top"}]}
    assert math.isnan(reaction_against_pressure(two, FORCES, 0, np.array([0.0, 100.0])))


def test_a_body_that_touches_itself_has_no_balance_with_that_contact() -> None:
    own = {**SCENE, "contacts": [{"slave": "upper.bottom", "master": "upper.top"}]}
    assert math.isnan(reaction_against_pressure(own, FORCES, 0, np.array([0.0, 100.0])))


def test_all_measures_of_a_run(curve_of: Callable[..., ContactCurve]) -> None:
    x = np.linspace(-1.0, 1.0, 41)
    exact = Profile(x, 1.0 - x**2)
    reference = Reference("r", "", "", exact, np.zeros(41), scalars={"reaction": {"value": 100.0, "error": 0.1}})
    summary = {
        "steps": 200,
        "contact_sweeps": 900,
        "cost": {"run_cpu_s": 5.0, "compile_s": 1.0, "run_wall_s": 6.0, "peak_memory_mib": 120.0},
        "balance": {"kinetic": 0.2, "internal": 20.0},
        "reactions": {on: list(force) for on, force in FORCES.items()},
        "reaction_mismatch": 0.05,
        "contacts": {"contacts.0": {"resultant": [-3.0, 99.0], "pressure_integral": [-3.0, 99.0],
                                    "max_pressure": 1.1, "max_penetration": 0.002}},
    }  # fmt: skip
    found, notes = measure_run(SCENE, summary, 0, curve_of(x, 1.1 * exact.value), reference)
    assert notes == []
    assert found["reaction"] == pytest.approx(math.hypot(3.0, 100.0))
    assert found["reaction_error"] == pytest.approx(math.hypot(3.0, 100.0) / 100.0 - 1.0)
    assert found["pressure_error"] == pytest.approx(0.1, rel=1e-9)
    assert found["largest_pressure_error"] == pytest.approx(0.1, rel=1e-9)  # at the middle, where r is largest
    assert found["oscillation"] == pytest.approx(0.0, abs=1e-12)  # a scaled pressure is as smooth
    assert found["turning_points"] == 0
    assert found["mirror_asymmetry"] == pytest.approx(0.0, abs=1e-7)  # root of round-off
    assert found["sideways_force"] == pytest.approx(3.0 / 99.0)
    assert (found["steps"], found["sweeps"]) == (200.0, 4.5)
    assert (found["cpu_s"], found["wall_s"]) == (4.0, 5.0)
    assert found["kinetic_share"] == pytest.approx(0.01)
    assert found["max_penetration"] == 0.002


def test_a_run_that_left_nothing_has_no_numbers() -> None:
    found, _ = measure_run(SCENE, {}, 0, None, None)
    assert all(math.isnan(value) for value in found.values())


def test_nulls_in_a_summary_are_missing_numbers() -> None:
    found, _ = measure_run(SCENE, {"reaction_mismatch": None, "balance": {"kinetic": None}}, 0, None, None)
    assert math.isnan(found["reaction_mismatch"])


def test_pressure_on_a_folded_surface_is_noted(curve_of: Callable[..., ContactCurve]) -> None:
    folded = curve_of(np.array([0.0, 1.0, 0.5]), np.array([1.0, 2.0, 1.0]))
    found, notes = measure_run(SCENE, {}, 0, folded, None)
    assert "turns back" in notes[0]
    assert "mirror_asymmetry" not in found
