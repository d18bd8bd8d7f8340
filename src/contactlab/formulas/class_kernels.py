"""The kernels of one class of contact algorithms: templates with its formulas in them, and the tables that they read.

A table has a view of a contact and its pieces, by the names of the contract. Slots: PARAMETERS, the parameters p of an
algorithm from the numbers among its FIELDS.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from contactlab.api import ContactView, GapGradients, PieceDerivatives, Pieces, Surface
from contactlab.api.compiled.bound_arrays import BoundArrays, Floats2, Ints1, table_of
from contactlab.api.compiled.formulas import Slot, made, slots
from contactlab.api.compiled.kernel import point
from contactlab.api.compiled.records import column
from contactlab.api.formulas import formulas_of, in_python
from contactlab.formulas.parameters import numbers_of, parameters_of

PARAMETERS, FIELDS = slots("PARAMETERS", "FIELDS")


class At(NamedTuple):
    """Positions of the nodes of both sides [mm]."""

    slave: Floats2
    master: Floats2


class Near(NamedTuple):
    """Master segments near slave segment s: master[start[s]:start[s + 1]]."""

    start: Ints1
    master: Ints1


class View(NamedTuple):
    """A `ContactView`."""

    slave: Surface
    master: Surface
    at: At
    near: Near


class Both(NamedTuple):
    """A view, its pieces, and the numbers (n, 1) among the fields of the algorithm."""

    sides: View
    out: Pieces
    numbers: Floats2


class Derived(NamedTuple):
    """`Both` with the derivatives."""

    both: Both
    changes: PieceDerivatives


class Separated(NamedTuple):
    """`Both` with the owner and the separation of each multiplier, and the gradients."""

    both: Both
    owner: Ints1
    separation: Floats2
    gradients: GapGradients


@point
def no_parameters(numbers: Any) -> Any:
    """Return the parameters of an algorithm that has none."""
    return 0.0


@point
def parameters(numbers: Any) -> Any:
    """Return the parameters of an algorithm that has some."""
    return column(numbers, 0, FIELDS)  # type: ignore[call-arg]


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
        numbers = parameters if numbers_of(self.kind) else no_parameters
        own = {PARAMETERS: numbers, FIELDS: parameters_of(self.kind)}
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
