"""Every check of integrators catches a planted defect, and a right one in plain NumPy passes all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from contactlab.api import Enforcement, Equations, ExplicitEnforcement, Integrator, State, Step, StepStatus
from contactlab.testing import integrator
from contactlab.testing.assertions import Check


@dataclass(frozen=True)
class Leapfrog(Integrator):
    """Central differences in ten lines of NumPy, with one named flaw, or none."""

    flaw: str = ""
    needs: ClassVar[type[Enforcement]] = ExplicitEnforcement
    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    explicit: ClassVar[bool] = True

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        return {"last_dt": (1,), "reaction": (nodes, 2)}

    def bind(self, equations: Equations, state: State) -> Callable[[float], Step]:
        first = [True]
        mass, held = equations.mass[:, None], equations.prescribed
        u, v, clock, last, work = (state[n] for n in ("displacement", "velocity", "clock", "last_dt", "work"))
        load = np.zeros_like(u)

        def step(dt: float) -> Step:
            mean_dt = dt if self.flaw == "no half step at the start" else 0.5 * (last[0] + dt)
            if self.flaw == "start kept outside the state":
                mean_dt = 0.5 * dt if first[0] else dt
            if self.flaw == "new step length for the velocity" and last[0] > 0.0:
                mean_dt = dt
            first[0] = False
            equations.external_force(clock[0], load)
            internal, before, alpha = state["internal_force"], v.copy(), equations.damping
            loss = 0.5 * alpha * mean_dt
            v[:] = ((1.0 - loss) * v + mean_dt * (load - internal) / mass) / (1.0 + loss)
            at = clock[0] if self.flaw == "supports lag a step" else clock[0] + dt
            v.reshape(-1)[held.dof] = (held.scale * held.values(at)[held.ramp] - u.reshape(-1)[held.dof]) / dt
            if self.flaw == "speed leaks":
                v[:] *= 1.0 - 1e-9
            mean = 0.5 * (before + v)
            need = mass * ((v - before) / mean_dt + alpha * mean) + internal - load
            reaction = np.zeros_like(u)
            reaction.reshape(-1)[held.dof] = need.reshape(-1)[held.dof]
            state["reaction"][:] = -reaction if self.flaw == "reaction of the wrong sign" else reaction
            work[0] += mean_dt * float((mean * internal).sum())
            work[1] += mean_dt * float((mean * (load + reaction)).sum())
            work[2] += mean_dt * float((alpha * mass * mean**2).sum()) * (self.flaw != "damping not booked")
            u[:] += dt * (before if self.flaw == "moves with the old velocity" else v)
            last[0] = dt
            clock[:] += dt, 0.0 if self.flaw == "steps not counted" else 1.0
            equations.internal_force(dt)
            return Step(StepStatus.gave_up if self.flaw == "says that it gave up" else StepStatus.accepted)

        return step


@pytest.mark.parametrize("check", integrator.CHECKS)
def test_a_right_integrator_passes(check: Check) -> None:
    check(Leapfrog())


class NoOrder(Leapfrog):
    """Promises nothing."""

    order: ClassVar[int] = 0


WRONG: list[tuple[Check, Integrator]] = [
    (integrator.declarations, NoOrder()),
    (integrator.converges_at_its_order, Leapfrog("no half step at the start")),
    (integrator.free_flight_is_exact, Leapfrog("speed leaks")),
    (integrator.constant_force_gives_the_parabola, Leapfrog("no half step at the start")),
    (integrator.energy_is_bounded, Leapfrog("moves with the old velocity")),
    (integrator.ledger_closes, Leapfrog("damping not booked")),
    (integrator.prescribed_motion_is_exact, Leapfrog("supports lag a step")),
    (integrator.reaction_balances, Leapfrog("reaction of the wrong sign")),
    (integrator.restart_is_exact, Leapfrog("start kept outside the state")),
    (integrator.clock_counts_steps, Leapfrog("steps not counted")),
    (integrator.clock_counts_steps, Leapfrog("says that it gave up")),
    (integrator.changing_steps_keep_the_order, Leapfrog("new step length for the velocity")),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")  # the growth that is to be caught
def test_wrong_integrators_are_caught(caught: Any, check: Check, part: Integrator) -> None:
    caught(check, part)


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} == set(integrator.CHECKS)
