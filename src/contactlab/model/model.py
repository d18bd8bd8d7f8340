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
from contactlab.model.history import History
from contactlab.model.loading.effect_rates import NO_EFFECTS, EffectRates
from contactlab.model.loading.supports import Prescribed, SupportedSet
from contactlab.model.momentum import start_of
from contactlab.model.timing import Timing

if TYPE_CHECKING:
    from contactlab.contact.explicit_system import ContactSystem
    from contactlab.contact.implicit_system import ImplicitContactSystem


@dataclass(frozen=True)
class Loading:
    """Loads, effects and supports of one model.

    supports  one per edge set or rigid surface that is held, in the order of the scene
    loads     calls (time, out) that add the forces [N] of a load or an effect to `out` (N, 2)
    effects   those of them that belong to effects
    rates     of the effects, which explicit steps have to follow
    """

    supports: tuple[SupportedSet, ...]
    loads: tuple[Callable[[float, Floats], None], ...]
    effects: tuple[Callable[[float, Floats], None], ...]
    rates: EffectRates = NO_EFFECTS

    @property
    def accepted(self) -> tuple[Callable[[float, float], None], ...]:
        """What to call with the end and the length [s] of each accepted step: effects that remember."""
        return tuple(effect.accept for effect in self.effects if hasattr(effect, "accept"))

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill `out` (N, 2) with the forces [N] of all loads at `time` [s]; False where the scene has none."""
        if not self.loads:
            return False
        out[:] = 0.0
        for load in self.loads:
            load(time, out)
        return True

    def reactions(self, forces: Floats) -> dict[str, Floats]:
        """Sums (2,) [N] of nodal reactions `forces` (N, 2) by support; one that several hold counts for the first."""
        return {support.on: support.force(forces) for support in self.supports}


@dataclass
class Model(ABC):
    """What `build` makes of a scene: an `ExplicitModel` or an `ImplicitModel`. Implements `contactlab.api.Equations`.

    Fields of `contactlab.api.Equations`, and beside them the bodies, the state, the integrator, the loading and the
    times of the run. `updates` are the bound block calls of all bodies. `seconds` counts the wall time spent on
    stresses and internal forces. Whoever sees something doubtful adds it to `warnings`. `way_followed` is False once a
    step has skipped what the end does not depend on: work along the path is not known then. `start` is what the end is
    compared with. `needs` fill what laws need at a time [s].
    """

    reference: Floats
    position: Floats
    mass: Floats
    prescribed: Prescribed
    contact: ContactSystem | ImplicitContactSystem | None
    state: State
    integrator: Integrator
    bodies: tuple[Body, ...]
    forces: tuple[BodyForces, ...]
    updates: tuple[Callable[[float], None], ...]
    loading: Loading
    increment: Floats | None
    timing: Timing
    history: History
    warnings: Warnings = field(default_factory=Warnings)
    way_followed: bool = True
    needs: tuple[Callable[[float], None], ...] = ()

    explicit: ClassVar[bool]

    def __post_init__(self) -> None:
        self._limits: list[StableStep] | None = None
        self.seconds = 0.0
        self.start = start_of(self)

    @property
    def initial_energy(self) -> float:
        """Kinetic energy of the start [mJ]."""
        return self.start.energy

    @property
    def damping(self) -> float:
        """Mass-proportional damping [1/s] of velocities beside the state's `drift`."""
        return self.timing.damping

    @property
    def relaxation(self) -> float:
        """Time [s] in which `drift` follows velocities; 0 where damping acts on all motion."""
        return self.timing.relaxation

    def internal_force(self, dt: float) -> None:
        """Positions, stresses, history and `internal_force` at the state's displacement."""
        began = perf_counter()
        np.add(self.reference, self.state["displacement"], out=self.position)
        if self.increment is not None:
            self._follow(dt)
        for fill in self.needs:
            fill(self.state.time + dt)
        self.state["internal_force"][:] = 0.0
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
        """Fill `out` (N, 2) with all loads [N]; False where the scene has none."""
        return self.loading.external_force(time, out)

    def stable_step(self) -> float:
        """Largest explicit step [s] of the bodies at the present geometry, without effects."""
        if self._limits is None:
            self._limits = [StableStep(forces, self.position) for forces in self.forces]
        return min(limit.limit(self.position) for limit in self._limits)

    def step_within(self, fraction: float) -> float:
        """`fraction` of the stable step of the bodies [s], or less where effects need it."""
        stable = self.stable_step()
        return min(fraction * stable, self.rates(stable).limit(stable))

    def rates(self, stable: float) -> EffectRates:
        """What explicit steps have to follow beside the bodies, whose stable step [s] is `stable`."""
        return self.loading.rates

    @property
    def step_limits(self) -> tuple[StableStep, ...]:
        """What `stable_step` follows, one per body; empty until it was asked for."""
        return tuple(self._limits or ())

    def kinetic_energy(self) -> float:
        """1/2 v M v [mJ] with the state's velocity."""
        v = self.state["velocity"]
        return float(0.5 * (self.mass @ (v[:, 0] ** 2 + v[:, 1] ** 2)))

    def reactions(self) -> dict[str, Floats]:
        """Force of each support on its body (2,) [N]; a degree of freedom that several hold counts for the first."""
        return self.loading.reactions(self.state["reaction"])
