"""Steps around an impact: a step ends when surfaces meet, and the next steps resolve its waves.

Contact forces act in the whole of a step in which surfaces meet, and take the work y . g of gaps g that were open at
its start; the midpoint rule then spreads fronts over several steps and lets surfaces part too early. A step in which
surfaces meet with more than `SHARE` of the kinetic energy is therefore cut to end when they meet, and the next steps
are halved until the change of elastic forces in a step,

    r = dt/12 |M^-1 (f+ - f)| / |v|,   |a|^2 = a . M a

the leading error of the midpoint rule in velocities, is below `TOLERANCE` of the velocity before the impact, or waves
pass no more than `COURANT` cells in a step. r falls with the square of the step in a smooth contact, and with its root
behind a front.
"""

from __future__ import annotations

import numpy as np

from contactlab.api import WORK, Floats, ImplicitEquations, State

SHARE = 2e-3  # of the kinetic energy: least contact work in a step that counts as an impact
SLIGHT = 1e-4  # of the largest kinetic energy so far: smaller impacts are ignored
TOLERANCE = 4e-3  # of the velocity before the impact
REPEAT = 3.0  # tolerances: an error above is not accepted
GROW = 1.0 / 6.0  # tolerances: with an error below the next step may be twice as long
COURANT = 0.5  # cells that a wave passes in the shortest step
SHORTEST = 1e-3  # of a step: a shorter rest before surfaces meet gets no step of its own
LARGEST, LIMIT, ENERGY = range(3)
INTERNAL = WORK.index("internal")


def impacts_of(equations: ImplicitEquations) -> bool:
    """Return whether contact is exact: springs and potentials store energy and return it."""
    contact = equations.contact
    return contact is not None and contact.enforcement.exact and not contact.by_energy


def resolve_waves(state: State, mass: Floats, dt: float) -> None:
    """Let the next steps, from dt [s] on, resolve waves as after an impact, for a load that drops at once.

    mass  (N,) [t]
    """
    if "impact" in state:
        kinetic = 0.5 * float((mass * (state["velocity"] ** 2).sum(axis=1)).sum())
        # what bodies have stored becomes motion
        state["impact"][LIMIT:] = dt, kinetic + abs(float(state["work"][INTERNAL]))


class Impacts:
    """Judges steps with contact, and limits the next length.

    memory  (3,) of the state: largest kinetic energy so far, longest step (0: any), kinetic energy before the
            impact (or energy before the drop of a load)
    """

    def __init__(self, state: State, mass: Floats, mobility: Floats) -> None:
        self.state, self.mass, self.mobility = state, mass, mobility
        self.memory = state["impact"]
        self.before: Floats = np.zeros_like(mass)
        self.kinetic = self.stored = self.dt = 0.0
        self.pressed = False

    def begin(self, dt: float) -> None:
        """Save the state at the start of a step of length dt [s]."""
        state, v = self.state, self.state["velocity"]
        self.dt, self.before[:] = dt, state["internal_force"]
        self.kinetic = 0.5 * float(np.vdot(self.mass * v, v))
        self.memory[LARGEST] = max(float(self.memory[LARGEST]), self.kinetic)
        # work of supports if they had pushed like this from the start: driven motion is no impact
        driven = state.time * abs(float(np.vdot(state["reaction"], v)))
        self.stored = abs(float(state["work"][INTERNAL])) + driven

    def met(self, normal: Floats, velocity: Floats, moved: Floats) -> float | None:
        """Return the length of a step that ends when surfaces meet; None if this step need not be cut.

        normal    (N, 2) [N] contact forces of the step
        velocity  (N, 2) [mm/s] at its start; `moved` (N, 2) [mm] displacements in it
        """
        self.pressed = bool(normal.any())
        if not self.pressed:
            return None
        work = -float(np.vdot(normal, moved))
        closing = max(-float(np.vdot(normal, velocity)) * self.dt, work)
        least = SHARE * max(self.kinetic, self.stored)
        # bodies at rest that are set in motion have round-off of it before
        if closing <= least or self.kinetic <= SLIGHT * max(float(self.memory[LARGEST]), closing):
            return None
        share = min(work / closing, 0.9)
        if work > least and share > SHORTEST:
            return self.dt * share
        if self.memory[LIMIT] == 0.0:
            self.memory[LIMIT], self.memory[ENERGY] = self.dt, self.kinetic
        return None

    def limit(self, diagonal: Floats) -> tuple[float | None, bool]:
        """Return the longest next step, None for any; and whether this step is to be repeated with it.

        diagonal  (N, 2) [N/mm] of the stiffness in this step
        """
        memory, dt = self.memory, self.dt
        if memory[LIMIT] == 0.0:
            return None, False
        before, error = float(memory[LIMIT]), 0.0
        if self.pressed:
            change = (self.state["internal_force"] - self.before) ** 2 * self.mobility
            error = dt / 12.0 * float(np.sqrt(change.sum() / (2.0 * memory[ENERGY]))) / TOLERANCE
            nodal = diagonal.sum(axis=1, keepdims=True)  # upper bound; for one axis it would depend on the frame
            rate = float((change * self.mobility * nodal).sum()) / max(float(change.sum()), 1e-300)
            shortest = COURANT * float(np.sqrt(2.0 / max(rate, 1e-300)))
            if error > 1.0:
                repeat = error > REPEAT and dt > shortest
                share = 0.5 ** (np.ceil(np.log2(error)) if repeat else 1.0)
                memory[LIMIT] = min(before, max(shortest, share * dt))
                return float(memory[LIMIT]), repeat
        if error < GROW:
            if dt < before * (1.0 - 1e-9):
                memory[LIMIT] = 0.0  # steps as in the scene
                return None, False
            memory[LIMIT] = max(before, 2.0 * dt)
        return float(memory[LIMIT]), False
