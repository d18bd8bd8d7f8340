"""Mortar contact with one multiplier per slave node, piecewise constant or linear."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np

from contactlab.api import (
    Candidates,
    ContactAlgorithm,
    ContactView,
    Floats,
    GapGradients,
    Ints,
    PieceDerivatives,
    Pieces,
    Surface,
)
from contactlab.api.arrays import Flags
from contactlab.api.compiled.bound_arrays import BoundArrays, BoundCache
from contactlab.api.compiled.contact_tables import GradientsTable, PiecesTable, SurfaceTable
from contactlab.api.compiled.late import late

DEPTH = 2.0  # longest segment lengths: deeper overlaps are the far side of a thin body, not contact

_BOUND, _KEEPING, _GRADIENTS, _DERIVATIVES, _FEET = (BoundCache() for _ in range(5))


@dataclass(frozen=True)
class _Mortar(ContactAlgorithm):
    """What both multiplier spaces share: the overlaps and their integrals.

    multipliers  which nodes of quadratic slave edges carry them: "nodes" all, "vertices" those at ends of edges;
                 "auto" is all without friction and the ends with it (mortar-operators.md, quadratic edges)
    """

    multipliers: Literal["auto", "nodes", "vertices"] = "auto"

    passes_patch_test: ClassVar[bool] = True
    gradient_nodes: ClassVar[int] = 6
    linear: ClassVar[bool]

    def with_friction(self) -> ContactAlgorithm:
        """Multipliers at the ends of quadratic edges, unless told otherwise."""
        return replace(self, multipliers="vertices") if self.multipliers == "auto" else self

    def carriers(self, slave: Surface) -> Flags:
        """All nodes, or those at the ends of edges."""
        carries = np.ones(len(slave.nodes), np.bool_)
        if self.multipliers == "vertices":
            carries[slave.edges[:, 2:].ravel()] = False
        return carries

    def widths(self, slave: Surface, master: Surface) -> tuple[int, int, int]:
        """One slave edge, two multipliers, one master edge."""
        return slave.edges.shape[1], 2, master.edges.shape[1]

    def capacity(self, slave: Surface, near: Candidates) -> int:
        """One piece for each pair of near segments."""
        return len(near.master)

    def pieces(self, view: ContactView, out: Pieces) -> int:
        """Segment-wise D, M and T on the common abscissa; normals point from master to slave."""
        bound = _KEEPING.of(out, _bound_keeping, view) if out in _KEEPING else _BOUND.of(out, _bound, view)
        address, vertices = bound.address, self.multipliers == "vertices"
        return int(late("contactlab_mortar.segments").mortar_pieces(address, view.reach, DEPTH, self.linear, vertices))

    def gradients(
        self, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats, out: GapGradients
    ) -> bool:
        """Six nodes of each piece: of its slave segment, of those beside it, and of its master segment."""
        address = _GRADIENTS.of(out, _bound_gradients, view, pieces, owner, separation).address
        kernel, vertices = late("contactlab_mortar.gradients").mortar_gradients, self.multipliers == "vertices"
        out.count, out.normal_count = count, int(kernel(address, count, self.linear, vertices))
        return out.normal_count >= 0

    def feet(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> bool:
        """Ends of the overlaps: found again the first time, from then on `pieces` keeps those that it finds."""
        *_, feet, made = _KEEPING.of(pieces, _bound_keeping, view).arrays
        if made[0] == count:
            out[:count] = feet[:count]
            return not made[1]
        address = _FEET.of(pieces, _bound_feet, view).address
        return bool(late("contactlab_mortar.feet").mortar_feet(address, count, out))

    def derivatives(self, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
        """Derivatives of overlaps, integrals and normals."""
        address, vertices = (
            _DERIVATIVES.of(pieces, _bound_derivatives, view, out).address,
            self.multipliers == "vertices",
        )
        kernel = late("contactlab_mortar.derivatives").mortar_derivatives
        out.count, out.normal_count, smooth = kernel(address, count, self.linear, vertices)
        if not smooth:
            kernel = late("contactlab_mortar.vertex_derivatives").vertex_derivatives
            out.normal_count = kernel(address, count, out.count, out.normal_count)
        return True

    def normals(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> None:
        """Averaged slave normals, turned to point away from the master; with their own overlaps at vertices."""
        slave_normals, vertices = late("contactlab_mortar.normals"), late("contactlab_mortar.vertices")
        slave, at = view.slave, view.at
        slave_normals.inward_normals(at.slave, slave.segments, out)
        arrays = pieces.multiplier, pieces.master, pieces.T
        if vertices.turn_at_vertices(count, arrays, (slave.segments, slave.node_segments), at.slave, at.master, out):
            super().normals(view, pieces, count, out)


def _bound(out: Pieces, view: ContactView) -> BoundArrays:
    """The arrays that pieces are made from and written to."""
    return _bound_with(out, view, 0)


def _bound_keeping(out: Pieces, view: ContactView) -> BoundArrays:
    """The same with room for the ends of pieces."""
    return _bound_with(out, view, len(out.slave))


def _bound_with(out: Pieces, view: ContactView, ends: int) -> BoundArrays:
    table = late("contactlab_mortar.tables").MortarTable
    return BoundArrays(table, *_sides(view), *_arrays(out), np.zeros((ends, 4)), np.full(2, -1, np.int32))


def _bound_gradients(
    out: GapGradients, view: ContactView, pieces: Pieces, owner: Ints, separation: Floats
) -> BoundArrays:
    """The arrays that gradients are made from and written to."""
    return BoundArrays(
        late("contactlab_mortar.tables").SeparationsTable, *_sides(view), *_arrays(pieces),
        np.empty_like(pieces.normal), owner, separation,
        GradientsTable(out.multiplier, out.node, out.value, out.normal_of, out.normal_moved, out.dnormal),
    )  # fmt: skip


def _bound_feet(pieces: Pieces, view: ContactView) -> BoundArrays:
    """The arrays that the ends of pieces are found from."""
    table = late("contactlab_mortar.tables").FeetTable
    return BoundArrays(table, *_sides(view), *_arrays(pieces), np.empty_like(pieces.normal))


def _bound_derivatives(pieces: Pieces, view: ContactView, out: PieceDerivatives) -> BoundArrays:
    """The arrays that derivatives are made from and written to."""
    return BoundArrays(
        late("contactlab_mortar.tables").DerivativesTable, *_sides(view), *_arrays(pieces),
        np.empty_like(pieces.normal), out.slave, out.multiplier, out.master, out.moved, out.dD, out.dM, out.dT,
        out.normal_of, out.normal_moved, out.dnormal,
    )  # fmt: skip


def _arrays(of: Pieces) -> PiecesTable:
    return PiecesTable(of.slave, of.multiplier, of.master, of.D, of.M, of.T, of.normal)


def _sides(view: ContactView) -> tuple[Any, ...]:
    surfaces = (SurfaceTable(s.segments, s.node_segments, s.edges, s.segment_edge) for s in (view.slave, view.master))
    return (*surfaces, *view.at, view.near.start, view.near.master)


@dataclass(frozen=True)
class MortarP0(_Mortar):
    """Multipliers constant on the cell of each slave node (Baillet & Sassi 2005, M_h^0; mortar-operators.md)."""

    linear: ClassVar[bool] = False


@dataclass(frozen=True)
class MortarP1(_Mortar):
    """Multipliers continuous and linear on slave segments (Baillet & Sassi 2005, M_h^1; mortar-operators.md)."""

    linear: ClassVar[bool] = True
