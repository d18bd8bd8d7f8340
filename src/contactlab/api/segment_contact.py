"""Contact between segments by two formulas: the overlap of two segments, and the functions that weight the gap."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Final, Literal

import numpy as np

from contactlab.api.arrays import Flags, Floats, Ints
from contactlab.api.compiled.late import late
from contactlab.api.contact import ContactAlgorithm, ContactView, Pieces
from contactlab.api.derivatives import GapGradients, PieceDerivatives
from contactlab.api.formulas import declare
from contactlab.api.segments import Covered, MasterSegment, Overlap, SlaveSegment
from contactlab.api.surface import Candidates, Surface
from contactlab.api.tensors import Number

_ARGUMENTS: Final[Mapping[str, tuple[str, ...]]] = {
    "overlap": ("slave", "master", "p"),
    "basis": ("xi", "covered", "p"),
}


@dataclass(frozen=True)
class SegmentContact(ContactAlgorithm):
    """Contact integrated over the overlaps of slave and master segments, by two formulas.

        overlap(slave, master)  overlap of a slave segment with a master segment: an `Overlap`
        basis(xi)               values at xi of the two multipliers at the ends of a slave segment, xi from 0 to 1

    The gap is weighted by the basis and integrated over the overlaps: D, M and T of `Pieces`. `basis` may also ask for
    `covered`, the overlap of the segment with all masters, and both for p, the numbers among the fields.
    The core handles search, flanks, quadratic edges, normals, all derivatives and integration, which is exact for a
    basis of polynomials that may jump and bend.

    A method of `ContactAlgorithm` in the body of a plugin component replaces the method made from formulas.
    If this is `pieces`, it fills `ends` and `segment` of `Pieces`, from which derivatives are made.

    multipliers  which nodes of quadratic slave edges carry them: "nodes" all, "vertices" the ends of edges;
                 "auto" is all without friction and the ends with it (mortar-operators.md, quadratic edges)
    """

    multipliers: Literal["auto", "nodes", "vertices"] = "auto"

    passes_patch_test: ClassVar[bool] = True
    merged_below: ClassVar[float] = 0.2
    gradient_nodes: ClassVar[int] = 12

    def __init_subclass__(cls, **named: Any) -> None:
        super().__init_subclass__(**named)
        declare(cls, _ARGUMENTS)

    @staticmethod
    @abstractmethod
    def overlap(slave: SlaveSegment, master: MasterSegment) -> Overlap:
        """Return the part of a slave segment that overlaps a master segment. A formula."""

    @staticmethod
    @abstractmethod
    def basis(xi: Number, covered: Covered) -> tuple[Number, Number]:
        """Return values at xi of the multipliers at both ends of a slave segment. A formula."""

    @cached_property
    def basis_shape(self) -> Any:
        """Break points of the basis, and its degree between them: `Shape` of `contactlab.formulas.basis`."""
        return late("contactlab.formulas.basis").shape_of(self)

    def with_friction(self) -> ContactAlgorithm:
        """Put multipliers at the ends of quadratic edges, unless specified otherwise."""
        return replace(self, multipliers="vertices") if self.multipliers == "auto" else self

    def carriers(self, slave: Surface) -> Flags:
        """Return all nodes, or the nodes at the ends of edges."""
        carries = np.ones(len(slave.nodes), np.bool_)
        if self.multipliers == "vertices":
            carries[slave.edges[:, 2:].ravel()] = False
        return carries

    def widths(self, slave: Surface, master: Surface) -> tuple[int, int, int]:
        """Return one slave edge, two multipliers, one master edge."""
        return slave.edges.shape[1], 2, master.edges.shape[1]

    def capacity(self, slave: Surface, near: Candidates) -> int:
        """Return one piece for each pair of near segments."""
        return len(near.master)

    def pieces(self, view: ContactView, out: Pieces) -> int:
        """Fill integrals of the basis over all overlaps; normals point from master to slave."""
        return int(late("contactlab.formulas.segments").pieces(self, view, out))

    def derivatives(self, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
        """Fill derivatives of the formulas, chained."""
        return bool(late("contactlab.formulas.segments").derivatives(self, view, pieces, count, out))

    def gradients(
        self, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats, out: GapGradients
    ) -> bool:
        """Fill derivatives of separations."""
        module = late("contactlab.formulas.segments")
        return bool(module.gradients(self, view, pieces, count, owner, separation, out))

    def feet(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> bool:
        """Fill the overlap ends."""
        out[:count] = pieces.ends[:count]
        return pieces.averaged

    def normals(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> None:
        """Fill averaged normals of the slave; integrate all pieces again if normals turn at ends and vertices."""
        if not late("contactlab.formulas.segments").averaged_normals(view, pieces, count, out):
            super().normals(view, pieces, count, out)
