"""Contact at points from a formula: the array methods of `PointContact`."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from contactlab.api import ContactView, Floats, GapGradients, Ints, PieceDerivatives, Pieces, PointContact, Surface
from contactlab.api.compiled.bound_arrays import BoundCache
from contactlab.api.compiled.formulas import Slot
from contactlab.formulas import point_derivatives as changes
from contactlab.formulas import point_kernels as kernels
from contactlab.formulas import point_pieces as single
from contactlab.formulas.point_kernels import DerivedPoints, Points, TurnedPoints
from contactlab.formulas.segments import ClassKernels, arrays_of, averaged_normals, binder, gauss_rule

DEPTH = 1.0
"""Deepest push by a correction, in longest segment lengths of both sides: a deeper point is on the far side."""

_PIECES, _DERIVATIVES, _GRADIENTS, _NORMALS = (BoundCache() for _ in range(4))


class _Kernels(ClassKernels):
    """The kernels of one class."""

    @property
    def formula_slots(self) -> dict[Slot, Any]:
        places, weights = gauss_rule(max(1, self.kind.points))
        return {
            single.FOOT: self.called("foot", "x, master, p", {}),
            single.POINTS: self.kind.points, single.ALONE: self.kind.points_press,
            kernels.HOLD: kernels.hold_gauss_points if self.kind.points else kernels.hold_nodes,
            single.ABSCISSAE: places, single.WEIGHTS: weights,
        }  # fmt: skip


_of_class = cache(_Kernels)


def rivals(surface: Surface) -> Ints:
    """Return for each node (m,) of a side its number on the other flank, if a corner splits it, else its own."""
    found = np.arange(len(surface.nodes), dtype=np.int32)
    order = np.argsort(surface.nodes, kind="stable")
    one, other = order[:-1], order[1:]
    same = surface.nodes[one] == surface.nodes[other]
    found[one[same]], found[other[same]] = other[same], one[same]
    return found


def _points(view: ContactView, out: Pieces, part: PointContact) -> tuple[Any, ...]:
    """Return the arrays of a `Points`."""
    nodes, others = len(view.slave.nodes), len(view.master.nodes)
    own, other = ((np.empty((s, 2)), np.empty(s)) for s in (len(view.slave.segments), len(view.master.segments)))
    return (
        *arrays_of(view, out, part), view.memory, *own, *other, np.empty((nodes, 2)), np.empty(nodes),
        rivals(view.slave), np.empty(nodes, np.bool_), np.empty(nodes, np.int32), np.empty(others, np.int32),
        np.empty(others), np.empty(2),
    )  # fmt: skip


_POINTS, _DERIVED, _TURNED = (binder(table, _points) for table in (Points, DerivedPoints, TurnedPoints))


def pieces(part: PointContact, view: ContactView, out: Pieces) -> int:
    """Implement `ContactAlgorithm.pieces`."""
    made_of = _of_class(type(part))
    arrays = made_of.given_arrays(_PIECES.of(out, _POINTS, view, part), Points)
    count, turned = made_of.made(kernels.pieces)(arrays, view.reach, DEPTH)
    out.averaged = part.points > 0 and turned == 0
    return int(count)


def derivatives(part: PointContact, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
    """Implement `ContactAlgorithm.derivatives`."""
    made_of = _of_class(type(part))
    arrays = made_of.given_arrays(_DERIVATIVES.of(out, _DERIVED, view, part, pieces), DerivedPoints)
    out.count, out.normal_count = made_of.made(changes.piece_derivatives)(arrays, count)
    return True


def gradients(part: PointContact, view: ContactView, pieces: Pieces, count: int, out: GapGradients) -> bool:
    """Implement `ContactAlgorithm.gradients`: weights move the projection along the master, across the normal."""
    if part.points:
        return False
    bound = _GRADIENTS.of(out, _TURNED, view, part, pieces)
    out.count, out.normal_count = 0, changes.turns(bound.address, count)
    return True


def normals(part: PointContact, view: ContactView, pieces: Pieces, count: int, out: Floats) -> bool:
    """Implement `ContactAlgorithm.normals`; False if they need all pieces again."""
    if part.points_press:
        out[:] = pieces.normal
        a, b = (view.at.slave[view.slave.segments[pieces.segment[:count, 0] // part.points, k]] for k in range(2))
        along = b - a
        out[pieces.multiplier[:count, 0]] = np.stack([-along[:, 1], along[:, 0]], 1) / np.hypot(*along.T)[:, None]
        return True
    if part.points:
        return averaged_normals(view, pieces, count, out)
    out[:] = pieces.normal
    changes.normals(_NORMALS.of(pieces, _POINTS, view, part).address, count, out)
    return True
