"""Implicit integrators written by `motion.solve`: the scheme of the page, what the core books, and what is misused."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from contactlab_statics.implicit_dynamics import ImplicitDynamics
from from_source import changed
from tiers import some

import contactlab
from contactlab.api import WORK, ImplicitIntegrator, ImplicitMotion
from contactlab.errors import WrongAnswer
from contactlab.parts.registry import Registry
from contactlab.testing import integrator, integrator_contact
from contactlab.testing.assertions import Check, NotApplicable
from contactlab.testing.integrator import MASS, START, STIFFNESS
from contactlab.testing.oscillator import Oscillator, Ramp

PAGE = (Path(__file__).parents[2] / "docs" / "parts" / "integrator.md").read_text()
CODE = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)[1]


def of_page(*changes: str) -> Any:
    """The class of the page's second example, with pieces of its code exchanged."""
    code = CODE
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        assert old in code, f"{old!r} does not stand in the page"
        code = code.replace(old, new)
    space: dict[str, Any] = {"__name__": __name__}
    exec(code, space)
    return space["GeneralisedAlpha"]


OUTSIDE = Path(__file__).parents[1] / "outside"
TWO_STAGES = "integrator outside two-stages/src/two_stages/integrator.py:TwoStages"


def two_stages(*changes: str) -> Any:
    """The composite scheme of tests/outside, with pieces of its code exchanged."""
    space: dict[str, Any] = {"__name__": __name__}
    exec(changed(TWO_STAGES, changes), space)
    return space["TwoStages"]


SLOW = (  # thousands of steps; the amplification is tested below, contact by the balances, wrong schemes are caught
    integrator.energy_is_bounded, integrator_contact.contact_makes_no_energy,
    integrator_contact.friction_takes_the_energy_of_what_slides, integrator_contact.pressed_masses_rest,
    integrator.free_flight_is_exact, integrator.velocities_are_where_declared, integrator.ledger_closes,
    integrator.changing_steps_keep_the_order,
)  # fmt: skip


@pytest.mark.parametrize("make", [of_page, two_stages])
@pytest.mark.parametrize("check", [check for check in integrator.CHECKS if check not in SLOW])
def test_schemes_of_the_page_keep_all_duties(check: Check, make: Any) -> None:
    try:
        check(make()())
    except NotApplicable:
        assert check is integrator_contact.statics_are_in_equilibrium


@pytest.mark.full
@pytest.mark.parametrize("make", [of_page, two_stages])
@pytest.mark.parametrize("check", SLOW)
def test_schemes_of_the_page_pass_the_long_checks(check: Check, make: Any) -> None:
    check(make()())


def test_two_stages_are_of_second_order_in_a_run_with_contact() -> None:
    """Plates that a growing load keeps together, through half of a swing: differences of runs fall to a quarter."""
    registry = Registry(files=[OUTSIDE / "two-stages" / "src" / "two_stages" / "integrator.py"])

    def end(steps: int) -> Any:
        mesh = {"use": "rectangle", "x": [0.0, 2.0]}
        body = {"element": "q1", "material": "m"}
        results = contactlab.simulate(contactlab.Scene.from_data({
            "integrator": {"use": "two-stages", "steps": steps}, "time": {"end": SWING},
            "materials": {"m": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.0, "density": 1e-6}},
            "bodies": {
                "plate": body | {"mesh": mesh | {"y": [0.0, 1.0], "cells": [4, 1]}},
                "base": body | {"mesh": mesh | {"y": [-1.0, 0.0], "cells": [5, 1]}},
            },
            "contacts": [{"slave": "plate.bottom", "master": "base.top", "algorithm": "mortar-p1"}],
            "supports": [{"on": "base.bottom", "ux": 0.0, "uy": 0.0}],
            "loads": [{"on": "plate.top", "pressure": {"ramp": "parabola", "to": 50.0, "duration": SWING}}],
        }, registry=registry))  # fmt: skip
        assert results.status == "finished"
        assert results.summary["contacts"]["contacts.0"]["active"] == 5
        return results.displacement

    coarse, middle, fine = (end(steps) for steps in (20, 40, 80))
    # 4 in the limit; terms of the next order are a tenth at these steps
    assert np.abs(coarse - middle).max() > 3.5 * np.abs(middle - fine).max()


@pytest.mark.parametrize("radius", [0.0, 0.5, 1.0])
def test_radius_is_the_amplification_of_the_highest_frequencies(radius: float) -> None:
    """All three eigenvalues at w dt -> infinity are -radius: (E + radius)^3 u = 0 with the shift E by a step."""
    model = Oscillator(of_page()(radius), np.ones(1), np.array([1e8]), displacement=np.ones((1, 2)))
    u = model.run(12, 1.0)[:, 0, 0]
    left = np.convolve(u, np.poly([-radius] * 3), "valid")
    # 1/(w dt)^2 = 1e-8, and the tolerance of the iteration
    assert np.abs(left).max() < 1e-6 * np.abs(u).max()


