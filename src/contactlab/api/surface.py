"""Contact surfaces: chains of boundary nodes with the body on their left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.compiled.bound_arrays import Ints2, KernelArgument


@dataclass(frozen=True)
class Surface(KernelArgument):
    """The boundary nodes of one contact side, cut into straight segments.

    Quadratic edges count as two segments, so that geometry is always piecewise straight; their
    trace functions belong to the `edges`.

    nodes         (m,) int32, global node numbers; chain order within each connected part
    segments      (s, 2) int32, start and end of each segment as positions in `nodes`
    node_segments (m, 2) int32, segment that ends and segment that starts at each node, -1 for none
    edges         (e, b) int32, element edges as positions in `nodes`: start, end, then inner
    segment_edge  (s, 2) int32, edge of each segment and which half of it (0 first, 1 second)
    """

    nodes: Ints
    segments: Ints2
    node_segments: Ints2
    edges: Ints2
    segment_edge: Ints2

    def lengths(self, at: Floats) -> Floats:
        """Return lengths (s,) [mm] of the segments with the nodes at positions `at` (m, 2) [mm]."""
        edge = at[self.segments[:, 1]] - at[self.segments[:, 0]]
        return np.asarray(np.hypot(edge[:, 0], edge[:, 1]))


class Candidates(NamedTuple):
    """For every slave segment the master segments whose enlarged boxes overlap its own box.

    start  (s + 1,) int32 row pointers
    master (z,) int32 master segments, ascending within a row
    reach  [mm]: segments farther apart than this may be missing from the list
    """

    start: Ints
    master: Ints
    reach: float


class SurfacePositions(NamedTuple):
    """Positions of the surface nodes (m, 2) [mm]."""

    slave: Floats
    master: Floats
