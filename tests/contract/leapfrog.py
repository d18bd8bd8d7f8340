"""A leapfrog in plain NumPy that keeps all duties of an integrator, or forgets one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import ExplicitEquations, ExplicitIntegrator, State, Step, StepStatus
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Leapfrog(ExplicitIntegrator):
    """Central differences with contact, and one named flaw, or none."""

    flaw: str = ""
    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        return {"own": (1,)}

    def bind(self, equations: ExplicitEquations, state: State) -> Callable[[float], Step]:
        return _Run(self.flaw, equations, state).step


class _Run:
    def __init__(self, flaw: str, equations: ExplicitEquations, state: State) -> None:
        self.flaw, self.equations, self.state = flaw, equations, state
        self.mass = np.maximum(equations.mass[:, None], 1e-300)  # 0 on rigid surfaces, where all is prescribed
        self.free = np.repeat(equations.mass > 0.0, 2)
        self.free[equations.prescribed.dof] = False
        self.load, self.steps = np.zeros_like(state["displacement"]), 0

    def step(self, dt: float) -> Any:
        flaw, equations, state = self.flaw, self.equations, self.state
        u, v, mass, alpha = state["displacement"], state["velocity"], self.mass, equations.damping
        mean_dt = self._mean_dt(dt)
        loss = 0.5 * alpha * mean_dt
        loaded = equations.external_force(state.time + dt * (flaw == "loads of the end"), self.load)
        load = self.load if loaded else 0.0 * self.load
        before, internal = v.copy(), state["internal_force"]
        if flaw == "a start out of place is forgotten" and state.step == 0:
            internal = 0.0 * internal
        v[:] = ((1.0 - loss) * v + mean_dt * (load - internal) / mass) / (1.0 + loss)
        held = equations.prescribed
        at = state.time if flaw == "supports lag a step" else state.time + dt
        v.reshape(-1)[held.dof] = (held.scale * held.values(at)[held.ramp] - u.reshape(-1)[held.dof]) / dt
        touch, rubbed, dissipated = self._contact(dt, mean_dt, loss, before)
        v *= {"speed leaks": 1.0 - 1e-9, "gains speed": 1.0 + 1e-6, "loses speed": 1.0 - 1e-5}.get(flaw, 1.0)
        mean = 0.5 * (before + v)
        reaction = np.zeros_like(u)
        need = mass * ((v - before) / mean_dt + alpha * mean) + internal - load - touch
        if flaw == "reaction without the load":
            need += load
        reaction.reshape(-1)[held.dof] = need.reshape(-1)[held.dof]
        work = state["work"].copy()
        work[0] += mean_dt * np.vdot(mean, internal)
        work[1] += mean_dt * np.vdot(mean, load + reaction)
        work[2] += mean_dt * np.vdot(alpha * mass * mean, mean) * (flaw != "damping not booked")
        work[3] += (mean_dt * np.vdot(mean, touch) - rubbed) * (flaw != "contact not booked")
        work[4] += rubbed * (flaw != "friction not booked")
        work[6] += dissipated
        u += dt * (before if flaw == "moves with the old velocity" else v)
        if flaw != "forces of the start":
            equations.internal_force(dt)
        return self._done(dt, work, reaction)

    def _mean_dt(self, dt: float) -> float:
        """From the middle of the last step to that of this one; half a step at the start, where v is that of t = 0."""
        last, self.steps, own = self.state.last_dt, self.steps + 1, self.state["own"]
        if self.flaw == "start kept outside the state":
            return 0.5 * dt if self.steps == 1 else dt
        if self.flaw == "start kept in the state":
            last, own[0] = float(own[0]), dt
        if self.flaw == "no half step at the start":
            return dt
        if self.flaw == "new step length for the velocity" and last > 0.0:
            return dt
        return 0.5 * (last + dt)

    def _contact(self, dt: float, mean_dt: float, loss: float, before: Any) -> Any:
        contact, state = self.equations.contact, self.state
        if contact is None or self.flaw == "no contact":
            return np.zeros_like(before), 0.0, 0.0
        u, v, touch = state["displacement"], state["velocity"], state["contact_force"]
        compliance = dt * mean_dt / (1.0 + loss) / self.mass * self.free.reshape(-1, 2)
        contact.solve(
            self.equations.reference + state["displacement"] + dt * v, self.equations.position, compliance, touch
        )
        if self.flaw == "contact moves and leaves velocities":
            u += compliance * touch
        else:
            v += compliance * (touch * self._pushed(touch)) / dt
        rubbed, dissipated = contact.friction_work(0.5 * (before + v), mean_dt, compliance, touch)
        pushed = touch.copy()
        if self.flaw == "contact force is lost":
            touch[:] = 0.0
        return pushed, rubbed, dissipated

    def _pushed(self, touch: Any) -> Any:
        """Which nodes (N, 1) contact moves: all, or none against the first where nothing is held along x."""
        if self.flaw != "of two free bodies one is pushed" or np.any(self.equations.prescribed.dof % 2 == 0):
            return True
        first = touch[np.argmax(np.abs(touch).sum(axis=1) > 0.0)]
        return (touch @ first >= 0.0)[:, None]

    def _done(self, dt: float, work: Any, reaction: Any) -> Any:
        flaw, state = self.flaw, self.state
        if flaw == "keeps the clock":
            state["clock"][:2] += dt, 1.0
        if flaw == "moves the mesh":
            self.equations.reference[:] += 1e-9
        if flaw == "gives nothing":
            return None
        return Step(
            work=None if flaw == "no work" else work[:5] if flaw == "half a ledger" else work,
            reaction=None if flaw == "no reaction" else -reaction if flaw == "reaction of the wrong sign" else reaction,
            status=StepStatus.gave_up if flaw == "gives up" else StepStatus.accepted,
        )


@hookimpl
def contactlab_parts() -> list[Part]:
    return [Part("integrator", "numpy-leapfrog", "leapfrog:Leapfrog", "central differences in plain NumPy")]
