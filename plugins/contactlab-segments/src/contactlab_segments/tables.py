"""What the kernels of node-on-segment contact work on, in one table."""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api.compiled.bound_arrays import Flags1, Floats1, Floats2, Ints1
from contactlab.api.compiled.contact_tables import PiecesTable, SurfaceTable


class PairingTable(NamedTuple):
    """All that pieces are made from and written to.

    slave, master    the surfaces, slave_at (m, 2) and master_at (l, 2) [mm] where their nodes are
    start            near slave segment s are the candidates from start[s] to start[s + 1]
    memory           (2, m) of the last step: the segment plus one, 0 for none; the corner plus one
    slave_normal, slave_length    of slave segments (s, 2), (s,) [mm]
    master_normal, master_length  of master segments
    outward          (m, 2) averaged normals of slave nodes
    tributary        (m,) [mm] the length of slave surface that each node stands for
    taken            (m,) whether a slave node has two conditions of its own
    carried          (m,) the corner whose condition a slave node carries plus one, 0 for none
    corner_on        (l,) the slave segment that each corner of the master presses on, -1 for none
    corner_share     (l,) where on it
    """

    slave: SurfaceTable
    master: SurfaceTable
    slave_at: Floats2
    master_at: Floats2
    start: Ints1
    candidates: Ints1
    memory: Floats2
    slave_normal: Floats2
    slave_length: Floats1
    master_normal: Floats2
    master_length: Floats1
    outward: Floats2
    tributary: Floats1
    taken: Flags1
    carried: Ints1
    corner_on: Ints1
    corner_share: Floats1
    pieces: PiecesTable
