"""Detection of surfaces that pass through each other in a motion of any length."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from contactlab.api import Floats
from contactlab.contact.pair import ContactPair
from contactlab.kernels.contact.passing import find_passages


class Passage(NamedTuple):
    """The first node that passes through the other side of its pair: the share of the motion, and the node."""

    share: float
    pair: ContactPair
    node: int


def first_passage(pairs: Iterable[ContactPair], before: Floats, after: Floats, depth: float) -> Passage | None:
    """Return the first node of any pair that is more than `depth` segments inside the other side after a motion.

    Nodes of a slave that is much finer than its master may be as deep as constraints can hold them.
    All nodes move along straight lines from `before` to `after` (N, 2). Nodes that come out behind the other side count
    as well: the contact that holds them is in front of it.
    """
    found = None
    for pair in pairs:
        sides = (pair.slave, pair.master, pair.held), (pair.master, pair.slave, pair.size)
        for own, other, unit in sides:
            points, chain = ((before[surface.nodes], after[surface.nodes], surface.nodes) for surface in (own, other))
            shares = find_passages(points, chain, other.segments, depth * unit)
            first = int(np.argmin(shares))
            if shares[first] < (found.share if found is not None else np.inf):
                found = Passage(float(shares[first]), pair, int(own.nodes[first]))
    return found
