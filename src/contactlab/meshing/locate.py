"""Location of points in a mesh: cell and reference coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contactlab.api import Element, Floats, Mesh

ROUNDS = ((1, 1.0 + 1e-6), (8, 1.25), (64, 1.25))
"""Nearest cells to try for points farther outside the previous cells than this, in reference coordinates."""

FARTHEST = 3.0  # reference coordinates: beyond it shape functions say nothing of a cell
ITERATIONS = 8  # of Newton's method: convex cells need three, quadratic sides a few more
EXACT = 1e-12

Cells = NDArray[np.int64]


def located(mesh: Mesh, element: Element, points: Floats) -> tuple[Cells, Floats]:
    """Cells (n,) and reference coordinates (n, 2) of `points` (n, 2).

    A point outside all cells, as between a curved side and its chords, gets the cell that it is least outside of, and
    coordinates beyond [-1, 1].
    """
    from scipy.spatial import cKDTree

    centres = mesh.nodes[mesh.cells].mean(axis=1)
    tree = cKDTree(centres)
    cells, places = np.zeros(len(points), np.int64), np.full((len(points), 2), np.inf)
    left = np.arange(len(points))
    for most, inside in ROUNDS:
        count = min(most, len(centres))
        near = np.atleast_2d(tree.query(points[left], k=[*range(1, count + 1)])[1])
        for column in near.T:
            found = _reference_coordinates(mesh.nodes[mesh.cells[column]], element, points[left])
            better = np.abs(found).max(axis=1) < np.abs(places[left]).max(axis=1)
            cells[left[better]], places[left[better]] = column[better], found[better]
        left = left[np.abs(places[left]).max(axis=1) > inside]
        if not len(left) or count == len(centres):
            break
    return cells, places


def _reference_coordinates(corners: Floats, element: Element, points: Floats) -> Floats:
    """Newton's method for all points together: `corners` (n, a, 2) are the nodes of each point's cell."""
    place = np.zeros_like(points)
    for _ in range(ITERATIONS):
        shape = element.shape(place)
        rest = points - np.einsum("na,nad->nd", shape.value, corners)
        jacobian = np.einsum("nak,nad->ndk", shape.gradient, corners)
        step = _solved(jacobian, rest)
        place = np.clip(place + step, -FARTHEST, FARTHEST)
        if float(np.abs(step).max(initial=0.0)) < EXACT:
            break
    return place


def _solved(matrix: Floats, right: Floats) -> Floats:
    """Solutions (n, 2) of 2 x 2 systems; none is moved by a singular one."""
    (a, b), (c, d) = (matrix[:, i].T for i in range(2))
    determinant = a * d - b * c
    inverse = np.divide(1.0, determinant, out=np.zeros_like(determinant), where=determinant != 0.0)
    x, y = right.T
    solution: Floats = np.stack([(d * x - b * y) * inverse, (a * y - c * x) * inverse], axis=1)
    return solution
