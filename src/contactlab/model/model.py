"""A model: everything a run needs, bound once; its integrator at work; the model for explicit integrators."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from contactlab.api import (
    ExplicitIntegrator,
    Floats,
    ImplicitIntegrator,
    Integrator,
    Ints,
    State,
    Step,
    StepStatus,
    Warnings,
)
from contactlab.api.integrator import LEAPFROG
from contactlab.errors import SimulationFailure, WrongAnswer
from contactlab.model.bodies.body import Body, BodyForces
from contactlab.model.bodies.stable_step import StableStep
from contactlab.model.history import History
from contactlab.model.loading.effect_rates import NO_EFFECTS, EffectRates
from contactlab.model.loading.supports import Prescribed, SupportedSet
from contactlab.model.momentum import Start
from contactlab.model.timing import Timing

if TYPE_CHECKING:
    from contactlab.contact.explicit_system import ContactSystem
    from contactlab.contact.implicit_system import ImplicitContactSystem
    from contactlab.contact.work_split import WorkSplit


USUAL = 0.9  # default of time.fraction

StepCall = Callable[[float, float], None]
"""Called with the end and the length [s] of a step."""


@dataclass(frozen=True)
class Loading:
    """Loads, effects and supports of one model.

    supports  one per supported edge set or rigid surface, in the order of the scene
    loads     calls (time, out) that add the forces [N] of a load or an effect to `out` (N, 2)
    effects   the loads that belong to effects
    rates     rates of the effects, which limit explicit steps
    """

    supports: tuple[SupportedSet, ...]
    loads: tuple[Callable[[float, Floats], None], ...]
    effects: tuple[Callable[[float, Floats], None], ...]
    rates: EffectRates = NO_EFFECTS


@dataclass
class Model(ABC):
    """Model of a scene: an `ExplicitModel` or an `ImplicitModel`. Implements `contactlab.api.Equations`.

    Fields of `contactlab.api.Equations`, and also the bodies, the state, the integrator, the loading and the
    times of the run. `updates` are the bound block calls of all bodies. `seconds` counts the wall time spent on
    stresses and internal forces. Any code with doubts adds them to `warnings`. `way_followed` is False once a
    step has skipped history that the end does not depend on: work along the path is unknown then. `start` is the
    reference for the end. `needs` fill the numbers that laws need at a time [s]. `split` sums the work of contact by
    its sources, if the scene asks for it. `mirror` (N,) is the node at the mirror image in x = 0 of each node, -1
    without one, if the scene declares symmetry.
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
    split: WorkSplit | None = None
    mirror: Ints | None = None

    explicit: ClassVar[bool]

    def __post_init__(self) -> None:
        self._limits: list[StableStep] | None = None
        self.seconds = 0.0
        moves = "velocity" in self.state
        self.start = Start(self.kinetic_energy(), self.momenta()) if moves else Start(0.0, np.zeros(4))

    @property
    def initial_energy(self) -> float:
        """Kinetic energy of the start [mJ]."""
        return self.start.energy

    @property
    def damping(self) -> float:
        """Mass-proportional damping [1/s] of velocities relative to the state's `drift`."""
        return self.timing.damping

    @property
    def relaxation(self) -> float:
        """Time constant [s] with which `drift` follows velocities; 0 if damping acts on all motion."""
        return self.timing.relaxation

    def internal_force(self, dt: float) -> None:
        """Update positions, stresses, history and `internal_force` to the state's displacement."""
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

    def make_constraints(self) -> None:
        """Make the constraints of contact at the present positions, for a state that was not reached by a step."""
        for pair in self.contact.passes if self.contact is not None else ():
            pair.update(self.position, pair.memory_in(self.state).copy())

    @abstractmethod
    def _follow(self, dt: float) -> None:
        """Update displacement increments of the step, for laws in rate form."""

    def bound_integrator(self, seen: Any = None) -> BoundIntegrator:
        """Return what makes the steps of a run; the integrator works on `seen`, or on this model."""
        integrator: Any = self.integrator
        equations = self if seen is None else seen
        accepted = tuple(effect.accept for effect in self.loading.effects if hasattr(effect, "accept"))  # with memory
        if (contact := self.contact) is None:
            return BoundIntegrator(integrator, equations, self.state, (), accepted)
        return BoundIntegrator(integrator, equations, self.state, contact.begin, (*contact.follow, *accepted))

    @abstractmethod
    def lagging_work(self) -> float:
        """Return the work of the stresses [mJ] between the times of velocities and positions."""

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill `out` (N, 2) with all loads [N]; False if the scene has none."""
        if not self.loading.loads:
            return False
        out[:] = 0.0
        for load in self.loading.loads:
            load(time, out)
        return True

    def stable_step(self) -> float:
        """Return the largest explicit step [s] of the bodies at the present geometry, without effects."""
        if self._limits is None:
            self._limits = [StableStep(forces, self.position) for forces in self.forces]
        return min(limit.limit(self.position) for limit in self._limits)

    def step_within(self, fraction: float) -> float:
        """Return `fraction` of the stable step of the bodies [s], or less if effects and contact pressures need it.

        Their limit has margins of its own, which fractions below the default of the scene increase.
        """
        stable = self.stable_step()
        return min(fraction * stable, min(1.0, fraction / USUAL) * self.rates(stable).limit(stable))

    def rates(self, stable: float) -> EffectRates:
        """Return what limits explicit steps in addition to the bodies with stable step `stable` [s]."""
        return self.loading.rates

    @property
    def step_limits(self) -> tuple[StableStep, ...]:
        """Limits behind `stable_step`, one per body; empty before its first call."""
        return tuple(self._limits or ())

    def kinetic_energy(self) -> float:
        """Return 1/2 v M v [mJ] with the state's velocity."""
        v = self.state["velocity"]
        return float(0.5 * (self.mass @ (v[:, 0] ** 2 + v[:, 1] ** 2)))

    def momenta(self) -> Floats:
        """Return momentum along x and y [N s], about the origin [N mm s], and the sum of nodal magnitudes [N s], (4,).

        A leapfrog keeps the first three exactly: the displacement of a step is along the velocity before.
        """
        position, along = self.reference + self.state["displacement"], self.mass[:, None] * self.state["velocity"]
        turning = (position[:, 0] * along[:, 1] - position[:, 1] * along[:, 0]).sum()
        return np.array([*along.sum(axis=0), turning, np.hypot(*along.T).sum()])

    @property
    def shown_conditions(self) -> int:
        """Number of the contact constraints in reports, which come first."""
        return self.contact.pairs[-1].own.stop if self.contact is not None else 0

    def reactions(self) -> dict[str, Floats]:
        """Return the force of each support on its body (2,) [N]; shared degrees of freedom count for the first."""
        return {support.on: support.force(self.state["reaction"]) for support in self.loading.supports}


