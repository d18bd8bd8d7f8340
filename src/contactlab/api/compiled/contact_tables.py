"""Tables for contact kernels: the surfaces, segment contributions and rows of `contactlab.api` as bound arrays.

A table has the same array fields, in the same order, as the object that it is named after; a kernel gets it by
`unpack`.
"""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api.compiled.bound_arrays import Floats1, Floats2, Floats3, Floats5, Ints1, Ints2

__all__ = ["FactoredGradientsTable", "FactoredTable", "GradientsTable", "PiecesTable", "RowsTable", "SurfaceTable"]


class SurfaceTable(NamedTuple):
    """The arrays of a `Surface`, without its nodes."""

    segments: Ints2
    node_segments: Ints2
    edges: Ints2
    segment_edge: Ints2


class PiecesTable(NamedTuple):
    """The arrays of `Pieces`."""

    slave: Ints2
    multiplier: Ints2
    master: Ints2
    D: Floats3
    M: Floats3
    T: Floats3
    normal: Floats2


class GradientsTable(NamedTuple):
    """The arrays of `GapGradients`."""

    multiplier: Ints2
    node: Ints2
    value: Floats5
    normal_of: Ints1
    normal_moved: Ints1
    dnormal: Floats2


class RowsTable(NamedTuple):
    """The arrays of `Rows`."""

    start: Ints1
    node: Ints1
    normal_weight: Floats2
    tangent_weight: Floats2
    gap: Floats1
    slip: Floats1
    measure: Floats1
    size: Floats1
    slot: Ints1
    offset: Floats1
    bound: Floats2
    work: Floats2


class FactoredTable(NamedTuple):
    """The arrays of `FactoredRows`."""

    start: Ints1
    node: Ints1
    weight: Floats1
    own: Ints1
    normal: Floats2
    gap: Floats1
    size: Floats1
    slot: Ints1
    above: Floats1
    below: Floats1
    inverse: Floats1
    left: Floats1


class FactoredGradientsTable(NamedTuple):
    """The arrays of `FactoredGradients`, those of its `FactoredRows` as `factors`."""

    factors: FactoredTable
    block: Floats3
    nodes: Ints1
    angle_start: Ints1
    angle: Ints1
    lever: Floats2
    ends: Ints2
    turn: Floats2
    own_angle: Ints1
    spin: Floats1
    offset: Floats1
    used: Ints1
