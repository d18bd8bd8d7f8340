"""Surfaces, contributions and couplings to try kernels of contact on, and what they are as dense matrices."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Floats, Ints, Surface
from contactlab.contact.coupling import Coupling
from contactlab.kernels.contact import coupling
from contactlab.kernels.contact.banded_rows import fill_columns
from contactlab.kernels.contact.tables import BandedRows
from contactlab.meshing.mesh import surface_from_edges

H = 1e-6  # of central differences over surfaces of size one: their error and round-off over H are below 1e-9


def chain(nodes: int, closed: bool = False) -> Surface:
    """A chain of straight edges through nodes 0, 1, ..."""
    ends = np.arange(nodes if closed else nodes - 1)
    return surface_from_edges(np.stack([ends, (ends + 1) % nodes], axis=1).astype(np.int32))


def contributions(surface: Surface, covered: Floats, seed: int = 1) -> tuple[Ints, Floats]:
    """Multipliers (p, 2) and positive T (p, 2, 2), diagonally dominant, of segments that are covered by a share."""
    draw = np.random.default_rng(seed)
    used = np.flatnonzero(covered > 0.0)
    T = draw.uniform(0.1, 0.3, (len(used), 2, 2)) + 0.7 * np.eye(2)
    return np.ascontiguousarray(surface.segments[used]), np.ascontiguousarray(covered[used, None, None] * T)


def coupled(surface: Surface, multiplier: Ints, T: Floats, full: float = 1.0, fixed: tuple[int, ...] = ()) -> Coupling:
    """The coupling that kernels make of these contributions."""
    held = np.zeros(len(surface.nodes), np.bool_)
    held[list(fixed)] = True
    found = Coupling(surface, 1, np.ones(len(surface.nodes), np.bool_), held)
    found.full[:] = full
    coupling.couple(len(multiplier), multiplier, T, found.table)
    return found


def dense_coupling(found: Coupling, multiplier: Ints, T: Floats) -> Floats:
    """T (k, k) with the rows and columns of merged multipliers added to their owners', the identity where none is."""
    k = len(found.owner)
    matrix = np.zeros((k, k))
    for p in range(len(multiplier)):
        for i, row in enumerate(found.owner[multiplier[p]]):
            for j, column in enumerate(found.owner[multiplier[p]]):
                if row >= 0 and column >= 0:
                    matrix[row, column] += T[p, i, j]
    gone = np.setdiff1d(np.arange(k), found.order)
    matrix[gone, gone] = 1.0
    return matrix


def dense_rows(rows: BandedRows, width: int) -> Floats:
    """Banded rows as a matrix (k, width)."""
    matrix = np.zeros((len(rows.start), width))
    for k, (start, end) in enumerate(zip(rows.start, rows.end, strict=True)):
        matrix[k, start:end] = rows.weight[k, : max(end - start, 0)]
    return matrix


SURFACE = chain(12)
COVER = np.array([0.0, 1.0, 1.0, 0.4, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.9])


def columns_of(seed: int = 1) -> tuple[BandedRows, Floats, Coupling, Floats]:
    """Columns of some M as kernels make them and dense (k, l), the coupling, and T dense."""
    multiplier, T = contributions(SURFACE, COVER, seed)
    found = coupled(SURFACE, multiplier, T)
    draw = np.random.default_rng(seed + 1)
    nodes = np.ascontiguousarray(multiplier + draw.integers(0, 2, (len(multiplier), 1)).astype(np.int32))
    values = draw.uniform(size=(len(multiplier), 2, 2))
    columns = BandedRows.allocate(12, 8)
    assert fill_columns(len(multiplier), multiplier, nodes, values, found.owner, columns) == 0
    dense = np.zeros((12, 14))
    for p in range(len(multiplier)):
        for j, k in enumerate(found.owner[multiplier[p]]):
            if k >= 0:
                np.add.at(dense[k], nodes[p], values[p, :, j])
    return columns, dense, found, dense_coupling(found, multiplier, T)


def central_differences(pair: Any, memory: Any, nodes: Floats, move: Floats, slots: Ints) -> Floats:
    """Change (k,) of the gaps in `slots` (k,) with a motion `move` (N, 2) of `nodes` (N, 2), to fourth order.

    Normals of ends that lean turn by 200 rad per unit of motion, which differences of second order follow to 1e-8.
    """
    gaps = []
    for step in (H, -H, 2.0 * H, -2.0 * H):
        pair.update(nodes + step * move, memory)
        gaps.append(pair.gaps[slots, 0].copy())
    return np.asarray((8.0 * (gaps[0] - gaps[1]) - (gaps[2] - gaps[3])) / (12.0 * H))
