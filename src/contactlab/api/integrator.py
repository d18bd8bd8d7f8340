"""Integrators: one accepted step from state to state, through a narrow view of the model."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from enum import Enum
from typing import ClassVar, NamedTuple, Protocol

from contactlab.api.arrays import Floats, Ints
from contactlab.api.enforcement import Enforcement, Solve
from contactlab.api.state import State


class StepStatus(Enum):
    """How a step ended; the text says what to try."""

    accepted = ""
    not_converged = "the iteration did not converge; a shorter step is tried next"
    gave_up = "the shortest step failed; try a smaller load increment or another enforcement"


class Step(NamedTuple):
    """An attempted step: its status, Newton iterations, contact sweeps and contact residual."""

    status: StepStatus = StepStatus.accepted
    iterations: int = 0
    sweeps: int = 0
    residual: float = 0.0


class PrescribedMotion(Protocol):
    """Degrees of freedom whose displacement is given.

    dof    (p,) int32, 2 * node + component
    scale  (p,) [mm], displacement = scale * ramp value
    ramp   (p,) int32, which ramp each one follows
    """

    dof: Ints
    scale: Floats
    ramp: Ints

    def values(self, time: float) -> Floats:
        """Ramp values (ramps,) at `time`; the same array every call."""


class ContactEquations(Protocol):
    """All contact pairs together."""

    def solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        """Rows at the `predicted` positions (N, 2) from search to friction, then the enforcement's answer.

        `current` (N, 2) are the positions at the start of the step, for objective slip. Multipliers
        are warm-started from the state and left there; `force` (N, 2) [N] brings the contact forces
        of the last step (they tell where the nodes will be) and receives those of this one.
        """

    def friction_work(self, mean_velocity: Floats, dt: float, compliance: Floats, force: Floats) -> tuple[float, float]:
        """Work of the last solve's tangential forces in the step [mJ], and their dissipation -y_t d.

        `mean_velocity` (N, 2) is that of the step; compliance and force (N, 2) are those of the solve.
        Zero without friction.
        """


class Equations(Protocol):
    """All that an integrator may see of a model. What a scene does not declare is None or empty.

    reference  (N, 2) undeformed positions [mm]
    position   (N, 2) reference + displacement, kept current by `internal_force` [mm]
    mass       (N,) lumped [t]; 0 for nodes of rigid surfaces
    damping    mass-proportional [1/s]
    """

    reference: Floats
    position: Floats
    mass: Floats
    prescribed: PrescribedMotion
    contact: ContactEquations | None
    damping: float

    def internal_force(self, dt: float) -> None:
        """Stresses and history at the state's displacement, reached by a step `dt`; fills `internal_force`."""

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill `out` (N, 2) with all loads [N]; False if the scene has none (`out` is then untouched)."""

    def stable_step(self) -> float:
        """Largest explicit step [s] at the state's geometry, without safety factor."""


class Integrator(ABC):
    """Subclasses are frozen dataclasses; their fields are the TOML keys.

    needs                the enforcement class it works with
    default_enforcement  used by contacts that name none, so that integrators can be swept alone
    order                promised and checked on an oscillator
    inertia              False: no mass is assembled
    explicit             True: the step is bounded by the stable step
    """

    needs: ClassVar[type[Enforcement]]
    default_enforcement: ClassVar[str]
    order: ClassVar[int]
    inertia: ClassVar[bool]
    explicit: ClassVar[bool]

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        """Shapes of further state fields that the integrator needs, by name."""
        return {}

    @abstractmethod
    def bind(self, equations: Equations, state: State) -> Callable[[float], Step]:
        """A function that advances `state` in place by one step of the given length [s].

        Called once per run; all arrays of `state` stay where they are for the whole run.
        The state is as built (t = 0, initial velocities) or restored from a snapshot.
        """
