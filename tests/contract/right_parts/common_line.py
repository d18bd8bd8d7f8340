# kind contact cls Line
from dataclasses import dataclass

from contactlab_segments.midplane import Midplane


@dataclass(frozen=True)
class Line(Midplane):
    """Contact on a common line, looked at from outside."""

    def hessian(self, view, positions):
        return super().hessian(view, positions)

    def friction_gradient(self, view, positions):
        return super().friction_gradient(view, positions)

    def friction_hessian(self, view, positions):
        return super().friction_hessian(view, positions)

    def nodal_forces(self, view, positions):
        found = super().nodal_forces(view, positions)
        return found  # noqa: RET504 - a piece of its own
