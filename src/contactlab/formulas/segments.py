"""Contact between segments from formulas: the array methods of `SegmentContact`."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from contactlab.api import (
    ContactAlgorithm,
    ContactView,
    Floats,
    GapGradients,
    Ints,
    PieceDerivatives,
    Pieces,
    SegmentContact,
)
from contactlab.api.compiled.bound_arrays import BoundCache
from contactlab.api.compiled.formulas import Slot
from contactlab.api.segments import Covered
from contactlab.formulas import segment_derivatives as changes
from contactlab.formulas import segment_kernels as kernels
from contactlab.formulas.basis import Shape
from contactlab.formulas.class_kernels import Both, ClassKernels, Derived, Separated, binder, gauss_rule
from contactlab.formulas.parameters import values_of
from contactlab.formulas.segment_normals import inward_normals, turned_normals

DEPTH = 2.0
"""Longest segment lengths of the slave: deeper overlaps are the far side of a thin body, not contact."""

_PIECES, _DERIVATIVES, _GRADIENTS, _NORMALS, _MOMENTS = (BoundCache() for _ in range(5))


class _Kernels(ClassKernels):
    """The kernels of one class whose basis has one shape."""

    def __init__(self, kind: Any, basis: Shape) -> None:
        super().__init__(kind)
        self.basis = basis

    @property
    def formula_slots(self) -> dict[Slot, Any]:
        breaks, degree = self.basis
        found: dict[Slot, Any] = {
            kernels.OVERLAP: self.called("overlap", "slave, master, p", {}),
            kernels.BASIS: self.called(
                "basis", "u, low, high, p", {"Covered": Covered}, xi="u", covered="Covered(low, high)"
            ),
            kernels.COVERED: "covered" in self.formulas["basis"].arguments,
            kernels.PARTS: len(breaks) + 1, kernels.BREAKS: breaks or (0.5,),
        }  # fmt: skip
        names = (
            (kernels.POINTS, kernels.WEIGHTS), (kernels.QUADRATIC_POINTS, kernels.QUADRATIC_WEIGHTS),
            (kernels.CUBIC_POINTS, kernels.CUBIC_WEIGHTS),
        )  # fmt: skip
        for (points, weights), trace in zip(names, (1, 2, 3), strict=True):
            found[points], found[weights] = gauss_rule((degree + trace) // 2 + 1)
        return found


_of_class = cache(_Kernels)


def _kernels(part: SegmentContact) -> _Kernels:
    return _of_class(type(part), part.basis_shape)


def arrays_of(view: ContactView, out: Pieces, part: ContactAlgorithm | None) -> tuple[Any, ...]:
    """Return the arrays of a `Both`."""
    numbers = np.zeros((0, 1)) if part is None else values_of(part)
    return view.slave, view.master, *view.at, view.near.start, view.near.master, out, numbers


_BOTH, _DERIVED, _SEPARATED = (binder(table, arrays_of) for table in (Both, Derived, Separated))


def pieces(part: SegmentContact, view: ContactView, out: Pieces) -> int:
    """Implement `ContactAlgorithm.pieces`."""
    made_of = _kernels(part)
    arrays = made_of.given_arrays(_PIECES.of(out, _BOTH, view, part), Both)
    count, turned = made_of.made(kernels.pieces)(arrays, view.reach, DEPTH, _vertices(part))
    out.averaged = turned == 0
    if part.lumped:
        _lump(out.T[:count])
    return int(count)


def derivatives(part: SegmentContact, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
    """Implement `ContactAlgorithm.derivatives`."""
    made_of = _kernels(part)
    arrays = made_of.given_arrays(_DERIVATIVES.of(out, _DERIVED, view, part, pieces), Derived)
    out.count, out.normal_count = made_of.made(changes.piece_derivatives)(arrays, count, _vertices(part))
    if part.lumped:
        _lump(out.dT[: out.count])
    return True


def gradients(
    part: SegmentContact, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats,
    out: GapGradients,
) -> bool:  # fmt: skip
    """Implement `ContactAlgorithm.gradients`; with lumped hats the core takes them from `derivatives`."""
    if part.lumped or not pieces.averaged:
        return False
    made_of = _kernels(part)
    bound = _GRADIENTS.of(out, _SEPARATED, view, part, pieces, owner, separation)
    arrays = made_of.given_arrays(bound, Separated)
    out.count, out.normal_count = count, made_of.made(changes.separation_gradients)(arrays, count, _vertices(part))
    return True


def moments(part: SegmentContact, view: ContactView, pieces: Pieces, count: int, out: Floats) -> None:
    """Compute moments (p, 4, 2) of smooth surfaces, see `contactlab.kernels.contact.smooth`."""
    from contactlab.formulas.segment_smooth import moments

    made_of = _kernels(part)
    arrays = made_of.given_arrays(_MOMENTS.of(pieces, _BOTH, view, part), Both)
    made_of.made(moments)(arrays, count, out)


def moment_derivatives(
    part: SegmentContact, view: ContactView, pieces: Pieces, count: int, owner: Ints, bends: tuple[Floats, ...],
    nodes: Ints, out: tuple[Ints, Ints, Floats],
) -> int:  # fmt: skip
    """Compute entries (row, column, value) of separations by the moments. Return their number."""
    from contactlab.formulas.segment_smooth import moment_derivatives

    made_of = _kernels(part)
    arrays = made_of.given_arrays(_MOMENTS.of(pieces, _BOTH, view, part), Both)
    return int(made_of.made(moment_derivatives)(arrays, count, owner, bends, nodes, out))


def averaged_normals(view: ContactView, pieces: Pieces, count: int, out: Floats) -> bool:
    """Fill the averaged normals, if they are the directions at ends and vertices, too; else return False."""
    inward_normals(view.at.slave, view.slave.segments, out)
    return not turned_normals(_NORMALS.of(pieces, _BOTH, view, None).address, count, out)


def _lump(T: Floats) -> None:
    """Columns of T (z, 2, 2), or of its derivatives, become their sums on the diagonal."""
    sums = T.sum(axis=1)
    T[:] = 0.0
    T[:, (0, 1), (0, 1)] = sums


def _vertices(part: SegmentContact) -> bool:
    return part.multipliers == "vertices"
