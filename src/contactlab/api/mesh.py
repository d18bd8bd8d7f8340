"""Meshes: nodes, cells and named edge sets of one body."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

from contactlab.api.arrays import Floats, Ints
from contactlab.api.element import Element


@dataclass(frozen=True)
class Mesh:
    """Mesh of a body.

    nodes  (N, 2) [mm]
    cells  (n, a) int32, counter-clockwise, in the node order of the element
    edges  edge sets by name, each (e, b) int32: start, end, then inner nodes; the body lies on the left
    """

    nodes: Floats
    cells: Ints
    edges: Mapping[str, Ints]


class MeshSource(ABC):
    """Gives a body's mesh. Subclasses are frozen dataclasses; their fields are the TOML keys."""

    @abstractmethod
    def mesh(self, element: Element, level: int) -> Mesh:
        """Return the mesh for `element`, all cell counts multiplied by `level` >= 1."""
