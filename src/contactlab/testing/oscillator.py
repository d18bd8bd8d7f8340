"""Masses on springs: the smallest model for an integrator, explicit, implicit or static."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contactlab.api import (
    WORK,
    Estimate,
    ExplicitIntegrator,
    Floats,
    ImplicitIntegrator,
    Ints,
    PrescribedMotion,
    State,
    Step,
)
from contactlab.model.model import BoundIntegrator
from contactlab.parts.registry import default_registry
from contactlab.testing.floor import ExplicitFloor, ImplicitFloor, floor_shapes

AnyIntegrator = ExplicitIntegrator | ImplicitIntegrator


class Ramp:
    """Prescribed motion of some degrees of freedom: displacement = scale * time."""

    def __init__(self, dof: Ints, scale: Floats) -> None:
        self.dof, self.scale = np.asarray(dof, np.int32), np.asarray(scale, np.float64)
        self.ramp = np.zeros(len(self.dof), np.int32)
        self._values = np.zeros(1)

    def values(self, time: float) -> Floats:
        """Values of the only ramp: the time itself."""
        self._values[0] = time
        return self._values


class Oscillator:
    """N masses that springs of stiffness k (N,) hold in place. Implements `contactlab.api.ExplicitEquations` and
    `contactlab.api.ImplicitEquations`.

    force      (N, 2) load [N], or one that depends on time
    clearance  (N,) [mm] below which each mass meets a rigid floor; friction there is Coulomb's coefficient
    calls_left  of `internal_force`, after which no force is a number
    begun, accepted  lengths of the steps that were begun since one was accepted; number of steps accepted
    """

    stabilised = False  # no step fails at all lengths
    quasi_static = False

    def __init__(
        self,
        integrator: AnyIntegrator,
        mass: Floats,
        stiffness: Floats,
        *,
        velocity: Floats | None = None,
        displacement: Floats | None = None,
        damping: float = 0.0,
        relaxation: float = 0.0,
        prescribed: Ramp | None = None,
        force: Floats | Callable[[float], Floats] | None = None,
        clearance: Floats | None = None,
        friction: float = 0.0,
    ) -> None:
        n = len(mass)
        self.integrator, self.springs, self.damping = integrator, np.asarray(stiffness, float), damping
        self.mass: Floats = np.asarray(mass, float) if integrator.inertia else np.zeros(0)
        self.reference = np.stack([np.arange(n, dtype=float), np.zeros(n)], axis=1)
        self.position = self.reference.copy()
        self.relaxation = relaxation
        self.prescribed: PrescribedMotion = prescribed or Ramp(np.zeros(0, np.int32), np.zeros(0))
        self.calls_left = np.inf
        self.begun: list[float] = []
        self.accepted = 0
        self._force = force
        shapes: dict[str, tuple[int, ...]] = {"clock": (3,), "displacement": (n, 2)}
        shapes |= {"velocity": (n, 2)} if integrator.inertia else {}
        shapes |= {"drift": (n, 2)} if relaxation else {}
        shapes |= {"internal_force": (n, 2), "reaction": (n, 2), "work": (len(WORK),)}
        shapes |= floor_shapes(n, friction > 0.0) if clearance is not None else {}
        self.state = State(shapes | dict(integrator.memory(n)))
        if displacement is not None:
            self.state["displacement"][:] = displacement
        if velocity is not None and integrator.inertia:
            self.state["velocity"][:] = velocity
        self.began = self.state["displacement"].copy()
        self.contact: Any = self._floor(clearance, friction) if clearance is not None else None
        self.internal_force(0.0)
        self.initial_energy = self.kinetic_energy()
        self.bind()

    def bind(self) -> None:
        """Bind the integrator, again after the state was restored."""
        integrator: Any = self.integrator
        self.advance: Callable[[float], Step] = BoundIntegrator(integrator, self, self.state).step

    def _floor(self, clearance: Floats, friction: float) -> ExplicitFloor | ImplicitFloor:
        level = self.reference[:, 1] - clearance
        if isinstance(self.integrator, ExplicitIntegrator):
            return ExplicitFloor(level, friction, self.state)
        enforcement = default_registry().make("enforcement", self.integrator.default_enforcement)
        return ImplicitFloor(level, friction, self.state, enforcement)

    # --- what integrators see -------------------------------------------------------------------

    def internal_force(self, dt: float, share: float = 1.0) -> None:
        """Spring forces at the state's displacement, or after a share of the way there."""
        u = self.state["displacement"]
        self.position[:] = self.reference + u
        self.state["internal_force"][:] = self.springs[:, None] * (self.began + share * (u - self.began))
        if self.broken:
            self.state["internal_force"][:] = np.nan
        self.calls_left -= 1

    @property
    def broken(self) -> bool:
        """Return whether forces are NaN."""
        return self.calls_left <= 0

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill in the force, if one was given."""
        if self._force is None:
            return False
        out[:] = self._force(time) if callable(self._force) else self._force
        return True

    def stable_step(self) -> float:
        """Longest stable step 2/w_max [s] of central differences."""
        return float(2.0 / np.sqrt((self.springs / self.mass).max()))

    def begin_step(self, dt: float) -> None:
        """Springs remember nothing but where the step starts: it may be tried again from the state."""
        self.began[:] = self.state["displacement"]
        self.begun.append(dt)
        if self.contact is not None:
            self.contact.begin_step(self.reference + self.state["displacement"])

    def stiffness(self, dt: float) -> Any:
        """Stiffness of the springs, diagonal, CSC; springs of no stiffness have an entry as well."""
        from scipy.sparse import csc_array

        n = 2 * len(self.springs)
        return csc_array((np.repeat(self.springs, 2), np.arange(n), np.arange(n + 1)), (n, n))

    def add_load_stiffness(self, time: float, stiffness: Any, share: float, rate: float) -> None:
        """Add nothing: no load depends on positions or velocities."""

    def estimate(self, time: float) -> Estimate | None:
        """Return None: the end of a step is unknown before it is made."""
        return None

    def folded(self) -> bool:
        """Return `broken`, as there are no cells that could fold."""
        return self.broken

    def iterated(self) -> None:
        """Do nothing: nothing is recorded."""

    def accept(self) -> None:
        """Count it: all that changes is the state."""
        self.accepted += 1

    # --- what checks see ------------------------------------------------------------------------

    def kinetic_energy(self) -> float:
        """Kinetic energy [mJ] of the state's velocities; 0 in statics."""
        if not self.integrator.inertia:
            return 0.0
        return float(0.5 * self.mass @ (self.state["velocity"] ** 2).sum(axis=1))

    def unexplained_energy(self) -> float:
        """Kinetic energy and works that the energy balance leaves unexplained [mJ]."""
        internal, external, damping, contact, friction, numerical = self.state["work"][:6]
        change = self.kinetic_energy() - self.initial_energy + internal + damping + numerical
        return float(change - external - contact - friction)

    def run(self, steps: int, dt: float) -> Floats:
        """Displacements (steps, N, 2) after each step. Raises AssertionError if one is not accepted."""
        out = np.empty((steps, *self.state["displacement"].shape))
        for i in range(steps):
            done = self._advance_by(dt)
            if done.status.value:
                raise AssertionError(f"step {i + 1} of {steps} was not accepted: {done.reason or done.status.value}")
            out[i] = self.state["displacement"]
        return out

    def _advance_by(self, dt: float) -> Step:
        """Steps that sum to dt [s]: one, or several if the integrator requests shorter ones by `Step.longest`."""
        end, length = self.state.time + dt, dt
        while True:
            done = self.advance(length)
            rest = end - self.state.time
            if rest <= 1e-9 * dt or (done.status.value and done.longest is None):
                return done
            length = rest if done.longest is None else min(rest, done.longest)
