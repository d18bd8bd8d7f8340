"""How much shorter the segments of masters are than those of their slaves."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from contactlab.api import Floats, Surface
from contactlab.api.arrays import Flags
from contactlab.model.contact.near_list import segment_lengths
from contactlab.model.contact.pair import ContactPair


def shorter_masters(pairs: Iterable[ContactPair], immobile: Flags) -> float:
    """Largest ratio [-] of a slave's segment length to its master's, of masters that can move; 0 where none can.

    Lengths are lower quartiles: graded meshes are fine where contact is expected. immobile (N,) marks nodes that
    cannot move.
    """
    ratios = [
        _typical(pair.at.slave, pair.slave) / _typical(pair.at.master, pair.master)
        for pair in pairs
        if not immobile[pair.master.nodes].all()
    ]
    return max(ratios, default=0.0)


def _typical(positions: Floats, surface: Surface) -> float:
    return float(np.quantile(segment_lengths(positions, surface), 0.25))
