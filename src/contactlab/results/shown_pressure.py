"""Contact tractions as they are shown: multipliers, which are no tension or shear where nodes are open."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import ContactCurve

APART = 1.1  # largest multiplier over largest nodal pressure: beyond it the mesh does not resolve the peak


def shown_pressure(curve: ContactCurve) -> Floats:
    """Multipliers (m,) of closed nodes; open ones have none, whatever value balances their neighbours."""
    return np.where(curve.state == 0, curve.nodal_pressure, curve.pressure)


def shown_shear(curve: ContactCurve) -> Floats:
    """Multipliers (m,) of closed nodes, 0 elsewhere."""
    return np.where(curve.state == 0, 0.0, curve.shear)


def other_peak(contact: Mapping[str, Any]) -> float | None:
    """Largest nodal pressure at the end, from an entry `contacts` of a summary; None if multipliers agree with it."""
    nodal, highest = contact.get("max_nodal_pressure"), contact.get("max_pressure")
    if nodal is None or highest is None or not 0.0 < APART * float(nodal) < float(highest):
        return None
    return float(nodal)
