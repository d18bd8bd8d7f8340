"""Kinks of contact surfaces, which belong to the shape, unlike turns of a curve, which finer cells follow."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, Surface
from contactlab.api.arrays import Flags
from contactlab.meshing.turns import facet_lengths, turns

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair

KINK = 1e-3, 0.3  # rad: smaller turns are rounded coordinates, larger ones falsify pressures along one normal


def kinks(surface: Surface, reference: Floats) -> Flags:
    """Nodes (m,) at which the surface turns and no curve does: the apex of a wedge, where pressures have a cusp."""
    angle = np.abs(turns(surface, reference))
    return np.asarray((angle > KINK[0]) & (angle < KINK[1]) & ~np.isfinite(facet_lengths(surface, reference)))


def cusps(pair: ContactPair, reference: Floats) -> Flags:
    """Slave nodes (m,) where exact pressures may have a cusp: kinks of the slave, or nearest to kinks of the master."""
    found = kinks(pair.slave, reference)
    for point in pair.at.master[kinks(pair.master, reference)]:
        if np.isfinite(point).all():
            found[np.hypot(*(pair.at.slave - point).T).argmin()] = True
    return found
