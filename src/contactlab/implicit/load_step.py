"""Quasi-static load increments: prediction, iteration, and the work of every kind of force."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contactlab.api import WORK, Estimate, Floats, ImplicitEquations, State
from contactlab.implicit.factor import with_diagonal
from contactlab.implicit.free_motions import FreeMotions
from contactlab.implicit.iteration import NewtonIteration, Outcome
from contactlab.implicit.trial import Balance, ContactForces

LIMITED = 3  # shortened corrections if bodies flow as in the step before: a shorter step costs less
FARTHEST = 4.0  # times the step before: no extrapolation beyond
ALONG = 0.9  # cosine between the motions of two steps, below which the loading turns
INTERNAL, EXTERNAL, CONTACT, FRICTION, SLIP = (
    WORK.index(name) for name in ("internal", "external", "contact", "friction", "slip")
)


class Drag:
    """Viscous forces of a load step: `viscosity` (N, 2) [N/mm] times the motion back to `anchor` (N, 2) [mm]."""

    def __init__(self, nodes: int) -> None:
        self.viscosity, self.anchor = (np.zeros((nodes, 2)) for _ in range(2))

    def force(self, displacement: Floats) -> Floats:
        """Return forces (N, 2) [N] at these displacements."""
        return self.viscosity * (self.anchor - displacement)


class LoadStep(Balance):
    """Makes load increments of one run; with a `drag` forces are in balance together with it."""

    def __init__(self, equations: ImplicitEquations, state: State, tolerance: float, iterations: int) -> None:
        self.equations, self.state = equations, state
        self.external: Floats = np.zeros((len(equations.reference), 2))
        self.contact_forces = ContactForces(equations)
        self.time = 0.0
        self.iteration = NewtonIteration(equations, state, self, tolerance, iterations)
        self.iteration.system.loose = FreeMotions(equations.reference, equations.prescribed.dof)
        self.ledger = Ledger(state)
        self.prediction = Prediction(equations, state) if "moved" in state else None
        self.drag: Drag | None = None

    def of_stresses(self, diagonal: Floats) -> Floats:
        """Return the part of the `diagonal` (N, 2) [N/mm] of `stiffness` by stresses: all, as there are no masses."""
        return diagonal

    def solve(self, dt: float) -> Outcome:
        """Advance the state by dt of (pseudo-)time; the state is undefined on failure."""
        displacement = self.state["displacement"]
        before = displacement.copy()
        outcome = self._iterate(dt)
        if not outcome.reason:
            outcome.motion = displacement - before
            if self.prediction is not None:
                self.prediction.moved[:] = outcome.motion
        return outcome

    def _iterate(self, dt: float) -> Outcome:
        equations = self.equations
        equations.begin_step(dt)
        self.start(dt)
        self.time = self.state.time + dt
        prescribed = equations.prescribed
        target = prescribed.scale * prescribed.values(self.time)[prescribed.ramp]
        expected, limited = equations.estimate(self.time), None
        if expected is not None:
            self._begin_at(expected, dt, target)
        elif self.prediction is not None and self.prediction.start(dt, target, self._reachable):
            limited = LIMITED if self.prediction.flows else None
        outcome = self.iteration.run(dt, target, limited)
        if not outcome.reason:
            self.accept()
        return outcome

    def start(self, dt: float, loaded: float | None = None) -> None:
        """Set forces at the start of the step, for the energy balance; `loaded`: the time [s] of earlier loads."""
        state = self.state
        self.time = state.time if loaded is None else loaded
        # time-dependent laws have their old stress there
        timed = bool(getattr(self.equations, "needs", ()))
        self.equations.internal_force(0.0 if timed else dt)
        if self.equations.contact is not None:
            self.equations.contact.evaluate(self.equations.position)
        out = np.zeros_like(self.external)
        self.unbalanced(out)
        out.reshape(-1)[self.equations.prescribed.dof] = 0.0
        # a load that nothing carries yet grows during the step: its work follows a load path in balance
        carried = self.external - out if loaded is None else self.external
        self.ledger.begin_step(carried, self.contact_forces.normal, self.contact_forces.tangential)
        if timed:
            self.equations.internal_force(dt)

    def _begin_at(self, expected: Estimate, dt: float, target: Floats) -> None:
        """Start the iteration at an expected state, unless cells fold over there."""
        equations, contact, displacement = self.equations, self.equations.contact, self.state["displacement"]
        before = displacement.copy()
        displacement[:] = expected.displacement
        displacement.reshape(-1)[equations.prescribed.dof] = target
        if not self._reachable(before):
            displacement[:] = before
            return
        equations.internal_force(dt)
        if equations.folded() or not np.isfinite(self.state["internal_force"]).all():
            displacement[:] = before
        elif contact is not None:
            contact.evaluate(equations.position)
            conditions, y = contact.conditions, self.iteration.trial.multipliers
            np.multiply(expected.pressure, conditions.measure, out=y)
            y[:, ~conditions.present] = 0.0

    def _reachable(self, before: Floats) -> bool:
        """Return whether potentials allow the motion from the displacement `before` (N, 2) [mm] to the present one."""
        contact, now = self.equations.contact, self.state["displacement"]
        if contact is None or not contact.by_energy:
            return True
        return contact.free_share(self.equations.reference + before, now - before, np.inf) == 1.0

    def accept(self) -> None:
        """Book the step, and accept the trial as state."""
        state, contact, own = self.state, self.equations.contact, self.contact_forces
        rubbed = 0.0, 0.0
        if contact is not None:
            state["contact_force"][:] = own.total()
            rubbed = contact.friction_along_the_way()
        held = self.equations.prescribed.dof
        reaction = state["reaction"].reshape(-1)
        reaction[:] = 0.0
        forces = self.external + (state["contact_force"] if contact is not None else 0.0)
        reaction[held] = (state["internal_force"] - forces).reshape(-1)[held]
        self.ledger.end(self.external, own.normal, own.tangential, rubbed)
        self.equations.accept()

    # --- called by the iteration ------------------------------------------------------------------

    def update_stresses(self, dt: float) -> None:
        """Compute stresses at the end of the step."""
        self.equations.internal_force(dt)

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        """Fill external and contact forces minus internal forces."""
        self.equations.external_force(self.time, self.external)
        np.subtract(self.external, self.state["internal_force"], out=out)
        self.contact_forces.add_to(out)
        if self.drag is not None:
            out += self.drag.force(self.state["displacement"])
        return self.external, self.state["internal_force"], self.contact_forces.normal

    def stiffness(self, dt: float) -> Any:
        """Return the stiffness of the bodies and of follower loads."""
        matrix = self.equations.stiffness(dt)
        self.equations.add_load_stiffness(self.time, matrix, 1.0, 0.0)
        if self.drag is not None:
            return with_diagonal(matrix, 1.0, self.drag.viscosity.reshape(-1))
        return matrix


class Ledger:
    """Books the work of every kind of force over a step by the trapezoidal rule, exact for forces linear in motion.

    If surfaces begin to slide within a step, friction takes more: this excess is booked as work of loads, too.
    """

    def __init__(self, state: State) -> None:
        self.state = state
        self.before: list[Floats] = []

    def begin_step(self, external: Floats, normal: Floats, tangential: Floats) -> None:
        """Save forces and positions at the start."""
        state = self.state
        self.displacement = state["displacement"].copy()
        self.before = [state[name].copy() for name in ("internal_force", "reaction")] + [
            external.copy(),
            normal.copy(),
            tangential.copy(),
        ]

    def end(self, external: Floats, normal: Floats, tangential: Floats, slid: tuple[float, float]) -> None:
        """Book the step from there to the present state; `slid` is the result of `friction_along_the_way`."""
        state, work = self.state, self.state["work"]
        moved = state["displacement"] - self.displacement
        internal, reaction, loads, pressed, rubbed = self.before
        work[INTERNAL] += _work(internal, state["internal_force"], moved)
        work[EXTERNAL] += _work(reaction, state["reaction"], moved) + _work(loads, external, moved)
        work[CONTACT] += _work(pressed, normal, moved)
        if len(tangential):
            work[FRICTION] += _work(rubbed, tangential, moved)
        taken, excess = slid
        work[SLIP] += taken
        work[FRICTION] -= excess
        work[EXTERNAL] += excess


def _work(before: Floats, after: Floats, moved: Floats) -> float:
    return float(0.5 * np.vdot(before + after, moved))


class Prediction:
    """Start of the iteration of a load increment: with a history, bodies continue their motion of the step before.

    At the start of a step the stiffness of a law with history is elastic. A correction by it loads contact many times
    more than the step will, and most of the iterations are spent on constraints that it opened and closed wrongly.
    Continued strains make the law flow from the first iteration on (de Souza Neto, Peric & Owen 2008, 4.4).
    With friction contact finds its stick zones a little sooner. Without both, steps are long, and the motion of the
    step before opens and closes more than it saves. Works on the state's displacement in place.

    moved    (N, 2) [mm] motion of the last step, kept in the state
    flows    True if a law has a history
    follows  True if steps continue the step before: bodies flow, or there is friction
    """

    def __init__(self, equations: ImplicitEquations, state: State) -> None:
        self.equations, self.state = equations, state
        self.moved = state["moved"]
        self.flows = any(name.startswith("history.") for name in state.fields)
        self.follows = self.flows or (equations.contact is not None and len(equations.contact.conditions.slip) > 0)
        self.load: Floats = np.zeros_like(self.moved)

    def start(self, dt: float, target: Floats, reachable: Callable[[Floats], bool] = lambda before: True) -> bool:
        """Extrapolate to the end of a step of length dt [s] with prescribed displacements `target` (p,) [mm].

        `reachable` returns whether the state may go there directly from a displacement (N, 2) [mm].

        Returns False if the state is unchanged: no flow, no step before, or loading that turns.
        """
        ratio = self._ratio(dt, target) if self.follows and self.state.last_dt else 0.0
        if not 0.0 < ratio <= FARTHEST:
            return False
        u = self.state["displacement"]
        before = u.copy()
        u += ratio * self.moved
        u.reshape(-1)[self.equations.prescribed.dof] = target
        if not reachable(before):
            u[:] = before
            return False
        self.equations.internal_force(dt)
        if self.equations.folded():
            u[:] = before
            return False
        return True

    def _ratio(self, dt: float, target: Floats) -> float:
        """Return the ratio of the step to the last step: by prescribed motion, or by loads if nothing is moved."""
        held = self.equations.prescribed.dof
        ahead = target - self.state["displacement"].reshape(-1)[held]
        ratio = _along(ahead, self.moved.reshape(-1)[held])
        if ratio is not None:
            return ratio
        now = self.state.time
        before, at, after = (self._load(time) for time in (now - self.state.last_dt, now, now + dt))
        return _along((after - at).ravel(), (at - before).ravel()) or 0.0

    def _load(self, time: float) -> Floats:
        self.load[:] = 0.0
        self.equations.external_force(time, self.load)
        return self.load.copy()


def _along(ahead: Floats, behind: Floats) -> float | None:
    """Return the ratio of `ahead` to `behind`; 0 if their directions differ, None without any."""
    size = float(behind @ behind)
    if size == 0.0:
        return None
    along = float(ahead @ behind)
    return along / size if along > ALONG * float(np.sqrt(size * (ahead @ ahead))) else 0.0
