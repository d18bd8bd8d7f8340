"""A run that is looked at between any two steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contactlab.api import Floats
from contactlab.contact.explicit_system import ContactSystem
from contactlab.model.build import build
from contactlab.run.guards import EVERY, Guards
from contactlab.run.schedule import Schedule
from contactlab.scene.scene import Scene


class WatchedRun:
    """The steps of a scene, one by one. Raises SimulationFailure where a run of the scene would end, if `guarded`."""

    def __init__(self, scene: Scene, guarded: bool = True) -> None:
        self.guarded = guarded
        self.scene, self.model = scene, build(scene, scene.registry)
        self.state = self.model.state
        self.schedule, self.guards = Schedule(self.model, scene), Guards(self.model)
        self.advance = self.model.bound_integrator().step
        self.sweeps, self.most_sweeps = 0, 0

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self.state.time

    @property
    def dt(self) -> float:
        """Length of the next step [s]."""
        return self.schedule.dt

    @property
    def contact(self) -> ContactSystem:
        """All contacts of the scene."""
        assert isinstance(self.model.contact, ContactSystem)
        return self.model.contact

    def step(self) -> None:
        """Make one step."""
        step = self.advance(self.schedule.dt)
        self.sweeps += step.sweeps
        self.most_sweeps = max(self.most_sweeps, step.sweeps)
        if self.guarded:
            self.guards.after_step(step)
        if self.guarded and self.state.step % EVERY == 0:
            self.guards.check()
            self.schedule.adapt()

    def until(self, time: float, look: Callable[[], None] | None = None, every: int = 1) -> None:
        """Step until `time` [s] is reached; `look` is called after each `every` steps."""
        while self.time < time - 0.5 * self.dt:
            self.step()
            if look is not None and self.state.step % every == 0:
                look()

    def nodes(self, body: str) -> slice:
        """Numbers of the nodes of a body."""
        found = next(b for b in self.model.bodies if b.name == body)
        return slice(found.first, found.first + found.count)

    def mean(self, field: Floats, body: str) -> Floats:
        """Mean by mass of a nodal field (N, 2) over a body."""
        own = self.nodes(body)
        mass = self.model.mass[own]
        return np.asarray(mass @ field[own] / mass.sum())

    def force_on(self, body: str) -> Floats:
        """Contact force (2,) [N] on a body in the last step."""
        return np.asarray(self.state["contact_force"][self.nodes(body)].sum(axis=0))

    def momentum(self) -> Floats:
        """Linear momentum (2,) of all bodies."""
        return np.asarray(self.model.mass @ self.state["velocity"])

    def angular_momentum(self) -> float:
        """About the origin, with positions half a step after the velocities, which leapfrog keeps exactly."""
        r, v = self.model.position, self.state["velocity"]
        return float(self.model.mass @ (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0]))

    def energy(self) -> float:
        """Kinetic and stored energy [mJ] of all bodies."""
        return self.model.kinetic_energy() + sum(forces.stored_energy() for forces in self.model.forces)

    def tilt(self, body: str) -> float:
        """Angle [rad] by which a body is turned: of the rotation nearest to its deformation."""
        own = self.nodes(body)
        mass = self.model.mass[own][:, None]
        before, now = (x[own] - self.mean(x, body) for x in (self.model.reference, self.model.position))
        covariance = (mass * now).T @ before
        return float(np.arctan2(covariance[1, 0] - covariance[0, 1], covariance[0, 0] + covariance[1, 1]))
