"""Factory of pairs: the only module that distinguishes the kinds of algorithms and pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from contactlab.api import ContactAlgorithm, ContactMethod, Floats, FrictionLaw, GapAlgorithm, Potential, Surface
from contactlab.api.arrays import Flags
from contactlab.contact.corner_pair import CornerPair, CornerPoints
from contactlab.contact.gap_pair import GapPair
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair

if TYPE_CHECKING:
    from contactlab.contact.linearisation import Linearisation


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
    """Return a pair of slave and master at work; `fixed` (m,) marks slave nodes that cannot move.

    Potentials get the material `behind` each node (N,): a modulus [MPa], and modulus over cell depth [MPa/mm].
    """
    if isinstance(algorithm, Potential):
        from contactlab.contact.potential_pair import PotentialPair

        ones = np.ones(len(reference))
        return PotentialPair(name, algorithm, sides, reference, first_slot, friction, behind or (ones, ones))
    if isinstance(algorithm, CornerPoints):
        return CornerPair(name, algorithm, *sides, reference, first_slot, friction)
    if isinstance(algorithm, GapAlgorithm):
        return GapPair(name, algorithm, *sides, reference, first_slot, friction)
    assert isinstance(algorithm, ContactAlgorithm)
    if algorithm.points_press:
        from contactlab.contact.points_pair import PointsPair

        return PointsPair(name, algorithm, *sides, reference, first_slot, friction, fixed)
    return OperatorPair(name, algorithm, *sides, reference, first_slot, friction, fixed)


def twin(pair: ContactPair, reference: Floats) -> ContactPair:
    """Return a pair of the same constraints that shares no array with it, without friction, with gaps in full."""
    fixed = pair.coupling.fixed if isinstance(pair, OperatorPair) else np.zeros(len(pair.slave.nodes), np.bool_)
    return contact_pair(pair.name, pair.method, (pair.slave, pair.master), reference, pair.first_slot, None, fixed)


def linearised(pair: ContactPair, nodes: int, consistent: bool = False, in_time: bool = False) -> Linearisation:
    """Return the linearisation of a pair at trial positions, in a model of `nodes` nodes.

    consistent  normal forces act along the derivatives of the gaps; in_time: by rows of a whole step
    """
    if isinstance(pair, CornerPair):
        from contactlab.contact.gap_linearisation import CornerLinearisation

        found: Linearisation = CornerLinearisation(pair, nodes)
    elif isinstance(pair, GapPair):
        from contactlab.contact.gap_linearisation import GapLinearisation

        found = GapLinearisation(pair, nodes)
    elif pair.half:
        from contactlab.contact.half_passes import HalfPassLinearisation

        found = HalfPassLinearisation(cast("OperatorPair", pair), nodes)
    else:
        from contactlab.contact.linearisation import ConsistentLinearisation, PairLinearisation

        kind = ConsistentLinearisation if consistent and not in_time else PairLinearisation
        found = kind(cast("OperatorPair", pair), nodes)
        if found.pair.corners is not None:
            from contactlab.contact.taken_linearisation import TakenLinearisation

            found = TakenLinearisation(found, found.pair.corners)
    if in_time:
        from contactlab.contact.step_rows import StepRows

        return StepRows(found)
    return found
