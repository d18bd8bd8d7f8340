"""Nodal forces of contact at a trial state."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, ImplicitEquations


class ContactForces:
    """Forces [N] that the trial's multipliers put on the nodes.

    normal      (N, 2)
    tangential  (N, 2), or (0, 2) without friction
    """

    def __init__(self, equations: ImplicitEquations) -> None:
        nodes, self.contact = len(equations.reference), equations.contact
        friction = self.contact is not None and len(self.contact.conditions.slip) > 0
        self.normal: Floats = np.zeros((nodes, 2))
        self.tangential: Floats = np.zeros((nodes if friction else 0, 2))

    def add_to(self, out: Floats, weight: float = 1.0) -> None:
        """Compute both at the present multipliers, and add them times a weight to `out` (N, 2)."""
        if self.contact is None:
            return
        self.contact.forces(self.normal, self.tangential)
        out += weight * self.normal
        if len(self.tangential):
            out += weight * self.tangential

    def total(self) -> Floats:
        """Both together (N, 2), as they were computed last."""
        return self.normal + self.tangential if len(self.tangential) else self.normal