SWING = 1.3e-4  # [s] 4 H/c of both heights, H = 2, c = sqrt(E/rho), is a whole one
WRONG = [
    (integrator.converges_at_its_order, "at=1 - alpha_f", "at=1.0"),
    (integrator.converges_at_its_order, "a[:] = motion.acceleration()", "pass"),
    (integrator.converges_at_its_order, "alpha_m * a,", "0.5 * alpha_m * a,"),
    (integrator.constant_force_gives_the_parabola, "(0.5 / beta - 1)", "0.5 / beta"),
    (integrator.velocities_are_where_declared, "gamma * new(moved)),", "0.9 * gamma * new(moved)),"),
    (integrator.restart_is_exact, "motion.last_dt == 0.0", "vars(motion).setdefault('on', state.time) == state.time"),
    # accelerations of contact forces live on in the next step
    (integrator_contact.pressed_masses_rest, " new(moved)\n", ' new(motion.state["displacement"] - u)\n'),
]  # fmt: skip


@pytest.mark.parametrize(("check", "old", "new"), some(WRONG, [WRONG[0], WRONG[3], WRONG[5]]))
def test_wrong_schemes_are_caught(caught: Any, check: Check, old: str, new: str) -> None:
    start = "        v, a = ", '        state, u = motion.state, motion.state["displacement"].copy()\n        v, a = '
    caught(check, of_page(*start, old, new)())


SHIPPED = pytest.param(ImplicitDynamics(dissipation=0.2), marks=pytest.mark.full)


@pytest.mark.parametrize("part", [of_page()(0.5), SHIPPED])
def test_the_ledger_closes_with_loads_supports_contact_and_what_the_scheme_takes(part: ImplicitIntegrator) -> None:
    model = Oscillator(
        part, MASS, STIFFNESS, velocity=START, damping=0.3, relaxation=1.5, clearance=0.1 * MASS, friction=0.2,
        force=lambda time: time * START, prescribed=Ramp(np.array([2]), np.array([0.4])),
    )  # fmt: skip
    model.run(200, 0.02)
    work = dict(zip(WORK, model.state["work"], strict=True))
    assert work["numerical"] > 1e-3 < work["slip"]
    # forces balance to the tolerance of 1e-8 of some ten N, over a path of some mm
    assert abs(model.unexplained_energy()) < 1e-7


@pytest.mark.parametrize("part", [of_page()(0.5), ImplicitDynamics(), ImplicitDynamics(impacts=False)])
def test_friction_of_an_impact_is_dissipated_with_that_of_its_impulses(part: ImplicitIntegrator) -> None:
    """A floor that stops the speed w takes mu w of the speed v along it, and m (v^2 - (v - mu w)^2)/2."""
    mass, v, w, mu = 2.0, 3.0, 1.0, 0.25
    model = Oscillator(
        part, np.array([mass]), np.zeros(1), velocity=np.array([[v, -w]]), clearance=np.array([0.13]), friction=mu
    )
    model.run(10, 0.05)
    assert model.state["velocity"][0] == pytest.approx([v - mu * w, 0.0], abs=1e-9)  # the tolerance of a step is 1e-8
    work, taken = dict(zip(WORK, model.state["work"], strict=True)), 0.5 * mass * (v**2 - (v - mu * w) ** 2)
    assert work["slip"] == pytest.approx(taken, rel=1e-8)
    assert work["friction"] == pytest.approx(-taken, rel=1e-8)


@dataclass(frozen=True)
class Misused(ImplicitIntegrator):
    """One flaw in the use of `solve`."""

    flaw: str = ""
    default_enforcement: ClassVar[str] = "active-set"
    order: ClassVar[int] = 1
    inertia: ClassVar[bool] = True

    def step(self, motion: ImplicitMotion, dt: float) -> None:
        v, flaw = motion.velocity, self.flaw
        if flaw == "never":
            return
        if flaw == "by halves":
            motion.solve(lambda moved: moved / dt)
        rate = {"no single rate": START, "negative": -1.0}.get(flaw, 1.0)
        for _ in range(2 if flaw == "twice" else 1):
            motion.solve(
                lambda moved: rate * moved / dt,
                lambda moved: (moved / dt - v) / dt,
                1.5 if flaw == "beyond the step" else 1.0,
            )


@pytest.mark.parametrize(
    ("flaw", "words"),
    [
        ("never", "Misused: its step does not solve, needed: motion.solve() once in each step"),
        ("twice", "Misused: its step solves twice, needed: motion.solve() once in each step; a scheme of"),
        ("by halves", "needed: velocity and acceleration if the class has inertia, else neither"),
        ("no single rate", "changes by -10 to 10 with it, needed: an affine one, with one rate > 0"),
        ("beyond the step", "Misused: solve got at = 1.5, lead = 0.0, needed: 0 < at <= at + lead <= 1"),
        ("negative", "Misused: solve got a function of the motion that changes by -10 to -10 with it"),
    ],
)
def test_misused_solve_is_named(flaw: str, words: str) -> None:
    model = Oscillator(Misused(flaw), MASS, STIFFNESS, velocity=START)
    with pytest.raises(WrongAnswer, match=re.escape(words)):
        model.advance(0.1)
