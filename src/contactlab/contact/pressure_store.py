"""The energy that surfaces hold under a normal law."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, NormalLaw
from contactlab.contact.pair import ContactPair, initial_gaps


class PressureStore:
    """Length times the integral of the pressure over all conditions, at the positions of the last ones.

    stiffness  (k,) [MPa/mm] of the cells behind each slot
    beginning  [mJ] at the start of the run
    """

    def __init__(self, law: NormalLaw, pairs: tuple[ContactPair, ...], stiffness: Floats, reference: Floats) -> None:
        self.law, self.pairs, self.stiffness = law, pairs, stiffness
        for pair in pairs:
            initial_gaps(pair, reference)
        self.beginning = self.energy()

    def energy(self) -> float:
        """The energy [mJ] now."""
        total = 0.0
        for pair in self.pairs:
            own = pair.own
            gaps = np.minimum(pair.gaps[:, 0], self.law.begins())
            total += pair.share * float(pair.cover @ self.law.energy(gaps, self.stiffness[own], pair.full))
        return total

    def since_start(self) -> float:
        """What has come to it since the start [mJ]."""
        return self.energy() - self.beginning
