"""What the kernels of mortar contact work on, in tables."""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api.compiled.bound_arrays import Floats2, Floats3, Ints1, Ints2
from contactlab.api.compiled.contact_tables import GradientsTable, PiecesTable, SurfaceTable


class SidesTable(NamedTuple):
    """Both surfaces, positions of their nodes [mm], and the near list.

    Near slave segment s are the candidates from start[s] to start[s + 1].
    """

    slave: SurfaceTable
    master: SurfaceTable
    slave_at: Floats2
    master_at: Floats2
    start: Ints1
    candidates: Ints1


class MortarTable(NamedTuple):
    """All that pieces are made from and written to.

    feet  (p, 4) where each piece begins and ends, see `ContactAlgorithm.feet`; or nothing
    made  (2,) how many pieces those are, and how many normals of the slave are not the averaged ones
    """

    sides: SidesTable
    pieces: PiecesTable
    feet: Floats2
    made: Ints1


class FeetTable(NamedTuple):
    """Surfaces, pieces, and room for averaged normals (m, 2)."""

    sides: SidesTable
    pieces: PiecesTable
    averaged: Floats2


class ChangesTable(NamedTuple):
    """The arrays of `PieceDerivatives`."""

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


class DerivativesTable(NamedTuple):
    """All that derivatives are made from and written to; averaged (m, 2) are the slave's inward normals."""

    sides: SidesTable
    pieces: PiecesTable
    averaged: Floats2
    out: ChangesTable


class SeparationsTable(NamedTuple):
    """All that gradients are made from and written to; owner and separation as in `ContactAlgorithm.gradients`."""

    sides: SidesTable
    pieces: PiecesTable
    averaged: Floats2
    owner: Ints1
    separation: Floats2
    out: GradientsTable
