"""Several grids made into one."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from contactlab.api import Floats, Ints, Mesh

SAME = 1e-9  # of the mesh's extent: nodes of two grids nearer than this are one


def welded(grids: Iterable[Mesh]) -> Mesh:
    """One mesh of several grids that touch: coincident nodes become one, edge sets of one name are joined.

    Nodes keep the order in which the grids bring them.
    """
    grids = list(grids)
    first = np.cumsum([0, *(len(grid.nodes) for grid in grids)])
    nodes = np.concatenate([grid.nodes for grid in grids])
    number = _merged(nodes)
    kept, final = np.unique(number, return_inverse=True)
    final = final.astype(np.int32)
    edges: dict[str, list[Ints]] = {}
    for grid, begin in zip(grids, first, strict=False):
        for name, some in grid.edges.items():
            edges.setdefault(name, []).append(final[some + begin])
    cells = np.concatenate([final[grid.cells + begin] for grid, begin in zip(grids, first, strict=False)])
    return Mesh(np.ascontiguousarray(nodes[kept]), cells, {name: np.concatenate(some) for name, some in edges.items()})


def _merged(nodes: Floats) -> Ints:
    """Find for every node the lowest node at its place."""
    from scipy.spatial import cKDTree

    number = np.arange(len(nodes))
    for a, b in sorted(cKDTree(nodes).query_pairs(SAME * float(np.ptp(nodes, axis=0).max()))):
        number[b] = min(number[b], number[a])
    return number.astype(np.int32)
