"""Tables for the loops over segments and points: a view of a contact and its pieces, by the names of the contract."""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api import GapGradients, PieceDerivatives, Pieces, Surface
from contactlab.api.compiled.bound_arrays import Flags1, Floats1, Floats2, Ints1


class At(NamedTuple):
    """Positions of the nodes of both sides [mm]."""

    slave: Floats2
    master: Floats2


class Near(NamedTuple):
    """Master segments near slave segment s: master[start[s]:start[s + 1]]."""

    start: Ints1
    master: Ints1


class View(NamedTuple):
    """A `ContactView`."""

    slave: Surface
    master: Surface
    at: At
    near: Near


class Both(NamedTuple):
    """A view, its pieces, and the numbers (n, 1) among the fields of the algorithm."""

    sides: View
    out: Pieces
    numbers: Floats2


class Derived(NamedTuple):
    """`Both` with the derivatives."""

    both: Both
    changes: PieceDerivatives


class Separated(NamedTuple):
    """`Both` with the owner and the separation of each multiplier, and the gradients."""

    both: Both
    owner: Ints1
    separation: Floats2
    gradients: GapGradients


class Points(NamedTuple):
    """A view, its pieces, and arrays for measures of both surfaces.

    In pieces at points, `segment` has the point (the node, or the Gauss point's number along the slave; under a
    corner of the master -1 less the slave's segment) and its contact (the master's segment; -1 less the vertex).
    `ends` has xi of the point in its segment, eta of its projection, and a flag for s, -1 to 1, on a quadratic edge.

    numbers    (n, 1) the numbers among the fields of the algorithm
    memory     of nodes: the segment plus one, 0 for none; the corner plus one. Of Gauss points: the segment plus one
    slave_normal, slave_length    of slave segments (s, 2), (s,) [mm]
    master_normal, master_length  of master segments
    outward    (m, 2) averaged normals of slave nodes
    tributary  (m,) [mm] the length of slave surface of each node
    rival      (m,) the same node on the other flank of a corner of the slave, elsewhere the slave node itself
    taken      (m,) True if a slave node has two constraints of its own
    carried    (m,) the corner whose constraint a slave node carries plus one, 0 for none
    corner_on, corner_share  (l,) the slave segment that each corner of the master presses on, -1 for none; share on it
    psi        (k,) [mm] weights of the multipliers at the present point
    """

    sides: View
    out: Pieces
    numbers: Floats2
    memory: Floats2
    slave_normal: Floats2
    slave_length: Floats1
    master_normal: Floats2
    master_length: Floats1
    outward: Floats2
    tributary: Floats1
    rival: Ints1
    taken: Flags1
    carried: Ints1
    corner_on: Ints1
    corner_share: Floats1
    psi: Floats1


class DerivedPoints(NamedTuple):
    """`Points` with the derivatives."""

    points: Points
    changes: PieceDerivatives


class TurnedPoints(NamedTuple):
    """`Points` with the gradients."""

    points: Points
    gradients: GapGradients
