"""Integrators: steps from state to state."""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from contactlab.api.compiled.late import late
from contactlab.api.enforcement import Enforcement, ExplicitEnforcement, ImplicitEnforcement
from contactlab.api.equations import (  # noqa: F401  kept for older imports
    ContactDerivatives,
    ContactEquations,
    Equations,
    Estimate,
    ExplicitEquations,
    ImplicitContact,
    ImplicitEquations,
    PrescribedMotion,
)
from contactlab.api.motion import ImplicitMotion, Motion
from contactlab.api.state import State
from contactlab.api.step import Iteration, Step, StepControl, StepStatus  # noqa: F401

LEAPFROG = 0.5  # velocity lag of schemes that move by dt times their velocity


class Integrator(ABC):
    """Common base of explicit and implicit integrators. Plugins derive from one of the two classes below.

    Subclasses are frozen dataclasses; their fields are the TOML keys. Clock, reactions and energy balance belong to
    the core: a step reads them, and returns reactions and balance in its `Step`. The duties of an author, each with
    checks in `contactlab.testing.integrator` (duties that do not concern a kind are not applicable to it). An author
    of `step` by primitives has 1, 2, 10 and 12, and 6 in an explicit scheme; an author of `bind` has all of them:

     1. It declares its properties by the class attributes below.
     2. `step`, or the function that `bind` gives, moves `displacement` and `velocity` of the state by one step, in
        place, with the promised order: from the first step on, under damping, and with steps of varying length.
     3. A step ends with `internal_force(dt)` at the new displacement, so that positions, stresses and `internal_force`
        belong to its end.
     4. Prescribed degrees of freedom end at `prescribed` positions, to round-off, and no force moves them.
     5. Loads come from `external_force` at times within the step.
     6. Contact forces come from `contact`, if it is not None, in the same step as the motion that they stop, act
        on velocities as well as displacements, and are stored in `contact_force`.
     7. `Step.work` is the energy balance with the work of every force in the step, so that it matches kinetic energy.
     8. `Step.reaction` holds the forces of the supports, whatever else acts on their nodes.
     9. The clock is read (`state.time`, `state.step`) and never written.
    10. All that a step needs from earlier steps is in the state: `memory` declares fields in addition to the fields of
        every run. Bound again to a restored state, it continues with the same bits.
    11. A step that is not accepted gives the reason, and leaves the state unchanged, to the last bit.
    12. Energy never grows, and is only lost if the class declares that it `dissipates`.
    13. All else is read-only: reference, mass, prescribed motion, and the arrays of loads and contact.

    needs                the enforcement class it works with, set by its kind
    default_enforcement  used by contacts that name none, so that the integrator alone can be varied
    order                of its error in the length of steps, checked on an oscillator
    inertia              False for statics: no mass is assembled
    dissipates           True for a scheme that dissipates energy by itself
    without              effects of this integrator ("inertia"), each with an integrator without it
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
        """Return the enforcement of contacts that name none, as a scene would write it: `default_enforcement`."""
        return {"use": self.default_enforcement}

    def control(self) -> StepControl | None:
        """Controls step lengths by the errors of steps; None: the scene gives lengths, by `time` and `steps`.

        Lengths start as without it. Explicit steps stay below the stable step, implicit steps are not limited by the
        number of steps that the scene wishes; both end at every frame and at the end of the run.
        """
        return None

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        """Return shapes of further state fields that the integrator needs, by name."""
        return {}


class ExplicitIntegrator(Integrator):
    """Base of integrators whose steps follow from the state before, up to the stable step; see `Integrator` for duties.

    A scheme of kicks and drifts writes `step`: duties 1, 2, 6, 10 and 12 are left. Any other writes `bind`.

    velocity_lag  fraction of a step by which `velocity` lags behind `time`: 0.5 for leapfrog schemes, 0 for schemes
                  with velocities at the end of the step
    """

    needs: ClassVar[type[Enforcement]] = ExplicitEnforcement
    inertia: ClassVar[bool] = True
    velocity_lag: ClassVar[float] = LEAPFROG

    def step(self, motion: Motion, dt: float) -> float | None:
        """Make one step of length dt [s] by the primitives of `motion`; returns `Step.error`, or None."""
        raise NotImplementedError

    def bind(self, equations: ExplicitEquations, state: State) -> Callable[[float], Step]:
        """Return a function that advances `state` in place by a step of given length [s]; by default it calls `step`.

        Called once per run; all arrays of `state` stay in place for the whole run.
        The state is as built (t = 0, initial velocities) or restored from a snapshot.
        """
        motion = late("contactlab.model.motion").ExplicitMotion(self, equations, state)
        advance: Callable[[float], Step] = motion.advance
        return advance


class ImplicitIntegrator(Integrator):
    """Base of integrators that solve for the state at the end of the step; see `Integrator`. Velocities are at `time`.

    A scheme that relates velocities and accelerations to the motion of the step writes `step`: duties 1, 2, 10
    and 12 are left. Any other writes `bind`. The core acts on two names of `memory`:
    `moved` (N, 2): load steps start with the motion of the last step; `impact` (3,): steps end at impacts.

    tolerance   largest accepted residual, of forces over the largest force and of contact in segment lengths
    iterations  most iterations of a step before it is cut; both may be fields, and so keys of the scene
    """

    needs: ClassVar[type[Enforcement]] = ImplicitEnforcement
    tolerance = 1e-8
    iterations = 25

    def wished_steps(self) -> int:
        """Number of equal steps that is first tried for the whole loading."""
        return 20

    def fixes_steps(self) -> bool:
        """True if the scene gives this number; otherwise cyclic loading gets more steps."""
        return True

    def stabilises(self) -> bool:
        """Return whether steps can be made in a second way if no equilibrium is near: see `ImplicitEquations`."""
        return False

    def for_coarser_levels(self) -> ImplicitIntegrator | None:
        """Return the integrator for coarser mesh levels, solved first if the end does not depend on the path.

        Each step then ends when the loading ends or turns, and `ImplicitEquations.estimate` gives its start.
        None: every scene is solved in load increments.
        """
        return None

    def step(self, motion: ImplicitMotion, dt: float) -> float | None:
        """Make one step of length dt [s] by `motion.solve`; returns `Step.error`, or None."""
        raise NotImplementedError

    def bind(self, equations: ImplicitEquations, state: State) -> Callable[[float], Step]:
        """Return a function that advances `state` in place by a step of given length [s]; by default it calls `step`.

        Called once per run; all arrays of `state` stay in place for the whole run.
        The state is as built (t = 0, initial velocities) or restored from a snapshot.
        """
        motion = late("contactlab.implicit.motion").SolvedMotion(self, equations, state)
        advance: Callable[[float], Step] = motion.advance
        return advance
