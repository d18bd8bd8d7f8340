"""Meshes in another numbering, which must not matter to anybody."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contactlab.api import Element, Mesh, MeshSource
from contactlab.errors import Where
from contactlab.parts.registry import Registry


@dataclass(frozen=True)
class Renumbered(MeshSource):
    """The mesh of another source with nodes, cells and edges in random order, the same in every call."""

    source: MeshSource

    def mesh(self, element: Element, level: int) -> Mesh:
        """As the source's, renumbered."""
        random, plain = np.random.default_rng(5), self.source.mesh(element, level)
        to = random.permutation(len(plain.nodes)).astype(np.int32)
        nodes = np.empty_like(plain.nodes)
        nodes[to] = plain.nodes
        cells = np.ascontiguousarray(to[plain.cells][random.permutation(len(plain.cells))])
        edges = {name: to[some][random.permutation(len(some))] for name, some in plain.edges.items()}
        return replace(plain, nodes=nodes, cells=cells, edges=edges)


class Renumbering(Registry):
    """A registry whose meshes come renumbered."""

    def __init__(self, of: Registry) -> None:
        vars(self).update(vars(of))

    def make(self, kind: str, spec: Any, where: Where = "") -> Any:
        """As the other registry's, meshes renumbered."""
        made = super().make(kind, spec, where)
        return Renumbered(made) if kind == "mesh" else made
