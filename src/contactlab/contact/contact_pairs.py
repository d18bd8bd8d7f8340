"""The pair for an algorithm: the one place that tells the kinds of algorithms and of pairs apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import ContactAlgorithm, ContactMethod, Floats, FrictionLaw, GapAlgorithm, Potential, Rows, Surface
from contactlab.api.arrays import Flags
from contactlab.contact.gap_pair import GapPair
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair

if TYPE_CHECKING:
    from contactlab.contact.gap_linearisation import GapLinearisation
    from contactlab.contact.gradients import PairGradients
    from contactlab.contact.linearisation import PairLinearisation


def contact_pair(
    name: str,
    algorithm: ContactMethod,
    sides: tuple[Surface, Surface],
    reference: Floats,
    first_slot: int,
    friction: FrictionLaw | None,
    fixed: Flags,
    behind: tuple[Floats, Floats] | None = None,
) -> ContactPair:
    """A pair of slave and master at work; `fixed` (m,) marks slave nodes that cannot move.

    Potentials see what is `behind` each node (N,): a modulus [MPa], and that over the depth of its cells [MPa/mm].
    """
    if isinstance(algorithm, Potential):
        from contactlab.contact.potential_pair import PotentialPair

        ones = np.ones(len(reference))
        return PotentialPair(name, algorithm, sides, reference, first_slot, friction, behind or (ones, ones))
    if isinstance(algorithm, GapAlgorithm):
        return GapPair(name, algorithm, *sides, reference, first_slot, friction)
    assert isinstance(algorithm, ContactAlgorithm)
    if algorithm.points_press:
        from contactlab.contact.points_pair import PointsPair

        return PointsPair(name, algorithm, *sides, reference, first_slot, friction, fixed)
    return OperatorPair(name, algorithm, *sides, reference, first_slot, friction, fixed)


def twin(pair: ContactPair, reference: Floats) -> ContactPair:
    """A pair of the same conditions that shares no array with it; it has no friction, and counts gaps in full."""
    fixed = pair.coupling.fixed if isinstance(pair, OperatorPair) else np.zeros(len(pair.slave.nodes), np.bool_)
    return contact_pair(pair.name, pair.method, (pair.slave, pair.master), reference, pair.first_slot, None, fixed)


def linearised(pair: ContactPair, nodes: int) -> PairLinearisation | GapLinearisation:
    """Gaps and slips of a pair at trial positions and their derivatives, in a model of so many nodes."""
    if isinstance(pair, GapPair):
        from contactlab.contact.gap_linearisation import GapLinearisation

        return GapLinearisation(pair, nodes)
    from contactlab.contact.linearisation import PairLinearisation

    assert isinstance(pair, OperatorPair)
    if pair.half:
        from contactlab.contact.half_passes import HalfPassLinearisation

        return HalfPassLinearisation(pair, nodes)
    return PairLinearisation(pair, nodes)


class FinishedRows:
    """Rows of a pair whose conditions come finished: their weights are the derivatives of its gaps already."""

    def __init__(self, pair: ContactPair) -> None:
        self.pair = pair

    def append_rows(
        self, out: Rows, entries: int, margin: float, multipliers: Floats, current: Floats, memory: Floats
    ) -> int:
        """As `ContactPair.append_rows`."""
        return self.pair.append_rows(out, entries, margin, multipliers, current)


def consistent_rows(pair: ContactPair) -> PairGradients | FinishedRows:
    """Rows of a pair with consistent forces, as an object that appends them."""
    if not isinstance(pair, OperatorPair):
        return FinishedRows(pair)
    from contactlab.contact.gradients import PairGradients

    return PairGradients(pair)
