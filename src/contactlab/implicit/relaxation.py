"""Passing a loss of equilibrium: viscous forces hold the bodies back in pseudo-time until they are at rest again.

    f(u) + (D/h) (u - u_k) = e + G^T y,   D = the diagonal of the undeformed bodies' stiffness

A load step that Newton's method cannot make is made in substeps of pseudo-time h at the load of its end (Kelley &
Keyes 1998: pseudo-transient continuation). Short substeps descend the energy from the start of the step, so that
bodies that snap, slip or are not held yet move until something holds them. h grows as long as the iteration is
easy, the viscous forces vanish with it, and the last substep has none: the end is an equilibrium to the tolerance.
Their work is the work of the jump, which bodies with inertia would turn into vibration; it is booked as numerical.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import WORK, Floats, Iteration, Response
from contactlab.implicit.factor import with_diagonal
from contactlab.implicit.iteration import Outcome, take_back
from contactlab.implicit.load_step import Drag, LoadStep
from contactlab.implicit.trial import force_scale

NUMERICAL = WORK.index("numerical")
SUBSTEPS = 80  # of a load step: convergent steps need 10 to 30
EASY = 8  # iterations of a substep after which a longer one is tried
GROW, CUT = 4.0, 0.125
FIRST = 100.0  # times the number of nodes: 1 suits single nodes among held nodes, and a bent body needs that number
SHORTEST = 1.0
MOST = 8  # times the wished iterations, in all substeps together
SMALL, FINER = 1e-3, 1e-2  # of the largest force: viscous forces below it are left out; on failure, later
SOFT = 1e-8  # of the stiffness: holds unsupported bodies, if bodies follow supports
FAR = 10.0  # sizes of the model: no rest beyond
MOMENT = 1e-9  # of the step: time for time-dependent laws in substeps after the first


class Relaxation:
    """Load steps of one run through states slowed by viscous forces.

    drag       viscosity D/h, 0 if displacements are given, and displacements at the start of the substep with the drift
    drift      (N, 2) [mm] by which bodies follow their supports in the first substep, without viscous resistance
    """

    def __init__(self, load: LoadStep) -> None:
        self.load, self.equations, self.state = load, load.equations, load.state
        nodes = len(load.equations.reference)
        self.drag, self.drift, self.before = Drag(nodes), np.zeros((nodes, 2)), np.zeros((nodes, 2))

    def solve(self, dt: float) -> Outcome:
        """Advance the state by dt of (pseudo-)time; the state is undefined on failure."""
        displacement, prediction = self.state["displacement"], self.load.prediction
        before = displacement.copy()
        try:
            outcome = self._relax(dt)
        finally:
            self.load.drag = None
        if not outcome.reason:
            outcome.motion = displacement - before
            if prediction is not None:
                prediction.moved[:] = 0.0  # a jump is not extrapolated
        return outcome

    def _relax(self, dt: float) -> Outcome:
        """Make a load step of length dt [s] in substeps."""
        load, equations, state, iteration = self.load, self.equations, self.state, self.load.iteration
        prescribed, size = equations.prescribed, iteration.scales.size
        end = state.time + dt
        target = prescribed.scale * prescribed.values(end)[prescribed.ramp]
        begin = state["displacement"].copy()
        stiffness, damping = self._damping(dt)
        self.drift[:] = self._carried(stiffness, damping, target)
        length, longest, small, accepted = FIRST * len(equations.reference), np.inf, SMALL, 0
        trace: list[Iteration] = []
        reason = f"{SUBSTEPS} substeps did not come to rest"
        self.before[:] = 0.0
        for _ in range(SUBSTEPS):
            memory = state.snapshot()
            equations.begin_step(dt)
            load.drag = None
            lasts = dt if not accepted else MOMENT * dt
            load.start(lasts, end if accepted else None)
            load.time = end
            load.drag = self.drag if length < np.inf else None
            self.drag.viscosity[:] = damping / length
            np.add(state["displacement"], self.drift, out=self.drag.anchor)
            outcome = iteration.run(lasts, target)
            trace += outcome.trace
            if outcome.reason:
                take_back(equations, state, memory)
                small, length = (FINER * small, GROW * longest) if length == np.inf else (small, CUT * length)
                if length < SHORTEST or len(trace) > MOST * iteration.most:
                    reason = f"substeps failed: {outcome.reason}"
                    break
                continue
            left = self._left()
            self._book()
            load.accept()
            accepted += 1
            self.drift[:] = 0.0
            if length == np.inf or left <= iteration.tolerance:
                return Outcome("", outcome.residual, trace)
            if float(np.abs(state["displacement"] - begin).max()) > FAR * size:
                reason = "what nothing holds moves away"
                break
            longest = length
            length = np.inf if left <= small else length * (GROW if len(outcome.trace) <= EASY else 1.0)
        return Outcome(f"stabilised: {reason}", outcome.residual, trace)

    def _damping(self, dt: float) -> tuple[Any, Floats]:
        """Return the stiffness (2N, 2N) of the undeformed bodies, and D (N, 2) [N/mm]."""
        equations, u = self.equations, self.state["displacement"]
        before = u.copy()
        equations.begin_step(dt)
        u[:] = 0.0
        equations.internal_force(dt)
        stiffness = equations.stiffness(dt).copy()
        u[:] = before
        damping = np.abs(stiffness.diagonal()).reshape(-1, 2)
        damping.reshape(-1)[equations.prescribed.dof] = 0.0
        return stiffness, damping

    def _carried(self, stiffness: Any, damping: Floats, target: Floats) -> Floats:
        """Return the motion (N, 2) [mm] by which undeformed bodies would follow their supports."""
        u, held = self.state["displacement"].reshape(-1), self.equations.prescribed.dof
        given = np.zeros(u.size)
        given[held] = target - u[held]
        if not given.any():
            return np.zeros_like(damping)
        shifted = with_diagonal(stiffness, 1.0, SOFT * damping.reshape(-1))
        none = Response.allocate(1, 0)
        carried, _ = self.load.iteration.system.step(shifted, np.zeros(u.size), given, None, none, np.inf)
        return carried.reshape(damping.shape)

    def _left(self) -> float:
        """Return the largest viscous force over the largest force."""
        scales, trial = self.load.iteration.scales, self.load.iteration.trial
        return float(np.abs(self.drag.force(trial.u)).max(initial=0.0)) / force_scale(list(trial.parts), scales.floor)

    def _book(self) -> None:
        """Book the work of a substep by the trapezoidal rule, as for all other forces."""
        displacement = self.state["displacement"]
        force, moved = self.drag.force(displacement), displacement - self.load.ledger.displacement
        self.state["work"][NUMERICAL] -= 0.5 * float(np.vdot(self.before + force, moved))
        self.before[:] = force
