"""One quasi-static load step: iterate, then book what it did, or leave the state as it was."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Floats, ImplicitEquations, State, Step, StepStatus
from contactlab_statics.iteration import NewtonIteration, take_back
from contactlab_statics.ledger import Ledger


class LoadStep:
    """Implements `Balance` for statics."""

    dynamic = False

    def __init__(self, equations: ImplicitEquations, state: State, tolerance: float, iterations: int) -> None:
        self.equations, self.state = equations, state
        nodes = len(equations.reference)
        self.external: Floats = np.zeros((nodes, 2))
        self.normal, self.tangential = np.zeros((nodes, 2)), np.zeros((nodes if _friction(equations) else 0, 2))
        self.time = 0.0
        self.iteration = NewtonIteration(equations, state, self, tolerance, iterations)
        self.ledger = Ledger(state)

    def step(self, dt: float) -> Step:
        """Advance the state by dt of (pseudo-)time, or restore it."""
        equations, state = self.equations, self.state
        start = state.snapshot()
        equations.begin(dt)
        self._start(dt)
        self.time = state.time + dt
        prescribed = equations.prescribed
        target = prescribed.scale * prescribed.values(self.time)[prescribed.ramp]
        outcome = self.iteration.run(dt, target)
        if outcome.reason:
            take_back(equations, state, start)
            return Step(
                status=StepStatus.not_converged, iterations=len(outcome.trace), residual=outcome.residual.largest,
                reason=outcome.reason, trace=tuple(outcome.trace),
            )  # fmt: skip
        self._accept(dt)
        return Step(
            state["work"], state["reaction"], iterations=len(outcome.trace), residual=outcome.residual.contact,
            trace=tuple(outcome.trace),
        )  # fmt: skip

    def _start(self, dt: float) -> None:
        """Forces at the start of the step, for the ledger."""
        state = self.state
        self.time = state.time
        self.equations.internal_force(dt)
        if self.equations.contact is not None:
            self.equations.contact.evaluate(self.equations.position)
        self.unbalanced(np.zeros_like(self.external))
        self.ledger.begin(self.external, self.normal, self.tangential)

    def _accept(self, dt: float) -> None:
        state, contact = self.state, self.equations.contact
        slip = 0.0
        if contact is not None:
            state["contact_force"][:] = self.normal
            if len(self.tangential):
                state["contact_force"][:] += self.tangential
                slip = -float(contact.conditions.force[1] @ contact.conditions.slip)
        held = self.equations.prescribed.dof
        reaction = state["reaction"].reshape(-1)
        reaction[:] = 0.0
        forces = self.external + (state["contact_force"] if contact is not None else 0.0)
        reaction[held] = (state["internal_force"] - forces).reshape(-1)[held]
        self.ledger.end(self.external, self.normal, self.tangential, slip)
        self.equations.accept()

    # --- Balance --------------------------------------------------------------------------------

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """External and contact forces minus internal ones."""
        self.equations.external_force(self.time, self.external)
        np.subtract(self.external, self.state["internal_force"], out=out)
        if self.equations.contact is not None:
            self.equations.contact.forces(self.normal, self.tangential)
            out += self.normal
            if len(self.tangential):
                out += self.tangential
        return self.external, self.state["internal_force"], self.normal

    def stiffness(self, dt: float) -> Any:
        """That of the bodies and of loads that follow them."""
        matrix = self.equations.stiffness(dt)
        self.equations.add_load_stiffness(self.time, matrix, 1.0, 0.0)
        return matrix


def _friction(equations: ImplicitEquations) -> bool:
    return equations.contact is not None and len(equations.contact.conditions.slip) > 0
