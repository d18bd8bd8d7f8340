"""Quasi-static load steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from contactlab.api import ImplicitIntegrator, ImplicitMotion
from contactlab_statics.limits import refuse_limits

STEPS = 10
"""Load steps if the loading path matters and the scene sets no number."""

ESTIMATE = 1e-4
"""Tolerance on coarser levels, whose meshes err by more."""


@dataclass(frozen=True)
class Newton(ImplicitIntegrator):
    """Equilibrium at the end of every load step, without inertia.

    steps       equal load steps to try for the whole loading; failed ones are cut, easy ones grow back. Not written:
                10, and 10 for each way of an alternating loading, or none on the path if the end does not
                depend on it
    nested      if the end does not depend on the loading path and `steps` is not written, coarser levels of the
                meshes are solved first, each from the level before, and only the end (and where the loading turns)
    tolerance   largest unbalanced nodal force over the largest nodal force, and largest violation of a contact
                condition in segment lengths, at which a step is accepted
    iterations  most iterations of a step before it is cut
    stabilised  whether a load step that no shorter one can replace is made with viscous forces that vanish at its end
                (docs/statics.md): bodies that snap, slip off or hang free then move until something holds them
    """

    steps: int | None = None
    nested: bool = True
    tolerance: float = 1e-8
    iterations: int = 25
    stabilised: bool = True

    default_enforcement: ClassVar[str] = "active-set"
    order: ClassVar[int] = 1
    inertia: ClassVar[bool] = False
    by_default: ClassVar[bool] = True

    def __post_init__(self) -> None:
        refuse_limits(self.wished_steps(), self.tolerance, self.iterations)

    def wished_steps(self) -> int:
        """Return the number of steps of the scene, or the default."""
        return STEPS if self.steps is None else self.steps

    def fixes_steps(self) -> bool:
        """Return whether the scene sets `steps`."""
        return self.steps is not None

    def for_coarser_levels(self) -> Newton | None:
        """Return a copy with the tolerance of an estimate; None if `steps` is set or `nested` is off."""
        if self.steps is not None or not self.nested:
            return None
        return replace(self, tolerance=max(self.tolerance, ESTIMATE), stabilised=False)

    def stabilises(self) -> bool:
        """Return `stabilised`."""
        return self.stabilised

    def memory(self, nodes: int) -> Mapping[str, tuple[int, ...]]:
        """Displacement of the last step [mm], the start of the next step in bodies that flow."""
        return {"moved": (nodes, 2)}

    def step(self, motion: ImplicitMotion, dt: float) -> None:
        """Balance all forces at the end of the step."""
        motion.solve()
