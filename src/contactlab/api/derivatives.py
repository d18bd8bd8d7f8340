"""Derivatives of a contact algorithm's local pieces, from which the core linearises gaps and forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.compiled.bound_arrays import Floats2, Floats3, Floats5, Ints1, Ints2, KernelArgument


@dataclass
class PieceDerivatives(KernelArgument):
    """Arrays for the derivatives of D, M, T and the normals with respect to positions of surface nodes.

    One entry for each piece and each coordinate that it depends on; entries that are all zero may be
    left out. `count` and `normal_count` are in use. `moved` is the coordinate: 2 * node + direction,
    where node is a position in the slave surface, or m + a position in the master surface.

    slave, multiplier, master  (capacity, s), (capacity, k), (capacity, r) int32, as in the piece
    moved   (capacity,) int32
    dD, dM  (capacity, s, k), (capacity, r, k) [-]  d(piece)/d(coordinate)
    dT      (capacity, k, k) [-]
    normal_of     (normal_capacity,) int32  multiplier whose normal it is
    normal_moved  (normal_capacity,) int32
    dnormal       (normal_capacity, 2) [1/mm]
    """

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
    count: int = 0
    normal_count: int = 0

    @classmethod
    def allocate(cls, capacity: int, widths: tuple[int, int, int], normal_capacity: int) -> PieceDerivatives:
        """Allocate `capacity` entries of pieces with `widths` (s, k, r)."""
        s, k, r = widths
        return cls(
            np.zeros((capacity, s), np.int32),
            np.zeros((capacity, k), np.int32),
            np.zeros((capacity, r), np.int32),
            np.zeros(capacity, np.int32),
            np.zeros((capacity, s, k)),
            np.zeros((capacity, r, k)),
            np.zeros((capacity, k, k)),
            np.zeros(normal_capacity, np.int32),
            np.zeros(normal_capacity, np.int32),
            np.zeros((normal_capacity, 2)),
        )


@dataclass(frozen=True)
class ConditionDerivatives:
    """Derivatives of the normal weights of finished gap constraints by single positions; zeros may be left out.

    Tangent weights turn with the normal weights, and gaps are sums of weights times positions, so both follow.

    entry  (t,) int32  entry of `GapConditions.node` whose weight changes
    moved  (t,) int32  coordinate of the derivative: 2 * global node + direction
    value  (t, 2) [1/mm]  d(normal_weight of the entry)/d(coordinate)
    """

    entry: Ints
    moved: Ints
    value: Floats


@dataclass(eq=False)
class GapGradients(KernelArgument):
    """Arrays for the derivatives of the weighted separations D^T x - M^T y - T^T r of the pieces.

    Only the part from changing weights: the positions x, y and separations r that they multiply are held fixed.
    Nodes are positions in the slave surface, or m + a position in the master surface; -1 for none. `count` and
    `normal_count` are in use.

    multiplier  (capacity, k) int32, as in the piece
    node        (capacity, v) int32 nodes that its weights depend on
    value       (capacity, k, 2, v, 2) [mm]  d(component of the separation times length)/d(coordinate of the node)
    normal_of, normal_moved, dnormal  as in `PieceDerivatives`
    """

    multiplier: Ints2
    node: Ints2
    value: Floats5
    normal_of: Ints1
    normal_moved: Ints1
    dnormal: Floats2
    count: int = 0
    normal_count: int = 0

    @classmethod
    def allocate(cls, capacity: int, multipliers: int, nodes: int, normal_capacity: int) -> GapGradients:
        """Allocate `capacity` pieces with `multipliers` multipliers each that depend on `nodes` nodes."""
        return cls(
            np.zeros((capacity, multipliers), np.int32),
            np.zeros((capacity, nodes), np.int32),
            np.zeros((capacity, multipliers, 2, nodes, 2)),
            np.zeros(normal_capacity, np.int32),
            np.zeros(normal_capacity, np.int32),
            np.zeros((normal_capacity, 2)),
        )
