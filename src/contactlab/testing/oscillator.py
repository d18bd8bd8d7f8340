"""Masses on springs: the smallest model that an integrator can be asked to advance, explicit or implicit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contactlab.api import WORK, ContactEquations, Floats, Integrator, Ints, PrescribedMotion, State, Step


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
    """N masses that springs of stiffness k (N,) hold in place. Implements `contactlab.api.Equations` and, without
    contact, `ImplicitEquations`."""

    def __init__(
        self,
        integrator: Integrator,
        mass: Floats,
        stiffness: Floats,
        *,
        velocity: Floats | None = None,
        displacement: Floats | None = None,
        damping: float = 0.0,
        prescribed: Ramp | None = None,
        force: Floats | None = None,
        contact: ContactEquations | None = None,
    ) -> None:
        n = len(mass)
        self.mass, self.springs, self.damping = np.asarray(mass, float), np.asarray(stiffness, float), damping
        self.reference = np.stack([np.arange(n, dtype=float), np.zeros(n)], axis=1)
        self.position = self.reference.copy()
        self.prescribed: PrescribedMotion = prescribed or Ramp(np.zeros(0, np.int32), np.zeros(0))
        self.contact = contact
        self._force = force
        shapes: dict[str, tuple[int, ...]] = {"clock": (2,), "displacement": (n, 2), "velocity": (n, 2)}
        shapes |= {"internal_force": (n, 2), "work": (len(WORK),)}
        if contact is not None:
            shapes["contact_force"] = (n, 2)
        self.state = State(shapes | dict(integrator.memory(n)))
        self.state["velocity"][:] = 0.0 if velocity is None else velocity
        self.state["displacement"][:] = 0.0 if displacement is None else displacement
        self.internal_force(0.0)
        self.initial_energy = self.kinetic_energy()
        self.advance: Callable[[float], Step] = integrator.bind(self, self.state)

    def internal_force(self, dt: float) -> None:
        """Spring forces at the state's displacement."""
        self.position[:] = self.reference + self.state["displacement"]
        self.state["internal_force"][:] = self.springs[:, None] * self.state["displacement"]

    def external_force(self, time: float, out: Floats) -> bool:
        """A constant force, if one was given."""
        if self._force is None:
            return False
        out[:] = self._force
        return True

    def begin(self, dt: float) -> None:
        """Springs remember nothing: every step may be tried again from the state."""

    def stiffness(self, dt: float) -> Any:
        """That of the springs, diagonal, CSC; springs of no stiffness have an entry as well."""
        from scipy.sparse import csc_array

        n = 2 * len(self.springs)
        return csc_array((np.repeat(self.springs, 2), np.arange(n), np.arange(n + 1)), (n, n))

    def add_load_stiffness(self, time: float, stiffness: Any, share: float, rate: float) -> None:
        """There are no loads."""

    def folded(self) -> bool:
        """There are no cells."""
        return False

    def accept(self) -> None:
        """Nothing but the state changes."""

    def stable_step(self) -> float:
        """Largest stable step 2/w_max [s] of the springs."""
        return float(2.0 / np.sqrt((self.springs / self.mass).max()))

    def kinetic_energy(self) -> float:
        """With the state's velocities, half a step back in explicit schemes."""
        return float(0.5 * self.mass @ (self.state["velocity"] ** 2).sum(axis=1))

    def run(self, steps: int, dt: float) -> Floats:
        """Displacements (steps, N, 2) after each step."""
        out = np.empty((steps, *self.state["displacement"].shape))
        for i in range(steps):
            self.advance(dt)
            out[i] = self.state["displacement"]
        return out
