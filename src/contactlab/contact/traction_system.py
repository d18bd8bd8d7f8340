"""All contact pairs under a normal law that follows the stress of the cells behind the slave, in load steps."""

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
        """(k,) [MPa], positive in tension."""

    def derivative(self) -> Any:
        """(k, 2N) [MPa/mm], sparse."""


class TractionResponse(PressureResponse):
    """Residuals y_n - length * pressure(gap, traction).

    found  (3, k) pressure and its derivatives by the gap and by the traction
    share  (k,) [mm/MPa] of these derivatives the second over the first: as much does a traction count as a gap does in
           the row of a condition
    """

    def __init__(self, law: NormalLaw, stiffness: Floats, tractions: Tractions) -> None:
        super().__init__(law, stiffness)
        self.tractions, self.traction = tractions, np.zeros_like(stiffness)
        self.found, self.share = np.zeros((3, len(stiffness))), np.zeros_like(stiffness)
        self.first = 0.0  # tractions decide where pressures begin; surfaces meet there

    def press(self, c: Conditions) -> Flags:
        """Fill `found` and `share`; which conditions (k,) are closed."""
        self.traction[:] = self.tractions.values()
        closed, (_, slope, by_traction) = super().press(c), self.found
        if np.any(closed & (slope == 0.0) & (by_traction != 0.0)):
            raise WrongAnswer(
                f"{type(self.law).__name__}: a pressure follows the traction and not the gap, needed: a slope below 0 "
                "wherever there is a pressure"
            )
        self.share[:] = np.divide(by_traction, slope, out=np.zeros_like(slope), where=closed & (slope < 0.0))
        return closed

    def answer(self, gap: Floats, size: Floats, out: Floats) -> None:
        """Fill `out` (3, k) as `found` is for gaps and sizes (k,) [mm]."""
        law: Any = self.law
        law.pressure(gap, self.stiffness, size, out[0], out[1], self.traction, out[2])


class TractionContactSystem(ImplicitContactSystem):
    """Conditions whose gaps count together with tractions."""

    enforcement: TractionResponse

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        """Derivatives of the chosen slots; those of gaps with what tractions add to them."""
        found, own = super().linearise(chosen), self.enforcement
        added = diags_array(own.share[chosen]) @ own.tractions.derivative()[chosen]
        return found._replace(gap=(found.gap + added).tocsr())
