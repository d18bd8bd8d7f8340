"""Explicit integrators written by primitives: the core keeps the other duties, and names what is misused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from from_source import subject_of

from contactlab.api import ExplicitIntegrator
from contactlab.errors import WrongAnswer
from contactlab.parts.contract import faults
from contactlab.parts.registry import Registry
from contactlab.testing.assertions import NotApplicable
from contactlab.testing.integrator import CHECKS, DUTIES, MASS, START, STIFFNESS
from contactlab.testing.oscillator import Oscillator, Ramp

REGISTRY = Registry(files=[Path(__file__).with_name("primitives.py")])
DOWN = np.array([[0.0, 20.0]])  # presses all masses on their floors
Verlet: Any = REGISTRY.part_class("integrator", "verlet")
KICK, TOUCH, DRIFT = "motion.kick(0.5 * (motion.last_dt + dt))", "motion.contact(ahead=dt)", "motion.drift(dt)"


def leapfrog(folder: Path, *pieces: str) -> Any:
    """The one that `new-plugin` writes, with pieces of it exchanged."""
    return subject_of("template integrator", folder, pieces).make()


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


def test_the_ledger_closes_where_contact_rubs_under_damping(tmp_path: Path) -> None:
    model = Oscillator(
        leapfrog(tmp_path),
        MASS,
        STIFFNESS,
        velocity=START,
        damping=0.3,
        clearance=0.1 * MASS,
        friction=0.2,
        force=-DOWN,
    )
    model.run(300, 0.02)
    assert model.state["work"][4] < 0.0, "friction acts"
    assert abs(model.unexplained_energy()) < 1e-11


NEXT = "\n        "
UNKICKED = "asks for contact forces without a kick"


@pytest.mark.parametrize(
    ("old", "new", "touches", "words"),
    [
        (KICK, TOUCH + NEXT + KICK, True, f"{UNKICKED}, needed: one kick before"),
        (TOUCH, TOUCH + NEXT + TOUCH, True, f"{UNKICKED}, needed: one kick before"),
        (
            DRIFT,
            f"{DRIFT}{NEXT}motion.kick(dt)",
            True,
            "kicks again with contact, needed: one kick a step",
        ),
        ("=dt", "=0.5 * dt", True, "drifts for 0.1 s, and asked for contact 0.05 s ahead, needed: the same time"),
        # without contact, or the time of contact is named first
        (DRIFT, "motion.drift(0.5 * dt)", False, "its step of 0.1 s drifts for 0.05 s, needed: its length"),
        ("=dt", "=0.0", True, "asks for contact 0 s ahead, needed: a positive time"),
        (NEXT + DRIFT, "", True, "asks for contact and does not drift, needed: a drift after it"),
        (KICK + NEXT, "", True, UNKICKED),
        (KICK, "motion.kick(0.0)", True, "its step kicks for 0 s, needed: a positive time"),
    ],
)
def test_misused_primitives_are_named(old: str, new: str, touches: bool, words: str, tmp_path: Path) -> None:
    clearance = {"clearance": MASS} if touches else {}
    model = Oscillator(leapfrog(tmp_path, old, new), MASS, STIFFNESS, velocity=START, **clearance)
    with pytest.raises(WrongAnswer, match=f"^Mine: its step .*{words}|^Mine: {words}"):
        model.advance(0.1)


def test_an_integrator_has_a_step_or_a_bind() -> None:
    empty = type("Empty", (ExplicitIntegrator,), {"default_enforcement": "forward-increment", "order": 2})
    assert "it has no step" in faults("integrator", empty)
    assert faults("integrator", Verlet) == []
