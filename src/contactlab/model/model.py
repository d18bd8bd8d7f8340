"""A model: everything a run needs, bound once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from contactlab.api import Floats, Integrator, State, Warnings
from contactlab.model.bodies.body import Body, BodyForces
from contactlab.model.bodies.stable_step import StableStep
from contactlab.model.bound_integrator import BoundIntegrator
from contactlab.model.loading.supports import Prescribed, SupportedSet
from contactlab.model.pace import Pace

if TYPE_CHECKING:
    from contactlab.model.contact.explicit_system import ContactSystem
    from contactlab.model.contact.implicit_system import ImplicitContactSystem


@dataclass
class Model(ABC):
    """What `build` makes of a scene: an `ExplicitModel` or an `ImplicitModel`. Implements `contactlab.api.Equations`.

    Fields of `contactlab.api.Equations`, and beside them the bodies, the state, the integrator and
    the supports by name. `updates` are the bound block calls of all bodies, `loads` those of loads and effects,
    `effects` the latter alone.
    `seconds` counts the wall time spent on stresses and internal forces. Whoever sees something doubtful adds it to
    `warnings`.
    """

    reference: Floats
    position: Floats
    mass: Floats
    prescribed: Prescribed
    contact: ContactSystem | ImplicitContactSystem | None
    damping: float
    relaxation: float
    state: State
    integrator: Integrator
    bodies: tuple[Body, ...]
    forces: tuple[BodyForces, ...]
    supports: tuple[SupportedSet, ...]
    updates: tuple[Callable[[float], None], ...]
    loads: tuple[Callable[[float, Floats], None], ...]
    effects: tuple[Callable[[float, Floats], None], ...]
    increment: Floats | None
    pace: Pace
    warnings: Warnings = field(default_factory=Warnings)

    explicit: ClassVar[bool]

    def __post_init__(self) -> None:
        self._internal = self.state["internal_force"]
        self._displacement: Floats = self.state["displacement"]
        self._velocity: Any = self.state.fields.get("velocity")  # None in statics, which asks for none of its uses
        self._limits: list[StableStep] | None = None
        self.seconds = 0.0
        self.initial_energy = self.kinetic_energy() if "velocity" in self.state else 0.0

    def internal_force(self, dt: float) -> None:
        """Positions, stresses, history and `internal_force` at the state's displacement."""
        began = perf_counter()
        np.add(self.reference, self._displacement, out=self.position)
        if self.increment is not None:
            self._follow(dt)
        self._internal[:] = 0.0
        for update in self.updates:
            update(dt)
        self.seconds += perf_counter() - began

    @abstractmethod
    def _follow(self, dt: float) -> None:
        """Displacement increments that led here, for laws in rate form."""

    @abstractmethod
    def bound_integrator(self, seen: Any = None) -> BoundIntegrator:
        """What makes the steps of a run; `seen` is what the integrator sees in place of this model."""

    @abstractmethod
    def lagging_work(self) -> float:
        """Work of the stresses [mJ] between the time of the velocities and that of the positions."""

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill `out` with all loads; False where the scene has none."""
        if not self.loads:
            return False
        out[:] = 0.0
        for load in self.loads:
            load(time, out)
        return True

    def stable_step(self) -> float:
        """Largest explicit step [s] at the present geometry."""
        if self._limits is None:
            self._limits = [StableStep(forces, self.position) for forces in self.forces]
        return min(limit.limit(self.position) for limit in self._limits)

    @property
    def step_limits(self) -> tuple[StableStep, ...]:
        """What `stable_step` follows, one per body; empty until it was asked for."""
        return tuple(self._limits or ())

    def kinetic_energy(self) -> float:
        """1/2 v M v [mJ] with the state's velocity."""
        v = self._velocity
        return float(0.5 * (self.mass @ (v[:, 0] ** 2 + v[:, 1] ** 2)))

    def reactions(self) -> dict[str, Floats]:
        """Force of each support on its body (2,) [N]; a degree of freedom that several hold counts for the first."""
        reaction = self.state["reaction"]
        return {support.on: support.force(reaction) for support in self.supports}
