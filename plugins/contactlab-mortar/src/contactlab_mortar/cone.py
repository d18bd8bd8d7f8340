"""The cone of admissible multipliers: means of the pressure, or the multiplier of each node, are never negative."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from contactlab.api import ContactView, Floats, GapGradients, Ints, PieceDerivatives, Pieces, SegmentContact


@dataclass(frozen=True)
class Coned(SegmentContact):
    """A choice for multipliers that are not biorthogonal to the hats: which mean of the pressure is never negative.

    cone  "weak" the one over each hat, "strong" the multiplier of each node itself (rows.md, the strong cone)
    """

    cone: Literal["weak", "strong"] = "weak"

    def pieces(self, view: ContactView, out: Pieces) -> int:
        """The integrals; with the strong cone hats are lumped in T, so that each multiplier has a gap of its own."""
        count = super().pieces(view, out)
        if self.cone == "strong":
            _lump(out.T[:count])
        return count

    def derivatives(self, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
        """Differentiate the formulas, and lump the derivatives of T."""
        super().derivatives(view, pieces, count, out)
        if self.cone == "strong":
            _lump(out.dT[: out.count])
        return True

    def gradients(
        self, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats, out: GapGradients
    ) -> bool:
        """Fill in the gradients of the formulas; with lumped hats the core takes them from `derivatives`."""
        return self.cone == "weak" and super().gradients(view, pieces, count, owner, separation, out)

    def feet(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> bool:
        """Ends of the overlaps, for closed forms, which know no lumped hats."""
        return self.cone == "weak" and super().feet(view, pieces, count, out)


def _lump(T: Floats) -> None:
    """Columns of T (z, 2, 2), or of its derivatives, become their sums on the diagonal."""
    sums = T.sum(axis=1)
    T[:] = 0.0
    T[:, (0, 1), (0, 1)] = sums
