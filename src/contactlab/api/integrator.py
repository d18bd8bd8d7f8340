"""Integrators: steps from state to state, through a narrow interface to the model."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar, NamedTuple, Protocol

from contactlab.api.arrays import Floats, Ints
from contactlab.api.compiled.late import late
from contactlab.api.enforcement import Conditions, Enforcement, ExplicitEnforcement, ImplicitEnforcement, Solve
from contactlab.api.state import State


class StepStatus(Enum):
    """How a step ended; the text advises what to try."""

    accepted = ""
    not_converged = "the iteration did not converge; a shorter step is tried next"
    gave_up = "the shortest step failed; try more integrator.steps or integrator.iterations, or another enforcement"


class Iteration(NamedTuple):
    """One iteration of an implicit step, as it is recorded.

    force     largest unbalanced nodal force over the largest force of the model
    contact   largest violation of a contact condition, as the integrator measures it: in segment lengths, or over the
              largest force
    active    closed conditions; sticking: those that stick; changed: conditions whose status changed
    length    fraction of the computed correction that was taken
    note      any departure from a plain iteration, and why
    statuses  a digit per contact condition: 0 open, 1 stick, 2 slip; empty if unknown
    """

    force: float
    contact: float
    active: int
    sticking: int
    changed: int
    length: float
    note: str = ""
    statuses: str = ""


class Step(NamedTuple):
    """Result of an attempted step: its status, work and reactions, and its iterations.

    work        (7,) energy ledger at its end, see `contactlab.api.WORK` [mJ]
    reaction    (N, 2) [N] forces of the supports on prescribed degrees of freedom, 0 elsewhere
    status      whether it is accepted; otherwise `reason` gives the cause and no other field is needed
    iterations  number of Newton iterations; `trace` has each of them
    sweeps      of the contact solve; `residual` is that at its end
    error       estimate of the error made in this step over its tolerance: 1 is just allowed; None without an estimate
    longest     most length [s] of the next step, or of this one where it is to be repeated; None: the schedule's own.
                Of implicit steps only; one that is repeated with it has not failed

    `work` and `reaction` are new arrays, or the state's own fields of these names brought up to date in place.
    """

    work: Floats | None = None
    reaction: Floats | None = None
    status: StepStatus = StepStatus.accepted
    iterations: int = 0
    sweeps: int = 0
    residual: float = 0.0
    reason: str = ""
    trace: tuple[Iteration, ...] = ()
    error: float | None = None
    longest: float | None = None


@dataclass(frozen=True)
class StepControl:
    """Choose the length of the next step from the errors of this step and the last one, a PI controller.

    A step whose error exceeds its tolerance is repeated from the same state with a shorter length.

    order         power of the step length that the estimated error falls with; 3 for the error in one step of a
                  second-order scheme
    safety        fraction of the length that would just meet the tolerance
    integral      weight of the error of this step; `proportional` that of the change of errors: 0.7 and 0.4 keep
                  steps smooth (Hairer & Wanner, Solving Ordinary Differential Equations II, IV.2)
    shrink, grow  limits of the ratio of a step to the one before
    """

    order: int
    safety: float = 0.9
    integral: float = 0.7
    proportional: float = 0.4
    shrink: float = 0.2
    grow: float = 2.0

    def ratio(self, error: float, before: float) -> float:
        """Length of the next step over the length of this step; errors over their tolerances, `before` the last one.

        The last one is 1 in the first step. A step whose error exceeds 1 was rejected, and the ratio is below 1.
        """
        error = max(error, 1e-10)
        if error > 1.0:
            return max(self.shrink, float(self.safety * error ** (-1.0 / self.order)))
        before = max(before, 1e-10)
        ratio: float = self.safety * error ** (-self.integral / self.order) * before ** (self.proportional / self.order)
        return min(self.grow, max(self.shrink, ratio))


class PrescribedMotion(Protocol):
    """Degrees of freedom whose displacement is given.

    dof    (p,) int32, 2 * node + component
    scale  (p,) [mm], displacement = scale * ramp value
    ramp   (p,) int32, number of the ramp that each one follows
    """

    dof: Ints
    scale: Floats
    ramp: Ints

    def values(self, time: float) -> Floats:
        """Ramp values (ramps,) at `time`; the same array every call."""


class ContactEquations(Protocol):
    """All contact pairs together, as explicit integrators see them."""

    def solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        """Find the rows at the `predicted` positions (N, 2), from search to friction, and solve for the forces.

        `current` (N, 2) are the positions at the start of the step, for objective slip. Multipliers
        are warm-started from the state and stored there; `force` (N, 2) [N] holds the contact forces
        of the last step, from which final positions are estimated, and receives those of this one.
        """

    def friction_work(self, mean_velocity: Floats, dt: float, compliance: Floats, force: Floats) -> tuple[float, float]:
        """Work of the last solve's tangential forces in the step [mJ], and their dissipation -y_t d.

        `mean_velocity` (N, 2) is that of the step; compliance and force (N, 2) are those of the solve.
        Zero without friction.
        """


class Equations(Protocol):
    """What every integrator sees of a model. Anything that a scene does not declare is None or empty.

    reference  (N, 2) undeformed positions [mm]
    position   (N, 2) reference + displacement, kept current by `internal_force` [mm]
    mass       (N,) lumped [t]; 0 for nodes of rigid surfaces; (0,) without inertia
    damping    mass-proportional [1/s], of velocities relative to the state's `drift` where there is one
    relaxation time constant [s] with which `drift` follows velocities; 0 without it
    """

    reference: Floats
    position: Floats
    mass: Floats

    @property
    def damping(self) -> float:
        """Mass-proportional damping [1/s] of velocities relative to the `drift`."""

    @property
    def relaxation(self) -> float:
        """Time constant [s] with which `drift` follows velocities."""

    @property
    def prescribed(self) -> PrescribedMotion:
        """Degrees of freedom whose displacement is given."""

    def internal_force(self, dt: float) -> None:
        """Find stresses and history at the state's displacement after a step `dt`, and fill `internal_force`."""

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill `out` (N, 2) with all loads [N]; False if the scene has none (`out` is then untouched)."""


class ExplicitEquations(Equations, Protocol):
    """What explicit integrators see in addition to `Equations`."""

    @property
    def contact(self) -> ContactEquations | None:
        """All contact pairs together."""

    def stable_step(self) -> float:
        """Largest explicit step [s] at the state's geometry, without safety factor."""


