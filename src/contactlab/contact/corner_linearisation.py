"""Points at corners of the master for implicit integrators."""

from __future__ import annotations

import numpy as np

from contactlab.api import ConditionDerivatives
from contactlab.contact.corner_pair import CornerPair
from contactlab.contact.gap_linearisation import GapLinearisation


class CornerLinearisation(GapLinearisation):
    """Derivatives of the weights in closed form: as segments turn, and as corners slide along them."""

    pair: CornerPair

    def _changes(self) -> ConditionDerivatives:
        touched, found = self.pair.touched, self._found
        value = np.zeros((len(touched), 3, 6, 2))
        for c, touch in enumerate(touched):
            turn = np.outer(np.outer((0.0, 1.0, -1.0), touch.outward).ravel() / touch.length, touch.along)
            slide = np.outer(touch.rates.ravel(), touch.outward)
            value[c] = turn, (touch.xi - 1.0) * turn + slide, -touch.xi * turn - slide
        entry = np.repeat(np.arange(len(found.node), dtype=np.int32), 6)
        moved = np.add.outer(2 * found.node.reshape(-1, 3), np.arange(2, dtype=np.int32)).reshape(-1, 6)
        return ConditionDerivatives(entry, np.repeat(moved, 3, axis=0).ravel(), value.reshape(-1, 2))
