"""Equations: the narrow interface through which integrators see a model."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from contactlab.api.arrays import Floats, Ints
from contactlab.api.enforcement import Conditions, ImplicitEnforcement, Solve


class PrescribedMotion(Protocol):
    """Degrees of freedom whose displacement is given.

    dof    (p,) int32, 2 * node + component
    scale  (p,) [mm], displacement = scale * ramp value
    ramp   (p,) int32, number of the ramp of each degree of freedom
    """

    dof: Ints
    scale: Floats
    ramp: Ints

    def values(self, time: float) -> Floats:
        """Return ramp values (ramps,) at `time`; the same array every call."""


class ContactEquations(Protocol):
    """All contact pairs together, as explicit integrators see them."""

    def solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        """Find the rows at the `predicted` positions (N, 2), from search to friction, and solve for the forces.

        `current` (N, 2) are the positions at the start of the step, for objective slip. Multipliers
        are warm-started from the state and stored there; `force` (N, 2) [N] holds the contact forces
        of the last step, from which final positions are estimated, and receives the forces of this step.
        """

    def friction_work(self, mean_velocity: Floats, dt: float, compliance: Floats, force: Floats) -> tuple[float, float]:
        """Return the work of the last solve's tangential forces in the step [mJ], and their dissipation -y_t d.

        `mean_velocity` (N, 2) belongs to the step; compliance and force (N, 2) belong to the solve.
        Zero without friction.
        """


class Equations(Protocol):
    """Interface of a model for every integrator. Anything that a scene does not declare is None or empty.

    reference  (N, 2) undeformed positions [mm]
    position   (N, 2) reference + displacement, kept current by `internal_force` [mm]
    mass       (N,) lumped [t]; 0 for nodes of rigid surfaces; (0,) without inertia
    damping    mass-proportional [1/s], of velocities relative to the state's `drift` if there is one
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
    """Additional interface of a model for explicit integrators."""

    @property
    def contact(self) -> ContactEquations | None:
        """All contact pairs together."""

    def stable_step(self) -> float:
        """Return the largest explicit step [s] at the state's geometry, without safety factor."""


class ImplicitContact(Protocol):
    """All contact pairs together, as implicit integrators see them."""

    enforcement: ImplicitEnforcement
    conditions: Conditions

    @property
    def by_energy(self) -> bool:
        """True if some forces come from potentials (`contactlab.api.Potential`).

        Then every correction is limited by `free_share` (with any depth),
        and `forces` and the `force` of `linearise` include potential forces.
        """

    @property
    def acts(self) -> bool:
        """True if nodal forces change with positions at fixed multipliers: then `linearise` is always called."""

    def settled(self) -> bool:
        """Return whether friction belongs to the last `evaluate`; called by every iteration that has converged.

        Friction of potentials follows normal forces, and bounds of laws with needs follow slips. If they did not, this
        call updates them: forces or bounds have changed, and the iteration continues.
        """

    def dissipation(self) -> float:
        """Return the energy [mJ] dissipated by friction since the start of the step, by constraints and potentials."""

    def friction_along_the_way(self) -> tuple[float, float]:
        """Return friction energy [mJ] of a load step, and its excess over the work of the mean of both ends' forces."""

    def evaluate(self, position: Floats) -> None:
        """Fill `conditions` at trial positions (N, 2); slots without a constraint lose their force."""

    def forces(self, normal: Floats, tangential: Floats) -> None:
        """Fill (N, 2) [N] each with the nodal forces of the trial multipliers; the second (0, 2) without friction."""

    def free_share(self, position: Floats, motion: Floats, depth: float) -> float:
        """Return the share of a motion (N, 2) [mm] until a node is `depth` segments deep, from `position` (N, 2).

        It is 1 if no node passes through the other side, however long the motion is, and no potential allows less.
        """

    def scale(self, flexibility: Floats) -> None:
        """Derive stiffnesses from nodal flexibility (N, 2) [mm/N], 0 if held, from the next `evaluate` on."""

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        """Return derivatives at the positions of the last `evaluate`; rows are the `chosen` slots, in rising order."""

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Return sparse rows (c, 2N) for velocity changes at the end of the step: forces of the `chosen` slots there.

        First normal, then tangential rows; tangential rows are None without friction.
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
    pressure      (r, k) [MPa] multipliers over the length that belongs to each constraint
    """

    time: float
    displacement: Floats
    pressure: Floats


class ImplicitEquations(Equations, Protocol):
    """Additional interface of a model for implicit integrators.

    Between `begin_step` and `accept` everything is a trial: `internal_force` starts from the history of the
    last accepted step, whatever was tried in between; multipliers are in `contact.conditions`.

    stabilised    True if the next step failed at all lengths, and an integrator that `stabilises` must use its
                  second way
    quasi_static  True if a run with inertia ends when its motion has faded (`end = "auto"`)
    """

    stabilised: bool

    @property
    def quasi_static(self) -> bool:
        """True if a run with inertia ends when its motion has faded."""

    def internal_force(self, dt: float, share: float = 1.0) -> None:
        """Compute `Equations.internal_force` with stresses after a `share` of the way from the start of the step.

        `dt` [s] is the time of this share. `position` always belongs to the state's displacement.
        """

    @property
    def contact(self) -> ImplicitContact | None:
        """All contact pairs together."""

    def begin_step(self, dt: float) -> None:
        """Take the state as the start of a step of length dt [s], also after a restore (then of length 0).

        Constraints that depend on time, such as overlaps pushed out in a ramp, hold at the end of the step.
        """

    def stiffness(self, dt: float) -> Any:
        """Return d(internal force)/d(displacement) (2N, 2N) at the last `internal_force`, a SciPy CSC array."""

    def add_load_stiffness(self, time: float, stiffness: Any, share: float, rate: float) -> None:
        """Add `share` of -d(external force)/d(displacement) at `time` to a matrix of the pattern of `stiffness`.

        rate  d(velocity)/d(displacement) [1/s] of the step, for forces that depend on velocities; 0 in statics
        """

    def estimate(self, time: float) -> Estimate | None:
        """Return a better start for the iteration of a step that ends at `time` [s]; None if unknown."""

    def folded(self) -> bool:
        """Return whether a cell was folded over at the last `internal_force`."""

    def iterated(self) -> None:
        """Report the end of an iteration with the present displacements and constraints; once per `Step.trace` entry.

        If the run records it, this state is kept; otherwise nothing happens. The call is optional.
        """

    def accept(self) -> None:
        """Make the trial the state: history, multipliers and memory of contacts."""