class Motion(Protocol):
    """One run as `ExplicitIntegrator.step` sees it: primitives that move the state and book what they do.

    Kicks change velocities, drifts positions. Work, reactions, damping, loads, prescribed motion, friction and stresses
    are the core's. The drifts of a step sum to its length, and each follows a kick.

    state    as the last primitive left it: read only, but for the integrator's own `memory`
    last_dt  length of the last step [s]; 0 before the first
    """

    state: State
    last_dt: float

    def kick(self, duration: float) -> None:
        """Let stresses and loads of this moment act on velocities for a time [s], with the damping of its middle."""

    def contact(self, ahead: float) -> None:
        """Add to the kick the contact forces that hold the gaps at the end of the next drift, `ahead` [s] from now.

        They act as long as the kick, the only one of the step: velocities between two kicks would lack them, and
        stresses be booked with work that they did not do. Nothing happens in a scene without contact.
        """

    def drift(self, duration: float) -> None:
        """Move positions with the velocities for a time [s], and find the stresses there."""

    def acceleration(self) -> Floats:
        """Accelerations (N, 2) [mm/s^2] by stresses and loads of this moment, 0 where motion is prescribed."""


class ImplicitContact(Protocol):
    """All contact pairs together, as implicit integrators see them."""

    enforcement: ImplicitEnforcement
    conditions: Conditions

    @property
    def by_energy(self) -> bool:
        """Whether some forces come from potentials (`contactlab.api.Potential`).

        Then every correction is limited by `free_share` (with any depth),
        and `forces` and the `force` of `linearise` include theirs.
        """

    @property
    def acts(self) -> bool:
        """Whether nodal forces change with positions at fixed multipliers: then `linearise` is asked in any case."""

    def settled(self) -> bool:
        """Whether friction belongs to the last `evaluate`; every iteration that has converged asks this.

        Friction of potentials follows normal forces, and bounds of laws with needs follow slips. If they did not, they
        do from now on: forces or bounds have changed, and the iteration continues.
        """

    def dissipation(self) -> float:
        """Energy [mJ] that friction has taken since the start of the step, conditions and potentials together."""

    def evaluate(self, position: Floats) -> None:
        """Fill `conditions` at trial positions (N, 2); slots without a condition lose their force."""

    def forces(self, normal: Floats, tangential: Floats) -> None:
        """Fill (N, 2) [N] each with the nodal forces of the trial multipliers; the second (0, 2) without friction."""

    def free_share(self, position: Floats, motion: Floats, depth: float) -> float:
        """Share of a motion (N, 2) [mm] from `position` (N, 2) before a node is `depth` segments inside the other side.

        It is 1 if no node passes through the other side, however long the motion is, and no potential allows less.
        """

    def scale(self, flexibility: Floats) -> None:
        """Derive stiffnesses from the flexibility (N, 2) [mm/N] of nodes, 0 where held, from the next `evaluate` on."""

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        """Derivatives at the positions of the last `evaluate`; rows are the `chosen` slots, in increasing order."""

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Sparse rows (c, 2N) for changes of velocity at the end of the step: forces of the `chosen` slots there.

        Normal and tangential ones; tangential ones are None without friction.
        """


class ContactDerivatives(NamedTuple):
    """Sparse derivatives with respect to the 2N degrees of freedom; one row for each chosen slot.

    normal, tangent  directions of the forces: nodal forces = normal^T y_n + tangent^T y_t
    gap, slip        derivatives of gap and slip; tangent and slip are None without friction
    force            (2N, 2N) derivative of all nodal forces at fixed multipliers
    """

    normal: Any
    tangent: Any
    gap: Any
    slip: Any
    force: Any


class Estimate(NamedTuple):
    """Estimate of a state before it is solved for, from the solution on a coarser mesh.

    time          of the state [s]
    displacement  (N, 2) [mm]
    pressure      (r, k) [MPa] multipliers over the length that belongs to each condition
    """

    time: float
    displacement: Floats
    pressure: Floats


class ImplicitEquations(Equations, Protocol):
    """What implicit integrators see in addition to `Equations`.

    Between `begin_step` and `accept` everything is a trial: `internal_force` starts from the history of the
    last accepted step, whatever was tried in between; multipliers are those of `contact.conditions`.

    stabilised    whether the next step has failed at all lengths, and an integrator that `stabilises` is to make it in
                  its second way
    quasi_static  whether a run with inertia ends when its motion has faded (`end = "auto"`)
    """

    stabilised: bool

    @property
    def quasi_static(self) -> bool:
        """Whether a run with inertia ends when its motion has faded."""

    def internal_force(self, dt: float, share: float = 1.0) -> None:
        """As `Equations.internal_force`, but for stresses after a `share` of the way from the start of the step.

        `dt` [s] is the time that this share takes. `position` is that of the state's displacement in any case.
        """

    @property
    def contact(self) -> ImplicitContact | None:
        """All contact pairs together."""

    def begin_step(self, dt: float) -> None:
        """Take the state as the start of a step of length dt [s], also after it was restored (then of length 0).

        Conditions that depend on time, such as overlaps pushed out in a ramp, are those at the end of the step.
        """

    def stiffness(self, dt: float) -> Any:
        """d(internal force)/d(displacement) (2N, 2N) at the last `internal_force`, a SciPy CSC array."""

    def add_load_stiffness(self, time: float, stiffness: Any, share: float, rate: float) -> None:
        """Add `share` of -d(external force)/d(displacement) at `time` to a matrix of the pattern of `stiffness`.

        rate  d(velocity)/d(displacement) [1/s] of the step, for forces that depend on velocities; 0 in statics
        """

    def estimate(self, time: float) -> Estimate | None:
        """A better start for the iteration of a step that ends at `time` [s]; None where none is known."""

    def folded(self) -> bool:
        """Whether a cell was folded over at the last `internal_force`."""

    def iterated(self) -> None:
        """An iteration has ended with displacements and contact conditions as they are; once for each in `Step.trace`.

        Where the run records it, that state is kept; otherwise nothing happens. An integrator need not call it.
        """

    def accept(self) -> None:
        """Make the trial the state: history, multipliers and memory of contacts."""


class Integrator(ABC):
    """What explicit and implicit integrators have in common. Parts derive from one of the two classes below.

    Subclasses are frozen dataclasses; their fields are the TOML keys. Clock, reactions and energy ledger belong to
    the core: a step reads them, and returns reactions and ledger in its `Step`. The duties of an author, each with
    checks in `contactlab.testing.integrator` (those that do not concern a kind are not applicable to it):

     1. It declares its properties by the class attributes below.
     2. `bind` gives a function that moves `displacement` and `velocity` of the state by one step, in place, and with
        the promised order: from the first step on, under damping, and where the length of steps changes.
     3. A step ends with `internal_force(dt)` at the new displacement, so that positions, stresses and `internal_force`
        belong to its end.
     4. Prescribed degrees of freedom end where `prescribed` puts them, to round-off, and no force moves them.
     5. Loads are those of `external_force` at times within the step.
     6. Contact forces come from `contact`, where that is not None, in the same step as the motion that they stop, act
        on velocities as well as displacements, and are stored in `contact_force`.
     7. `Step.work` is the ledger with the work of every force in the step, so that it balances with kinetic energy.
     8. `Step.reaction` holds the forces of the supports, whatever else acts on their nodes.
     9. The clock is read (`state.time`, `state.step`) and never written.
    10. All that a step needs from earlier steps is in the state: `memory` declares fields beyond those that every
        run has. Bound again to a restored state, it continues with the same bits.
    11. A step that is not accepted gives the reason, and leaves the state unchanged, to the last bit.
    12. Energy never grows, and is only lost where the class declares that it `dissipates`.
    13. All else is read-only: reference, mass, prescribed motion, and the arrays of loads and contact.

    needs                the enforcement class it works with, set by its kind
    default_enforcement  used by contacts that name none, so that integrators can be varied alone
    order                of its error in the length of steps, checked on an oscillator
    inertia              False for statics: no mass is assembled
    dissipates           True for a scheme that dissipates energy by itself
    without              effects of this integrator ("inertia"), each with the integrator that leaves it out
    by_default           tried by scenes with `integrator = "auto"` that give no order
    """

    needs: ClassVar[type[Enforcement]]
    default_enforcement: ClassVar[str]
    order: ClassVar[int]
    inertia: ClassVar[bool]
    dissipates: ClassVar[bool] = False
    without: ClassVar[Mapping[str, str]] = {}
    by_default: ClassVar[bool] = False

    def enforcement(self) -> Mapping[str, Any]:
        """The enforcement of contacts that name none, as a scene would write it: `default_enforcement`."""
        return {"use": self.default_enforcement}

    def control(self) -> StepControl | None:
        """Chooses step lengths from the errors that steps report; None: the scene does, by `time` and `steps`.

        Lengths start as without it. Explicit steps stay below the stable one, implicit ones are not limited by the
        number of steps that the scene wishes; both end at every frame and at the end of the run.
        """
        return None

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        """Shapes of further state fields that the integrator needs, by name."""
        return {}


class ExplicitIntegrator(Integrator):
    """Steps that follow from the state before them, limited by the stable step; see `Integrator` for the duties.

    A scheme of kicks and drifts writes `step`: of the duties 1, 2, 6, 10 and 12 are left. Any other writes `bind`.

    velocity_lag  fraction of a step by which `velocity` lags behind `time`: 0.5 for leapfrog schemes, 0 for schemes
                  whose velocities are those at the end of the step
    """

    needs: ClassVar[type[Enforcement]] = ExplicitEnforcement
    inertia: ClassVar[bool] = True
    velocity_lag: ClassVar[float] = 0.5

    def step(self, motion: Motion, dt: float) -> float | None:
        """Make one step of length dt [s] by the primitives of `motion`; returns `Step.error`, or None."""
        raise NotImplementedError

    def bind(self, equations: ExplicitEquations, state: State) -> Callable[[float], Step]:
        """A function that advances `state` in place by one step of the given length [s]; by default that of `step`.

        Called once per run; all arrays of `state` stay where they are for the whole run.
        The state is as built (t = 0, initial velocities) or restored from a snapshot.
        """
        advance: Callable[[float], Step] = late("contactlab.model.motion").bound(self, equations, state)
        return advance


class ImplicitIntegrator(Integrator):
    """Steps that solve for the state at their end; see `Integrator` for the duties. Velocities are those of `time`."""

    needs: ClassVar[type[Enforcement]] = ImplicitEnforcement

    def wished_steps(self) -> int:
        """Number of equal steps that is first tried for the whole loading."""
        return 20

    def fixes_steps(self) -> bool:
        """Whether the scene gives this number; otherwise a loading that goes to and fro is given more."""
        return True

    def stabilises(self) -> bool:
        """Whether steps can be made in a second way where there is no equilibrium near: see `ImplicitEquations`."""
        return False

    def for_coarser_levels(self) -> ImplicitIntegrator | None:
        """The integrator that solves coarser levels of the meshes first, where the end does not depend on the path.

        Each step then ends where the loading ends or turns, and `ImplicitEquations.estimate` gives its start.
        None: every scene is solved in load steps.
        """
        return None

    @abstractmethod
    def bind(self, equations: ImplicitEquations, state: State) -> Callable[[float], Step]:
        """A function that advances `state` in place by one step of the given length [s].

        Called once per run; all arrays of `state` stay where they are for the whole run.
        The state is as built (t = 0, initial velocities) or restored from a snapshot.
        """
