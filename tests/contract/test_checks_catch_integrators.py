"""Every duty of an integrator is held by a check, and every check catches one that forgets it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from contactlab_statics.newton import Newton

from contactlab.api import ImplicitEquations, ImplicitIntegrator, Integrator, State, Step
from contactlab.parts.registry import Registry
from contactlab.testing import integrator, integrator_contact, run_checks
from contactlab.testing.assertions import Check
from contactlab.testing.run import run_check
from contactlab.testing.scenarios import scenarios_for
from contactlab.testing.subject import Subject

FILE = Path(__file__).with_name("leapfrog.py")
Leapfrog: Any = Registry(files=[FILE]).part_class("integrator", "numpy-leapfrog")


def test_a_right_integrator_passes_all_checks() -> None:
    outcomes = run_checks("integrator", Leapfrog())
    assert [o for o in outcomes if o.status == "failed"] == []
    declined = {"refused_steps_leave_the_state", "statics_are_in_equilibrium", "steps_are_begun_and_accepted"}
    assert {o.check for o in outcomes if o.status != "passed"} == declined


@dataclass(frozen=True)
class NoOrder(Leapfrog):
    """Promises nothing."""

    order: ClassVar[int] = 0


@dataclass(frozen=True)
class OtherLag(Leapfrog):
    """Says that its velocities are those of the end of a step."""

    velocity_lag: ClassVar[float] = 0.0


@dataclass(frozen=True)
class NoTakingBack(ImplicitIntegrator):
    """Statics that leave their last trial where a step fails."""

    default_enforcement: ClassVar[str] = "active-set"
    order: ClassVar[int] = 1
    inertia: ClassVar[bool] = False

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        return Newton().memory(nodes)

    def bind(self, equations: ImplicitEquations, state: State) -> Any:
        inner = Newton().bind(equations, state)

        def step(dt: float) -> Step:
            done = inner(dt)
            if done.reason:
                state["displacement"][:] += 1e-12
            return done

        return step


@dataclass(frozen=True)
class FrictionLost(NoTakingBack):
    """Statics that leave the normal part of contact forces alone in the state."""

    def bind(self, equations: ImplicitEquations, state: State) -> Any:
        inner = Newton().bind(equations, state)

        def step(dt: float) -> Step:
            done = inner(dt)
            state["contact_force"][:, 0] = 0.0
            return done

        return step


class _Deaf:
    """Equations of which one method is called so many times whenever the integrator calls it."""

    def __init__(self, equations: ImplicitEquations, method: str, times: int) -> None:
        self.equations, self.method, self.times = equations, method, times

    def __getattr__(self, name: str) -> Any:
        found = getattr(self.equations, name)
        if name != self.method:
            return found
        return lambda *given: [found(*given) for _ in range(self.times)] and None


@dataclass(frozen=True)
class Deaf(NoTakingBack):
    """Statics that forget a call, or make it twice."""

    method: str = "accept"
    times: int = 0

    def bind(self, equations: ImplicitEquations, state: State) -> Any:
        deaf: Any = _Deaf(equations, self.method, self.times)
        return Newton().bind(deaf, state)


WRONG: list[tuple[Check, Integrator]] = [
    (integrator.steps_are_begun_and_accepted, Deaf()),
    (integrator.steps_are_begun_and_accepted, Deaf(times=2)),
    (integrator.steps_are_begun_and_accepted, Deaf("begin_step")),
    (integrator_contact.statics_are_in_equilibrium, FrictionLost()),
    (integrator.declarations, NoOrder()),
    (integrator.converges_at_its_order, Leapfrog("no half step at the start")),
    (integrator.free_flight_is_exact, Leapfrog("speed leaks")),
    (integrator.constant_force_gives_the_parabola, Leapfrog("no half step at the start")),
    (integrator.changing_steps_keep_the_order, Leapfrog("new step length for the velocity")),
    (integrator.velocities_are_where_declared, OtherLag()),
    (integrator.forces_belong_to_the_end_of_the_step, Leapfrog("forces of the start")),
    (integrator.prescribed_motion_is_exact, Leapfrog("supports lag a step")),
    (integrator.loads_act_at_their_time, Leapfrog("loads of the end")),
    (integrator_contact.pressed_masses_rest, Leapfrog("no contact")),
    (integrator_contact.pressed_masses_rest, Leapfrog("contact moves and leaves velocities")),
    (integrator_contact.pressed_masses_rest, Leapfrog("contact force is lost")),
    (integrator_contact.contact_stops_what_falls, Leapfrog("contact force is lost")),
    (integrator_contact.friction_takes_the_energy_of_what_slides, Leapfrog("friction not booked")),
    (integrator.ledger_closes, Leapfrog("damping not booked")),
    (integrator.reaction_balances, Leapfrog("reaction of the wrong sign")),
    (integrator.reaction_balances, Leapfrog("reaction without the load")),
    (integrator.restart_is_exact, Leapfrog("start kept outside the state")),
    (integrator.refused_steps_leave_the_state, NoTakingBack()),
    (integrator.energy_is_bounded, Leapfrog("moves with the old velocity")),
    (integrator.energy_is_bounded, Leapfrog("gains speed")),
    (integrator.energy_is_bounded, Leapfrog("loses speed")),
    (integrator_contact.contact_makes_no_energy, Leapfrog("contact not booked")),
    (integrator_contact.contact_makes_no_energy, Leapfrog("gains speed")),
    (integrator.inputs_are_untouched, Leapfrog("moves the mesh")),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")  # the growth that is to be caught
def test_wrong_integrators_are_caught(caught: Any, check: Check, part: Integrator) -> None:
    caught(check, part)


ALONE = {  # flaws that nothing sees but steps from a place out of rest, or two bodies of which neither is held
    "a start out of place is forgotten": {"converges_at_its_order", "changing_steps_keep_the_order"},
    "of two free bodies one is pushed": {"bars_exchange_their_momentum"},
}


@pytest.mark.parametrize("flaw", ALONE)
def test_what_starts_out_of_place_and_free_bodies_catch_what_no_other_check_does(flaw: str) -> None:
    """All checks and runs of `contactlab check` but the ten thousand steps of one, which take longer than the rest."""
    subject = Subject(Registry(files=[FILE]), "integrator", "numpy-leapfrog", {"flaw": flaw})
    asked = [(check, subject.make()) for check in integrator.CHECKS if check is not integrator.energy_is_bounded]
    asked += [(scenario, subject) for scenario in scenarios_for("integrator")]
    failed = [outcome for outcome in (run_check(check, part) for check, part in asked) if outcome.status == "failed"]
    assert {outcome.check for outcome in failed} == ALONE[flaw], failed


REFUSED = ["keeps the clock", "gives nothing", "no work", "half a ledger", "no reaction"]


@pytest.mark.parametrize("flaw", REFUSED)
def test_steps_that_break_the_contract_are_refused_in_any_check(caught: Any, flaw: str) -> None:
    caught(integrator.the_clock_is_left_alone, Leapfrog(flaw), raises=True)


def test_a_step_that_gives_up_is_no_step(caught: Any) -> None:
    caught(integrator.the_clock_is_left_alone, Leapfrog("gives up"))


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} | {integrator.the_clock_is_left_alone} == set(integrator.CHECKS)


def test_every_duty_of_the_base_class_has_a_check() -> None:
    numbers = [int(number) for number in re.findall(r"^ *(\d+)\. ", Integrator.__doc__ or "", re.MULTILINE)]
    assert numbers == list(range(1, len(numbers) + 1)) == list(integrator.DUTIES)
    assert all(integrator.DUTIES.values())


class Dissipative(Leapfrog):
    """Says that it loses energy."""

    dissipates: ClassVar[bool] = True


def test_a_scheme_that_says_so_may_lose_energy_and_never_gain_it(caught: Any) -> None:
    integrator.energy_is_bounded(Dissipative("loses speed"))
    caught(integrator.energy_is_bounded, Dissipative("gains speed"))


@dataclass(frozen=True)
class VelocityVerlet(Leapfrog):
    """Velocities of the end of a step, which come from differences of positions: exact but for their round-off."""

    order: ClassVar[int] = 2
    velocity_lag: ClassVar[float] = 0.0

    def bind(self, equations: Any, state: State) -> Any:
        def step(dt: float) -> Step:
            u, v, mass = state["displacement"], state["velocity"], equations.mass[:, None]
            start = u.copy()
            u += dt * v
            v[:] = (u - start) / dt - 0.0 * mass
            equations.internal_force(dt)
            return Step(state["work"], state["reaction"])

        return step


def test_round_off_of_free_flight_is_no_failure() -> None:
    """Velocities from differences of displacements lose some 1e-11 in a thousand steps, which is no fault."""
    part = VelocityVerlet()
    integrator.free_flight_is_exact(part)
    model = integrator.Oscillator(part, integrator.MASS, 0.0 * integrator.STIFFNESS, velocity=integrator.START)
    model.run(1000, 0.01)
    assert 1e-14 < np.abs(model.state["velocity"] - integrator.START).max() < 1e-9
