"""All contact pairs under a normal law that depends on the stress of the cells behind the slave, in load increments."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from scipy.sparse import diags_array

from contactlab.api import Conditions, ContactDerivatives, Floats, Ints, NormalLaw
from contactlab.api.arrays import Flags
from contactlab.contact.implicit_system import ImplicitContactSystem
from contactlab.contact.pressure_response import PressureResponse
from contactlab.errors import WrongAnswer


class Tractions(Protocol):
    """Normal tractions at the slots of a model, by the last update of stresses."""

    def values(self) -> Floats:
        """Return (k,) [MPa], positive in tension."""

    def derivative(self) -> Any:
        """Return (k, 2N) [MPa/mm], sparse."""


class TractionResponse(PressureResponse):
    """Residuals y_n - length * pressure(gap, traction).

    found    (3, k) pressure and its derivatives by the gap and by the traction
    share    (k,) [mm/MPa] ratio of the second to the first of these derivatives: weight of a traction relative to a gap
             in the row of a constraint
    adjoint  (3, k) [mm] factors of the derivatives of tractions, and their derivatives by pressure and traction
    """

    def __init__(self, law: NormalLaw, stiffness: Floats, tractions: Tractions) -> None:
        super().__init__(law, stiffness)
        self.tractions, self.traction = tractions, np.zeros_like(stiffness)
        self.found, self.adjoint = np.zeros((2, 3, len(stiffness)))
        self.share = np.zeros_like(stiffness)
        self.first = 0.0  # tractions decide where pressures begin; surfaces meet there

    def press(self, c: Conditions) -> Flags:
        """Fill `found` and `share`. Return which constraints (k,) are closed."""
        closed, (_, slope, by_traction) = super().press(c), self.found
        if np.any(closed & (slope == 0.0) & (by_traction != 0.0)):
            raise WrongAnswer(
                f"{type(self.law).__name__}: a pressure follows the traction and not the gap, needed: a slope below 0 "
                "wherever there is a pressure"
            )
        self.share[:] = np.divide(by_traction, slope, out=np.zeros_like(slope), where=closed & (slope < 0.0))
        return closed

    def answer(self, gap: Floats, size: Floats, out: Floats) -> None:
        """Fill `out` (3, k) like `found` for gaps and sizes (k,) [mm]."""
        law: Any = self.law
        law.pressure(gap, self.stiffness, size, out[0], out[1], self.traction, out[2])

    def oppose(self, c: Conditions, length: Floats) -> None:
        """Fill `adjoint` for the trial multipliers, spread over `length` (k,) [mm]."""
        pressure = np.divide(c.force[0], length, out=np.zeros_like(length), where=length > 0.0)
        value, by_pressure, by_traction = self.adjoint
        self.law.adjoint(pressure, self.stiffness, c.size, value, by_pressure, self.traction, by_traction)


class TractionContactSystem(ImplicitContactSystem):
    """Constraints whose gaps count together with tractions, and forces along the derivatives of tractions.

    The forces are D^T (length * adjoint(y_n / length, traction)) with the derivatives D of the tractions. Second
    derivatives of tractions are left out: their weight is the difference of pressure and traction.
    """

    enforcement: TractionResponse

    def evaluate(self, position: Floats) -> None:
        """Fill `conditions`, tractions and the factors of their derivatives."""
        super().evaluate(position)
        own, c = self.enforcement, self.conditions
        own.traction[:], self._derivative = own.tractions.values(), None
        self.length = np.where(c.present, c.measure, 0.0)
        own.oppose(c, self.length)

    @property
    def acts(self) -> bool:
        """True as for every contact, and while tractions alone make forces."""
        return super().acts or bool(self.enforcement.adjoint.any())

    def forces(self, normal: Floats, tangential: Floats) -> None:
        """Fill forces of the constraints, and add forces along the derivatives of tractions to the normal forces."""
        super().forces(normal, tangential)
        own = self.enforcement
        own.oppose(self.conditions, self.length)
        if own.adjoint.any():
            normal += (self.derivative.T @ (self.length * own.adjoint[0])).reshape(-1, 2)

    @property
    def derivative(self) -> Any:
        """Return derivatives (k, 2N) [MPa/mm] of tractions at the last `evaluate`, sparse."""
        if self._derivative is None:
            self._derivative = self.enforcement.tractions.derivative()
        return self._derivative

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        """Return derivatives of the chosen slots; gaps and forces include the contribution of tractions."""
        found, own = super().linearise(chosen), self.enforcement
        behind, (_, by_pressure, by_traction) = self.derivative, own.adjoint
        found = found._replace(gap=(found.gap + diags_array(own.share[chosen]) @ behind[chosen]).tocsr())
        if not own.adjoint.any():
            return found
        along = diags_array(by_pressure[chosen]) @ behind[chosen]
        force = behind.T @ diags_array(self.length * by_traction) @ behind
        return found._replace(normal=(found.normal + along).tocsr(), force=(found.force + force).tocsr())
