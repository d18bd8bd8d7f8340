"""What the loops over segments work on: a view of a contact and its pieces, by the names of the contract."""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api import GapGradients, PieceDerivatives, Pieces, Surface
from contactlab.api.compiled.bound_arrays import Floats2, Ints1


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
    """The same and the derivatives."""

    both: Both
    changes: PieceDerivatives


class Separated(NamedTuple):
    """The same, the owner and the separation of each multiplier, and the gradients."""

    both: Both
    owner: Ints1
    separation: Floats2
    gradients: GapGradients
