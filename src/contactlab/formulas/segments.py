"""Contact between segments from formulas: the array methods of `SegmentContact`, and kernels with formulas in them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cache, cached_property
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
from contactlab.api.compiled.bound_arrays import BoundArrays, BoundCache, table_of
from contactlab.api.compiled.formulas import Slot, made
from contactlab.api.formulas import formulas_of, in_python
from contactlab.api.segments import Covered
from contactlab.formulas import segment_derivatives as changes
from contactlab.formulas import segment_kernels as kernels
from contactlab.formulas.basis import Shape
from contactlab.formulas.parameters import numbers_of, parameters_of, values_of
from contactlab.formulas.segment_kernels import Derived, Separated
from contactlab.formulas.segment_normals import Both, inward_normals, turned_normals

DEPTH = 2.0
"""Longest segment lengths of the slave: deeper overlaps are the far side of a thin body, not contact."""

_PIECES, _DERIVATIVES, _GRADIENTS, _NORMALS, _MOMENTS = (BoundCache() for _ in range(5))


class ClassKernels(ABC):
    """Makes kernels of templates on demand, compiled, or in plain Python if requested at that time."""

    def __init__(self, kind: Any) -> None:
        self.kind, self.formulas, self.in_python = kind, formulas_of(kind), in_python()
        self._made: dict[Any, Any] = {}

    def given_arrays(self, bound: BoundArrays, table: type) -> Any:
        """Return bound arrays for kernels: their address, or in plain Python the table that they fill."""
        return table_of(table, iter(bound.arrays)) if self.in_python else bound.address

    def called(self, name: str, arguments: str, named: Mapping[str, Any], **given: str) -> Any:
        """Return a formula, called with the templates' `arguments`, or expressions of them and of `named`."""
        words = ", ".join(given.get(word, word) for word in self.formulas[name].arguments)
        names: dict[str, Any] = {**named, "formula": self.formulas[name].function, "__name__": self.kind.__module__}
        exec(f"def {name}({arguments}):\n    return formula({words})", names)
        return names[name]

    @property
    @abstractmethod
    def formula_slots(self) -> Mapping[Slot, Any]:
        """Values of the template slots in addition to numbers among the fields."""

    @cached_property
    def given(self) -> dict[Slot, Any]:
        """Values of all template slots."""
        numbers = kernels.parameters if numbers_of(self.kind) else kernels.no_parameters
        own = {kernels.PARAMETERS: numbers, kernels.FIELDS: parameters_of(self.kind)}
        return {**self.formula_slots, **own}

    def made(self, template: Any) -> Any:
        """Return the kernel of a template."""
        found = self._made.get(template)
        if found is None:
            found = made(template, f"{self.kind.__module__}.{self.kind.__qualname__}", self.given, self.in_python)
            self._made[template] = found
        return found


def binder(table: type, arrays_of: Callable[..., tuple[Any, ...]]) -> Callable[..., BoundArrays]:
    """Return a function that binds a table: `arrays_of` a view, pieces and an algorithm; for derivatives more."""

    def bind(owner: Any, view: ContactView, part: Any, pieces: Pieces | None = None, *more: Any) -> BoundArrays:
        if pieces is None:
            return BoundArrays(table, *arrays_of(view, owner, part))
        return BoundArrays(table, *arrays_of(view, pieces, part), *more, owner)

    return bind


def gauss_rule(points: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return points and weights of the Gauss rule from 0 to 1."""
    places, weights = np.polynomial.legendre.leggauss(points)
    return tuple((0.5 + 0.5 * places).tolist()), tuple((0.5 * weights).tolist())


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
    return int(count)


def derivatives(part: SegmentContact, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
    """Implement `ContactAlgorithm.derivatives`."""
    made_of = _kernels(part)
    arrays = made_of.given_arrays(_DERIVATIVES.of(out, _DERIVED, view, part, pieces), Derived)
    out.count, out.normal_count = made_of.made(changes.piece_derivatives)(arrays, count, _vertices(part))
    return True


def gradients(
    part: SegmentContact, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats,
    out: GapGradients,
) -> bool:  # fmt: skip
    """Implement `ContactAlgorithm.gradients`."""
    if not pieces.averaged:
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


def _vertices(part: SegmentContact) -> bool:
    return part.multipliers == "vertices"
