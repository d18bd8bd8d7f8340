"""What the loops over segments work on: a view of a contact and its pieces, by the names of the contract."""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api.compiled.bound_arrays import Floats2, Floats3, Ints1, Ints2
from contactlab.api.compiled.contact_tables import GradientsTable, SurfaceTable


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

    slave: SurfaceTable
    master: SurfaceTable
    at: At
    near: Near


class Out(NamedTuple):
    """`Pieces`."""

    slave: Ints2
    multiplier: Ints2
    master: Ints2
    D: Floats3
    M: Floats3
    T: Floats3
    normal: Floats2
    ends: Floats2
    segment: Ints2


class Both(NamedTuple):
    """A view, its pieces, and the numbers (n, 1) among the fields of the algorithm."""

    sides: View
    out: Out
    numbers: Floats2


class Changes(NamedTuple):
    """`PieceDerivatives`."""

    slave: Ints2
    multiplier: Ints2
    master: Ints2
    moved: Ints1
    dD: Floats3
    dM: Floats3
    dT: Floats3
    normal_of: Ints1
    normal_moved: Ints1
    dnormal: Floats2


class Derived(NamedTuple):
    """The same and the derivatives."""

    both: Both
    changes: Changes


class Separated(NamedTuple):
    """The same, the owner and the separation of each multiplier, and the gradients."""

    both: Both
    owner: Ints1
    separation: Floats2
    gradients: GradientsTable
