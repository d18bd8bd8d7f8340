"""Contact at points of the slave by one formula: the projection point on the master."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final

from contactlab.api.arrays import Floats, Ints
from contactlab.api.compiled.late import late
from contactlab.api.contact import ContactAlgorithm, ContactView, Pieces
from contactlab.api.derivatives import GapGradients, PieceDerivatives
from contactlab.api.formulas import declare
from contactlab.api.segments import MasterSegment, SlavePoint
from contactlab.api.surface import Candidates, Surface
from contactlab.api.tensors import Number

_ARGUMENTS: Final[Mapping[str, tuple[str, ...]]] = {"foot": ("x", "master", "p")}


@dataclass(frozen=True)
class PointContact(ContactAlgorithm):
    """Points of the slave that stay outside the master, by one formula.

        foot(x, master)  projection of the point x on a master segment: eta, 0 at its start and 1 at its end

    A formula may also ask for p, the numbers among the fields of the plugin component. Points come from `points`:

    - 0, the nodes: each has its own constraint, along the normal of the master at its projection. A node has half
      of its edges, or 1/6, 4/6 and 1/6 of a quadratic edge, so that multipliers are pressures. At a concave corner
      of the master both segments hold the node. Convex corners and ends of the master are points that stay outside the
      slave's segments.
    - n, Gauss points of each slave segment: they share the multipliers of its two nodes, linear between these, so there
      are no more constraints than nodes. Constraints act along the averaged normals of the slave. With `points_press`
      each has its own constraint, for pressure laws, along the normal of the slave's segment.

    The core handles search, the choice of the segment, vertices, quadratic edges (the formula is evaluated on the
    tangent until the projection is the point itself), corners and all derivatives. A method of `ContactAlgorithm` in
    the body of a plugin component replaces the method made from the formula.
    """

    passes_patch_test: ClassVar[bool] = False
    points: ClassVar[int] = 0
    rows_per_node: ClassVar[int] = 2
    memory_size: ClassVar[int] = 2
    gradient_nodes: ClassVar[int] = 1

    def __init_subclass__(cls, **named: Any) -> None:
        super().__init_subclass__(**named)
        declare(cls, _ARGUMENTS)
        if "points" in vars(cls):
            own = cls.points if cls.points_press else 1
            counts = (own, cls.points, 0) if cls.points else (2, 2, 1)
            cls.rows_per_node, cls.memory_size, cls.gradient_nodes = counts

    @staticmethod
    @abstractmethod
    def foot(x: SlavePoint, master: MasterSegment) -> Number:
        """Return the projection of a slave point on a master segment, 0 at its start and 1 at its end. A formula."""

    def widths(self, slave: Surface, master: Surface) -> tuple[int, int, int]:
        """Return two nodes, as a corner presses on a segment, and one multiplier; or an edge and two; a master edge."""
        own = (slave.edges.shape[1], 1 if self.points_press else 2) if self.points else (2, 1)
        return *own, master.edges.shape[1]

    def capacity(self, slave: Surface, near: Candidates) -> int:
        """Return two constraints per node, or one piece for each Gauss point."""
        return self.points * len(slave.segments) if self.points else 2 * len(slave.nodes)

    def pieces(self, view: ContactView, out: Pieces) -> int:
        """Fill one piece for each point in contact. `memory` keeps the number of its segment, plus one."""
        return int(late("contactlab.formulas.points").pieces(self, view, out))

    def derivatives(self, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
        """Return derivatives of the formula, chained."""
        return bool(late("contactlab.formulas.points").derivatives(self, view, pieces, count, out))

    def gradients(
        self, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats, out: GapGradients
    ) -> bool:
        """Fill only turning normals, for constraints of nodes: other changes move projections across them."""
        return bool(late("contactlab.formulas.points").gradients(self, view, pieces, count, out))

    def normals(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> None:
        """Fill normals of the same segments and vertices, or the averaged normals of the slave."""
        if not late("contactlab.formulas.points").normals(self, view, pieces, count, out):
            super().normals(view, pieces, count, out)
