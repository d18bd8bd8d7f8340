# kind integrator cls Statics
from dataclasses import dataclass
from typing import ClassVar

from contactlab_statics.newton import Newton

from contactlab.api import ImplicitIntegrator


@dataclass(frozen=True)
class Statics(ImplicitIntegrator):
    """Load steps of another integrator, looked at from outside."""

    default_enforcement: ClassVar[str] = "active-set"
    order: ClassVar[int] = 1
    inertia: ClassVar[bool] = False

    def memory(self, nodes):
        return Newton().memory(nodes)

    def bind(self, equations, state):
        inner = Newton().bind(equations, state)

        def step(dt):
            done = inner(dt)
            return done  # noqa: RET504 - a piece of its own

        return step
