"""Passing a loss of equilibrium: viscous forces hold the bodies back in pseudo-time until they are at rest again.

    f(u) + (D/h) (u - u_k) = e + G^T y,   D = the diagonal of the undeformed bodies' stiffness

A load step that Newton's method cannot make is made in substeps of pseudo-time h at the load of its end (Kelley &
Keyes 1998: pseudo-transient continuation). Short substeps descend the energy from the start of the step, so that
bodies that snap, slip or are not held yet move until something holds them. h grows as long as the iteration is
easy, the viscous forces vanish with it, and the last substep has none: the end is an equilibrium to the tolerance.
Their work is the work of the jump, which bodies with inertia would turn into vibration; it is booked as numerical.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import WORK, Floats, ImplicitEquations, Iteration, Response, State
from contactlab.implicit.factor import with_diagonal
from contactlab.implicit.iteration import Outcome, take_back
from contactlab.implicit.trial import force_scale

if TYPE_CHECKING:
    from contactlab.implicit.motion import LoadStep

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
    """The viscous forces of one run's load steps.

    active     True if the present substep has viscous forces
    viscosity  (N, 2) [N/mm] D/h, 0 if displacements are given
    drift      (N, 2) [mm] by which bodies follow their supports in the first substep, without viscous resistance
    anchor     (N, 2) [mm] displacements at the start of the substep, and the drift
    """

    def __init__(self, equations: ImplicitEquations, state: State) -> None:
        self.equations, self.state = equations, state
        self.active = False
        nodes = len(equations.reference)
        self.viscosity, self.drift, self.anchor, self.before = (np.zeros((nodes, 2)) for _ in range(4))

    def solve(self, load: LoadStep, dt: float) -> Outcome:
        """Make a load step of length dt [s] in substeps; the state is undefined on failure."""
        equations, state, iteration = self.equations, self.state, load.iteration
        prescribed, size = equations.prescribed, iteration.scales.size
        end = state.time + dt
        target = prescribed.scale * prescribed.values(end)[prescribed.ramp]
        begin = state["displacement"].copy()
        stiffness, damping = self._damping(dt)
        self.drift[:] = self._carried(load, stiffness, damping, target)
        length, longest, small, accepted = FIRST * len(equations.reference), np.inf, SMALL, 0
        trace: list[Iteration] = []
        reason = f"{SUBSTEPS} substeps did not come to rest"
        self.before[:] = 0.0
        for _ in range(SUBSTEPS):
            memory = state.snapshot()
            equations.begin_step(dt)
            self.active = False
            lasts = dt if not accepted else MOMENT * dt
            load.start(lasts, end if accepted else None)
            load.time = end
            self.active = length < np.inf
            self.viscosity[:] = damping / length
            np.add(state["displacement"], self.drift, out=self.anchor)
            outcome = iteration.run(lasts, target)
            trace += outcome.trace
            if outcome.reason:
                take_back(equations, state, memory)
                small, length = (FINER * small, GROW * longest) if length == np.inf else (small, CUT * length)
                if length < SHORTEST or len(trace) > MOST * iteration.most:
                    reason = f"substeps failed: {outcome.reason}"
                    break
                continue
            left = self._left(load)
            self._book(load)
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

    def force(self) -> Floats:
        """Return viscous forces (N, 2) [N] at the trial displacements."""
        return self.viscosity * (self.anchor - self.state["displacement"])

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

    def _carried(self, load: LoadStep, stiffness: Any, damping: Floats, target: Floats) -> Floats:
        """Return the motion (N, 2) [mm] by which undeformed bodies would follow their supports."""
        u, held = self.state["displacement"].reshape(-1), self.equations.prescribed.dof
        given = np.zeros(u.size)
        given[held] = target - u[held]
        if not given.any():
            return np.zeros_like(damping)
        shifted = with_diagonal(stiffness, 1.0, SOFT * damping.reshape(-1))
        none = Response.allocate(1, 0)
        carried, _ = load.iteration.system.step(shifted, np.zeros(u.size), given, None, none, np.inf)
        return carried.reshape(damping.shape)

    def _left(self, load: LoadStep) -> float:
        """Return the largest viscous force over the largest force."""
        scales, trial = load.iteration.scales, load.iteration.trial
        return float(np.abs(self.force()).max(initial=0.0)) / force_scale(list(trial.parts), scales.floor)

    def _book(self, load: LoadStep) -> None:
        """Book the work of a substep by the trapezoidal rule, as for all other forces."""
        force, moved = self.force(), self.state["displacement"] - load.ledger.displacement
        self.state["work"][NUMERICAL] -= 0.5 * float(np.vdot(self.before + force, moved))
        self.before[:] = force