@dataclass
class ExplicitModel(Model):
    """Implements `contactlab.api.ExplicitEquations`."""

    contact: ContactSystem | None
    integrator: ExplicitIntegrator

    explicit: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        leaps = self.integrator.velocity_lag == LEAPFROG
        self._before = None if self.increment is None or leaps else self.state["displacement"].copy()

    def rates(self, stable: float) -> EffectRates:
        """Return the rates of the effects, and of contact pressures."""
        rates = super().rates(stable)
        more = 0.0 if self.contact is None else self.contact.rate(stable)
        return replace(rates, square=rates.square + more) if more else rates

    def moved_back(self) -> None:
        """Take the displacement of a restored state as the start of the next step."""
        if self._before is not None:
            self._before[:] = self.state["displacement"]

    def _follow(self, dt: float) -> None:
        if self._before is None:
            np.multiply(self.state["velocity"], dt, out=self.increment)
        else:
            np.subtract(self.state["displacement"], self._before, out=self.increment)
            self._before[:] = self.state["displacement"]

    def lagging_work(self) -> float:
        """Return the work of the stresses [mJ] between the times of velocities and positions."""
        lag = self.integrator.velocity_lag * self.state.last_dt
        return lag * float(np.vdot(self.state["velocity"], self.state["internal_force"]))


class BoundIntegrator:
    """Makes steps of `state` by an integrator, and stores their energy balance, reactions and time.

    advance  result of its `bind`: by default of `contactlab.model.motion.ExplicitMotion`, or in statics and
             implicit dynamics of `contactlab.implicit.motion.SolvedMotion`
    begin    functions called with the end and the length [s] of each step before it
    follow   functions called with the end and the length [s] of each accepted step
    """

    def __init__(
        self,
        integrator: ExplicitIntegrator | ImplicitIntegrator,
        equations: Any,
        state: State,
        begin: tuple[StepCall, ...] = (),
        follow: tuple[StepCall, ...] = (),
    ) -> None:
        self.name, self.advance = type(integrator).__name__, integrator.bind(equations, state)
        self.begin, self.follow = begin, follow
        self.clock, self.work, self.reaction = state["clock"], state["work"], state["reaction"]
        self.error = state["step_error"] if "step_error" in state else None

    def step(self, dt: float) -> Step:
        """Make one step of length dt [s], and check its result.

        Raises WrongAnswer if the integrator breaks the contract, and SimulationFailure if the clock would
        stand, so that a run never ends.
        """
        clock = self.clock
        time, count = float(clock[0]), float(clock[1])
        after = time + dt
        if not time < after < math.inf:
            _refuse_step(count, time, dt)
        for prepare in self.begin:
            prepare(after, dt)
        done = self.advance(dt)  # by default `SolvedMotion.advance`, in explicit runs `ExplicitMotion.advance`
        if type(done) is not Step:
            raise WrongAnswer(f"{self.name}: its step gave {type(done).__name__}, needed: Step")
        if clock[0] != time or clock[1] != count:
            raise WrongAnswer(f"{self.name}: its step wrote the clock, which is the core's; needed: leave it alone")
        if done.status is StepStatus.accepted:
            # an integrator that books in place needs no copy
            if done.work is not self.work:
                self._store("work", done.work, self.work)
            if done.reaction is not self.reaction:
                self._store("reaction", done.reaction, self.reaction)
            if self.error is not None:
                if done.error is None or not done.error >= 0.0:
                    raise WrongAnswer(f"{self.name}: its step gave error {done.error}, needed: a number of at least 0")
                self.error[1], self.error[0] = self.error[0], done.error
            for remember in self.follow:
                remember(after, dt)
            clock[0], clock[1], clock[2] = after, count + 1.0, dt
        return done

    def _store(self, name: str, given: Floats | None, field: Floats) -> None:
        if given is None:
            raise WrongAnswer(f"{self.name}: its step was accepted and gave no {name}, needed: Step({name}=...)")
        if np.shape(given) != field.shape:
            raise WrongAnswer(f"{self.name}: its step gave {name} of shape {np.shape(given)}, needed: {field.shape}")
        field[...] = given


def _refuse_step(count: float, time: float, dt: float) -> None:
    raise SimulationFailure(
        "failed",
        f"step {count:.0f}: the clock stands at {time:.6g} s, as a step of {dt:.3g} s does not move it; try a longer "
        "time.step, or look at the stiffness and density of the bodies, from which the stable step follows",
    )
