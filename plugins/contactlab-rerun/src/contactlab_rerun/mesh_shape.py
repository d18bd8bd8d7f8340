"""The mesh as a viewer draws it: triangles, sides of cells, outlines."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from contactlab.api.arrays import Ints
from contactlab.api.frame import BodyLayout, Layout

_CORNERS = [(0, 1, 2), (0, 2, 3)]
_SERENDIPITY = [(0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)]
_MIDDLE = [(0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8), (2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)]
TRIANGLES = {4: _CORNERS, 8: _SERENDIPITY, 9: _MIDDLE}
"""Triangles of a cell by its number of nodes."""

_STRAIGHT: list[tuple[int, ...]] = [(0, 1), (1, 2), (2, 3), (3, 0)]
_CURVED: list[tuple[int, ...]] = [(0, 4, 1), (1, 5, 2), (2, 6, 3), (3, 7, 0)]
SIDES: dict[int, list[tuple[int, ...]]] = {4: _STRAIGHT, 8: _CURVED, 9: _CURVED}
"""Nodes along each side of a cell, by its number of nodes."""


class MeshShape:
    """All bodies of a layout; nodes are global."""

    def __init__(self, layout: Layout) -> None:
        self.nodes = len(layout.nodes)
        self.bodies = layout.bodies
        self.triangles = np.concatenate(
            [body.cells[:, TRIANGLES[body.cells.shape[1]]].reshape(-1, 3) for body in layout.bodies]
        ).astype(np.uint32)
        self._flat = np.concatenate([body.cells.ravel() for body in layout.bodies])
        first, owners = 0, []
        for body in layout.bodies:
            owners.append(np.repeat(np.arange(first, first + len(body.cells)), body.cells.shape[1]))
            first += len(body.cells)
        self._owner = np.concatenate(owners)
        # nodes that no cell has (of rigid surfaces, say) keep the lowest colour
        self._count = np.maximum(np.bincount(self._flat, minlength=self.nodes), 1)

    @property
    def cells(self) -> int:
        """Number of cells."""
        return sum(len(body.cells) for body in self.bodies)

    def nodal(self, values: np.ndarray) -> np.ndarray:
        """Means (N,) at nodes of values (n,) of the cells around each."""
        return np.bincount(self._flat, weights=values[self._owner], minlength=self.nodes) / self._count

    @cached_property
    def outlines(self) -> list[Ints]:
        """Node numbers along every closed boundary."""
        return [loop for body in self.bodies for loop in _loops(body)]

    @cached_property
    def wire(self) -> list[Ints]:
        """Lines of nodes that pass every side shared by two cells once."""
        return [line for body in self.bodies for line in _trails(_inner_sides(body).tolist())]


def _sides(body: BodyLayout) -> Ints:
    return body.cells[:, SIDES[body.cells.shape[1]]].reshape(-1, len(SIDES[body.cells.shape[1]][0]))


def _sorted_ends(sides: Ints) -> Ints:
    return np.sort(sides[:, [0, -1]], axis=1)


def _inner_sides(body: BodyLayout) -> Ints:
    """Each side that two cells share, once."""
    sides = _sides(body)
    _, first, counts = np.unique(_sorted_ends(sides), axis=0, return_index=True, return_counts=True)
    return sides[first[counts > 1]]


def _trails(sides: list[list[int]]) -> list[Ints]:
    """Lines through the sides, each passed once: a node that ends two sides is then written once for both."""
    at: dict[int, list[int]] = {}
    for place, ends in enumerate(sides):
        for end in (ends[0], ends[-1]):
            at.setdefault(end, []).append(place)
    # a line that begins where an odd number of sides end leaves fewer pieces behind
    starts = sorted(at, key=lambda node: len(at[node]) % 2 == 0)
    used, lines = [False] * len(sides), []
    for start in starts:
        while any(not used[number] for number in at[start]):
            line = [start]
            while (number := next((k for k in at[line[-1]] if not used[k]), None)) is not None:
                used[number] = True
                side = sides[number]
                line += side[1:] if side[0] == line[-1] else side[-2::-1]
            lines.append(np.array(line, np.int32))
    return lines


def _loops(body: BodyLayout) -> list[Ints]:
    """Closed boundaries as chains of node numbers."""
    sides = _sides(body)
    _, first, counts = np.unique(_sorted_ends(sides), axis=0, return_index=True, return_counts=True)
    starts = {int(side[0]): side for side in sides[first[counts == 1]]}
    loops = []
    while starts:
        at, side = starts.popitem()
        chain = list(side)
        while int(chain[-1]) in starts:
            chain.extend(starts.pop(int(chain[-1]))[1:])
        loops.append(np.array(chain, np.int32))
        del at
    return loops
