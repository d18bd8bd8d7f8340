"""Quasi-static load steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import ImplicitEquations, ImplicitIntegrator, State, Step
from contactlab_statics.limits import refuse_limits


@dataclass(frozen=True)
class Newton(ImplicitIntegrator):
    """Equilibrium at the end of every load step, without inertia.

    steps       equal load steps to try for the whole loading; failed ones are cut, easy ones grow back
    tolerance   largest unbalanced nodal force over the largest nodal force, and largest violation of a contact
                condition in segment lengths, at which a step is accepted
    iterations  most iterations of a step before it is cut
    """

    steps: int = 10
    tolerance: float = 1e-8
    iterations: int = 25

    default_enforcement: ClassVar[str] = "active-set"
    order: ClassVar[int] = 1
    inertia: ClassVar[bool] = False

    def __post_init__(self) -> None:
        refuse_limits(self.steps, self.tolerance, self.iterations)

    def wished_steps(self) -> int:
        """The steps that the scene asks for."""
        return self.steps

    def bind(self, equations: ImplicitEquations, state: State) -> Callable[[float], Step]:
        """The function that makes one load step."""
        from contactlab_statics.load_step import LoadStep

        return LoadStep(equations, state, self.tolerance, self.iterations).step
