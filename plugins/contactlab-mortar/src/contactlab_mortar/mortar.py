"""Mortar contact with one multiplier per slave node, piecewise constant or linear."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np

from contactlab.api import (
    Candidates,
    ContactAlgorithm,
    Floats,
    GapGradients,
    Ints,
    Pieces,
    PieceSlopes,
    Surface,
    SurfacePositions,
)
from contactlab.api.arrays import Flags
from contactlab.api.compiled.bound_arrays import BoundArrays

DEPTH = 2.0  # longest segment lengths: deeper overlaps are the far side of a thin body, not contact


class _Bound:
    """The arrays that pieces are made from and written to, bound for the kernel."""

    def __init__(self, slave: Surface, master: Surface, at: SurfacePositions, near: Candidates, out: Pieces) -> None:
        from contactlab_mortar.segments import ARRAYS, mortar_pieces

        self.of, self.kernel = (slave, master, at, near), mortar_pieces
        self.arrays = BoundArrays(
            ARRAYS, slave.segments, slave.node_segments, slave.edges, slave.segment_edge, master.segments, master.edges,
            master.segment_edge, at.slave, at.master, near.start, near.master, out.slave, out.multiplier, out.master,
            out.D, out.M, out.T, out.normal,
        )  # fmt: skip
        self.address = self.arrays.address

    def holds(self, slave: Surface, master: Surface, at: SurfacePositions, near: Candidates) -> bool:
        """Whether these are the very objects whose arrays are bound."""
        of = self.of
        return of[0] is slave and of[1] is master and of[2] is at and of[3] is near


class _BoundGradients:
    """The arrays that gradients are made from and written to, bound for the kernel."""

    def __init__(self, *of: Any) -> None:
        from contactlab_mortar.gradients import ARRAYS, mortar_gradients

        slave, master, at, near, pieces, owner, separation, out = of
        self.of, self.kernel = of, mortar_gradients
        self.arrays = BoundArrays(
            ARRAYS, slave.segments, slave.node_segments, slave.edges, slave.segment_edge, master.segments, master.edges,
            master.segment_edge, at.slave, at.master, near.start, near.master, pieces.multiplier, pieces.master,
            pieces.normal, owner, separation, out.multiplier, out.node, out.value, out.normal_of,
            out.normal_moved, out.dnormal,
        )  # fmt: skip

    def holds(self, *of: Any) -> bool:
        """Whether these are the very objects whose arrays are bound."""
        return all(mine is other for mine, other in zip(self.of, of, strict=True))


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

    def pieces(
        self,
        slave: Surface,
        master: Surface,
        at: SurfacePositions,
        near: Candidates,
        reach: float,
        memory: Floats,
        out: Pieces,
    ) -> int:
        """Segment-wise D, M and T on the common abscissa; normals point from master to slave."""
        bound = out.bound
        if bound is None or not bound.holds(slave, master, at, near):
            out.bound = bound = _Bound(slave, master, at, near, out)
        return int(bound.kernel(bound.address, reach, DEPTH, self.linear, self.multipliers == "vertices"))

    def gradients(
        self,
        slave: Surface,
        master: Surface,
        at: SurfacePositions,
        near: Candidates,
        pieces: Pieces,
        count: int,
        owner: Ints,
        separation: Floats,
        out: GapGradients,
    ) -> bool:
        """Six nodes of each piece: of its slave segment, of those beside it, and of its master segment."""
        of = (slave, master, at, near, pieces, owner, separation, out)
        bound = out.bound
        if bound is None or not bound.holds(*of):
            out.bound = bound = _BoundGradients(*of)
        out.count, out.normal_count = (
            count,
            int(bound.kernel(bound.arrays.address, count, self.linear, self.multipliers == "vertices")),
        )
        return out.normal_count >= 0

    def slopes(
        self,
        slave: Surface,
        master: Surface,
        at: SurfacePositions,
        near: Candidates,
        memory: Floats,
        pieces: Pieces,
        count: int,
        out: PieceSlopes,
    ) -> bool:
        """Derivatives of overlaps, integrals and normals."""
        from contactlab_mortar.segments import inward_normals
        from contactlab_mortar.slopes import mortar_slopes

        averaged = np.empty_like(pieces.normal)
        inward_normals(at.slave, slave.segments, slave.node_segments, averaged)
        out.count, out.normal_count = mortar_slopes(
            (slave.segments, slave.node_segments, slave.edges, slave.segment_edge),
            (master.segments, master.edges, master.segment_edge),
            at.slave,
            at.master,
            (near.start, near.master),
            self.linear,
            self.multipliers == "vertices",
            (count, pieces.multiplier, pieces.master, averaged),
            (out.slave, out.multiplier, out.master, out.moved, out.dD, out.dM, out.dT,
             out.normal_of, out.normal_moved, out.dnormal),
        )  # fmt: skip
        if not np.array_equal(averaged, pieces.normal):
            self._turned_slopes(slave, at, pieces, count, averaged, out)
        return True

    def _turned_slopes(
        self, slave: Surface, at: SurfacePositions, pieces: Pieces, count: int, averaged: Floats, out: PieceSlopes
    ) -> None:
        """Derivatives of the normals at vertices, in place of those of averaged ones."""
        from contactlab_mortar.vertex_slopes import vertex_slopes

        out.normal_count = vertex_slopes(
            (count, pieces.multiplier, pieces.master, pieces.T),
            (out.count, out.multiplier, out.master, out.moved, out.dT),
            (slave.segments, slave.node_segments),
            at.slave,
            at.master,
            averaged,
            out.normal_count,
            (out.normal_of, out.normal_moved, out.dnormal),
        )

    def normals(
        self,
        slave: Surface,
        master: Surface,
        at: SurfacePositions,
        near: Candidates,
        reach: float,
        memory: Floats,
        pieces: Pieces,
        count: int,
        out: Floats,
    ) -> None:
        """Averaged slave normals, turned to point away from the master; with their own overlaps at vertices."""
        from contactlab_mortar.segments import inward_normals

        inward_normals(at.slave, slave.segments, slave.node_segments, out)
        if self._turn(slave, at, pieces, count, out):
            super().normals(slave, master, at, near, reach, memory, pieces, count, out)

    def _turn(self, slave: Surface, at: SurfacePositions, pieces: Pieces, count: int, normals: Floats) -> int:
        """Normals at vertices of the slave become the master's; returns how many."""
        from contactlab_mortar.vertices import turn_at_vertices

        turned = turn_at_vertices(
            count,
            (pieces.multiplier, pieces.master, pieces.T),
            (slave.segments, slave.node_segments),
            at.slave,
            at.master,
            normals,
        )
        return int(turned)


@dataclass(frozen=True)
class MortarP0(_Mortar):
    """Multipliers constant on the cell of each slave node (Baillet & Sassi 2005, M_h^0; mortar-operators.md)."""

    linear: ClassVar[bool] = False


@dataclass(frozen=True)
class MortarP1(_Mortar):
    """Multipliers continuous and linear on slave segments (Baillet & Sassi 2005, M_h^1; mortar-operators.md)."""

    linear: ClassVar[bool] = True
