"""Integrators: one accepted step from state to state, through a narrow view of the model."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, ClassVar, NamedTuple, Protocol

from contactlab.api.arrays import Floats, Ints
from contactlab.api.enforcement import Conditions, Enforcement, ImplicitEnforcement, Solve
from contactlab.api.state import State


class StepStatus(Enum):
    """How a step ended; the text says what to try."""

    accepted = ""
    not_converged = "the iteration did not converge; a shorter step is tried next"
    gave_up = "the shortest step failed; try more integrator.steps or integrator.iterations, or another enforcement"


class Iteration(NamedTuple):
    """One iteration of an implicit step, as it is recorded.

    force     largest unbalanced nodal force over the largest force of the model
    contact   largest violation of a contact condition, in segment lengths
    active    closed conditions; sticking: those that stick; changed: conditions whose status changed
    length    fraction of the computed correction that was taken
    note      what was done beside a plain iteration, and why
    """

    force: float
    contact: float
    active: int
    sticking: int
    changed: int
    length: float
    note: str = ""


class Step(NamedTuple):
    """An attempted step: its status, Newton iterations, contact sweeps and contact residual.

    reason says why a step was not accepted; trace tells every iteration of an implicit one.
    """

    status: StepStatus = StepStatus.accepted
    iterations: int = 0
    sweeps: int = 0
    residual: float = 0.0
    reason: str = ""
    trace: tuple[Iteration, ...] = ()


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
    damping: float

    @property
    def prescribed(self) -> PrescribedMotion:
        """Degrees of freedom whose displacement is given."""

    @property
    def contact(self) -> ContactEquations | None:
        """All contact pairs together."""

    def internal_force(self, dt: float) -> None:
        """Stresses and history at the state's displacement, reached by a step `dt`; fills `internal_force`."""

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill `out` (N, 2) with all loads [N]; False if the scene has none (`out` is then untouched)."""

    def stable_step(self) -> float:
        """Largest explicit step [s] at the state's geometry, without safety factor."""


class ImplicitContact(Protocol):
    """All contact pairs together, as implicit integrators see them."""

    enforcement: ImplicitEnforcement
    conditions: Conditions

    def evaluate(self, position: Floats) -> None:
        """Fill `conditions` at trial positions (N, 2); slots without a condition lose their force."""

    def forces(self, normal: Floats, tangential: Floats) -> None:
        """Fill (N, 2) [N] each with the nodal forces of the trial multipliers; the second (0, 2) without friction."""

    def scale(self, flexibility: Floats) -> None:
        """From the next `evaluate` on, stiffnesses follow from these (N, 2) [mm/N] of single nodes, 0 where held."""

    def linearise(self, chosen: Ints) -> ContactSlopes:
        """Slopes at the positions of the last `evaluate`; rows are the `chosen` slots, in increasing order."""


class ContactSlopes(NamedTuple):
    """Sparse slopes by the 2N degrees of freedom; one row for each chosen slot.

    normal, tangent  directions of the forces: nodal forces = normal^T y_n + tangent^T y_t
    gap, slip        derivatives of gap and slip; tangent and slip are None without friction
    force            (2N, 2N) derivative of all nodal forces at fixed multipliers
    """

    normal: Any
    tangent: Any
    gap: Any
    slip: Any
    force: Any


class ImplicitEquations(Equations, Protocol):
    """What implicit integrators see beside `Equations`.

    Between `begin` and `accept` everything is a trial: `internal_force` starts from the history of the
    last accepted step, whatever was tried in between, and multipliers are those of `contact.conditions`.
    """

    @property
    def contact(self) -> ImplicitContact | None:  # type: ignore[override]
        """All contact pairs together."""

    def begin(self, dt: float) -> None:
        """Take the state as the start of a step of length dt [s], also after it was restored (then of length 0).

        Conditions that follow the time, as overlaps that are eased out, are those of the end of the step.
        """

    def stiffness(self, dt: float) -> Any:
        """d(internal force)/d(displacement) (2N, 2N) at the last `internal_force`, a SciPy CSC array."""

    def add_load_stiffness(self, time: float, stiffness: Any, share: float, rate: float) -> None:
        """Add `share` of -d(external force)/d(displacement) at `time` to a matrix of the pattern of `stiffness`.

        rate  d(velocity)/d(displacement) [1/s] of the step, for forces that depend on velocities; 0 in statics
        """

    def folded(self) -> bool:
        """Whether a cell is turned inside out at the last `internal_force`."""

    def accept(self) -> None:
        """The trial becomes the state: history, multipliers and what contacts remember."""


class Integrator(ABC):
    """Subclasses are frozen dataclasses; their fields are the TOML keys.

    needs                the enforcement class it works with
    default_enforcement  used by contacts that name none, so that integrators can be swept alone
    order                promised and checked on an oscillator
    inertia              False: no mass is assembled
    explicit             True: the step is bounded by the stable step
    without              effects of this integrator ("inertia"), each with the integrator that leaves it out
    """

    needs: ClassVar[type[Enforcement]]
    default_enforcement: ClassVar[str]
    order: ClassVar[int]
    inertia: ClassVar[bool]
    explicit: ClassVar[bool]
    without: ClassVar[Mapping[str, str]] = {}

    def wished_steps(self) -> int:
        """Equal steps that an implicit integrator first tries for the whole loading."""
        return 20

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        """Shapes of further state fields that the integrator needs, by name."""
        return {}

    @abstractmethod
    def bind(self, equations: Equations, state: State) -> Callable[[float], Step]:
        """A function that advances `state` in place by one step of the given length [s].

        A step that is not accepted leaves the state exactly as it was.

        Called once per run; all arrays of `state` stay where they are for the whole run.
        The state is as built (t = 0, initial velocities) or restored from a snapshot.
        """
