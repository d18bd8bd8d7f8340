"""Two half passes: each side is the slave in a pass of its own, and takes the forces of that pass alone.

Sauer & De Lorenzis 2013. A pass with exchanged sides stands next to that of the contact. The tractions of both agree
as far as the meshes resolve them; nothing asks for it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from contactlab.api import Conditions, ContactDerivatives, Floats, Ints, NormalLaw, Response
from contactlab.contact.implicit_system import ImplicitContactSystem
from contactlab.contact.linearisation import PairLinearisation
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.contact.pressure_response import PressureResponse, rub

TRACE = 1e-150  # stands for zero in matrices: the solver wants patterns that are symmetric, and sums drop zeros
TOUCH = 1e-6  # segments: so shallow an overlap has the slope with which surfaces touch


class HalfPassLinearisation(PairLinearisation):
    """Forces of the slave's nodes alone, and their derivatives."""

    def __init__(self, pair: OperatorPair, nodes: int) -> None:
        super().__init__(pair, nodes)
        own = np.full((nodes, 2), TRACE)
        own[pair.slave.nodes] = 1.0
        self.own = own.ravel()
        self.given = np.zeros((2, nodes, 2))

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """As of a whole pass; forces on the master are left out."""
        found = super().linearise(chosen, y)
        matrix = found.force.tocsr()
        acts = np.repeat(self.own, np.diff(matrix.indptr))
        force = csr_array((acts * matrix.data, matrix.indices, matrix.indptr), matrix.shape) + TRACE * found.force.T
        normal, gap = self._acting(found.normal, found.gap)
        tangent, slip = (None, None) if found.tangent is None else self._acting(found.tangent, found.slip)
        return ContactDerivatives(normal, tangent, gap, slip, force.tocsr())

    def _acting(self, along: Any, change: Any) -> tuple[Any, Any]:
        """Directions (c, 2N) on the slave alone, and derivatives; both with the pattern of their sum."""
        along, change = along.tocsr(), change.tocsr()
        own = csr_array((self.own[along.indices] * along.data, along.indices, along.indptr), along.shape)
        return (own + TRACE * change).tocsr(), (change + TRACE * along).tocsr()

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add the nodal forces of the slave to (N, 2) each; the second is (0, 2) without friction."""
        own, given = self.pair.slave.nodes, self.given
        given[:] = 0.0
        super().add_forces(multipliers, given[0], given[1, : len(tangential)])
        normal[own] += given[0, own]
        if len(tangential):
            tangential[own] += given[1, own]


class HalfPassResponse(PressureResponse):
    """Residuals of pressures, and friction of half passes by springs that are as stiff as the law where surfaces touch.

    What sticks exactly in both passes would leave the shear of either side undetermined. Other pairs stick exactly.

    half  (k,) whether a slot belongs to a half pass
    """

    def __init__(self, law: NormalLaw, stiffness: Floats, passes: tuple[ContactPair, ...]) -> None:
        super().__init__(law, stiffness)
        self.half = np.concatenate([np.full(pair.slots, pair.half) for pair in passes])

    def rub(self, c: Conditions, out: Response) -> None:
        """Springs from the force at the start of the step, within the bound."""
        shear = c.measure * shear_stiffness(self.law, self.stiffness, c.size)
        softness = np.divide(1.0, shear, out=np.zeros_like(shear), where=self.half & c.present & (shear > 0.0))
        rub(replace(c, slip=c.slip + softness * (c.force[1] - c.anchor[1])), out)
        out.by_force[1] += out.by_gap[1] * softness


class HalfPassSystem(ImplicitContactSystem):
    """Pairs of which some are half passes: friction is booked by both, half from each."""

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Nothing along which motion would be stopped: impulses on one side alone would change momentum."""
        none = csr_array((len(chosen), self.start.size))
        return none, none if self.friction else None


def shear_stiffness(law: NormalLaw, stiffness: Floats, size: Floats) -> Floats:
    """Shear per slip (k,) [MPa/mm]: what the pressure grows by, per overlap, where surfaces touch."""
    depth = TOUCH * np.where(size > 0.0, size, 1.0)
    pressure, slope = np.zeros_like(depth), np.zeros_like(depth)
    law.pressure(np.minimum(-depth, law.begins()), stiffness, size, pressure, slope)
    return -slope
