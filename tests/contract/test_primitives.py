"""Explicit integrators written by primitives: the core keeps the other duties, and names what is misused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactlab.api import ExplicitIntegrator
from contactlab.errors import WrongAnswer
from contactlab.parts.contract import faults
from contactlab.parts.registry import Registry
from contactlab.testing.assertions import NotApplicable
from contactlab.testing.integrator import (
    CHECKS,
    DUTIES,
    MASS,
    START,
    STIFFNESS,
    constant_force_gives_the_parabola,
    converges_at_its_order,
)
from contactlab.testing.integrator_contact import contact_stops_what_falls
from contactlab.testing.oscillator import Oscillator, Ramp

REGISTRY = Registry(files=[Path(__file__).with_name("primitives.py")])
DOWN = np.array([[0.0, 20.0]])  # presses all masses on their floors
Verlet: Any = REGISTRY.part_class("integrator", "verlet")
Wrong: Any = REGISTRY.part_class("integrator", "wrong-primitives")


def failed(integrator: Any) -> set[str]:
    """Names of the checks that an integrator fails."""
    names = set()
    for check in CHECKS:
        try:
            check(integrator)
        except NotApplicable:
            continue
        except AssertionError:
            names.add(check.__name__)
    return names


OF_CONTACT = {check.__name__ for check in DUTIES[6]}


def test_velocity_verlet_keeps_all_duties_but_contact_in_three_lines() -> None:
    assert failed(Verlet()) == OF_CONTACT - {"statics_are_in_equilibrium"}


def test_two_kicks_close_the_ledger_with_loads_supports_and_the_slow_velocity_of_damping() -> None:
    model = Oscillator(
        Verlet(), MASS, STIFFNESS, velocity=START, damping=0.3, relaxation=1.5,
        force=lambda time: time * START, prescribed=Ramp(np.array([2]), np.array([0.4])),
    )  # fmt: skip
    model.run(300, 0.02)
    assert model.state["work"][1] != 0.0 != model.state["work"][2]
    # round-off of sums of some ten mJ over 300 steps
    assert abs(model.unexplained_energy()) < 1e-11


def test_the_ledger_closes_where_contact_rubs_under_damping() -> None:
    model = Oscillator(
        Wrong(), MASS, STIFFNESS, velocity=START, damping=0.3, clearance=0.1 * MASS, friction=0.2, force=-DOWN
    )
    model.run(300, 0.02)
    assert model.state["work"][4] < 0.0, "friction acts"
    assert abs(model.unexplained_energy()) < 1e-11


@pytest.mark.parametrize(
    ("flaw", "words"),
    [
        ("contact before the kick", "asks for contact forces without a kick, needed: one kick before"),
        ("contact twice", "asks for contact forces without a kick, needed: one kick before"),
        ("kicks twice", "kicks again beside contact, needed: one kick a step with contact"),
        ("contact of another time", "drifts for 0.1 s, and asked for contact 0.05 s ahead, needed: the same time"),
        ("half a step", "its step of 0.1 s drifts for 0.05 s, needed: its length"),
        ("contact now", "asks for contact 0 s ahead, needed: a positive time"),
        ("no drift", "asks for contact and does not drift, needed: a drift after it"),
        ("no kick", "asks for contact forces without a kick"),
        ("no time", "its step kicks for 0 s, needed: a positive time"),
    ],
)
def test_misused_primitives_are_named(flaw: str, words: str) -> None:
    if flaw == "half a step":  # without contact, or the time of contact is named first
        model = Oscillator(Wrong(flaw), MASS, STIFFNESS, velocity=START)
    else:
        model = Oscillator(Wrong(flaw), MASS, STIFFNESS, velocity=START, clearance=MASS)
    with pytest.raises(WrongAnswer, match=f"^Wrong: its step .*{words}|^Wrong: {words}"):
        model.advance(0.1)


def test_wrong_physics_is_left_to_the_checks() -> None:
    for flaw, check in (
        ("no half step at the start", converges_at_its_order),
        ("kicks twice", constant_force_gives_the_parabola),
        ("no contact", contact_stops_what_falls),
    ):
        check(Wrong())
        with pytest.raises(AssertionError):
            check(Wrong(flaw))


def test_an_integrator_has_a_step_or_a_bind() -> None:
    empty = type("Empty", (ExplicitIntegrator,), {"default_enforcement": "forward-increment", "order": 2})
    assert "it has no step" in faults("integrator", empty)
    assert faults("integrator", Verlet) == []
