"""Mortar contact with one multiplier per slave node, piecewise constant or linear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Candidates, ContactAlgorithm, Floats, Pieces, Surface, SurfacePositions

DEPTH = 2.0  # segment lengths: deeper overlaps are the far side of a thin body, not contact


class _Mortar(ContactAlgorithm):
    """What both multiplier spaces share: the overlaps and their integrals."""

    passes_patch_test: ClassVar[bool] = True
    linear: ClassVar[bool]

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
        from contactlab_mortar.segments import mortar_pieces

        length, outward = _outward_normals(slave, at)
        np.negative(outward, out=out.normal)
        return mortar_pieces(
            (slave.segments, slave.edges, slave.segment_edge),
            (master.segments, master.edges, master.segment_edge),
            at.slave,
            at.master,
            outward,
            (near.start, near.master),
            reach,
            DEPTH * length.max(),
            self.linear,
            np.empty(6),
            (out.slave, out.multiplier, out.master, out.D, out.M, out.T),
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
        """Averaged slave normals, turned to point away from the master."""
        np.negative(_outward_normals(slave, at)[1], out=out)


def _outward_normals(slave: Surface, at: SurfacePositions) -> tuple[Floats, Floats]:
    """Segment lengths (s,) and averaged nodal normals (m, 2) of the slave."""
    from contactlab.api.chains import nodal_normals, segment_normals

    normal, length = np.empty((len(slave.segments), 2)), np.empty(len(slave.segments))
    segment_normals(at.slave, slave.segments, normal, length)
    outward = np.empty((len(slave.nodes), 2))
    nodal_normals(slave.node_segments, normal, length, outward)
    return length, outward


@dataclass(frozen=True)
class MortarP0(_Mortar):
    """Multipliers constant on the cell of each slave node (formulation 3.4; Baillet & Sassi 2005, M_h^0)."""

    linear: ClassVar[bool] = False


@dataclass(frozen=True)
class MortarP1(_Mortar):
    """Multipliers continuous and linear on slave segments (formulation 3.4; Baillet & Sassi 2005, M_h^1)."""

    linear: ClassVar[bool] = True
