"""The kernels of one class of contact algorithms: templates with its formulas in them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from contactlab.api import ContactView, Pieces
from contactlab.api.compiled.bound_arrays import BoundArrays, table_of
from contactlab.api.compiled.formulas import Slot, made
from contactlab.api.formulas import formulas_of, in_python
from contactlab.formulas import segment_kernels
from contactlab.formulas.parameters import numbers_of, parameters_of


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
        numbers = segment_kernels.parameters if numbers_of(self.kind) else segment_kernels.no_parameters
        own = {segment_kernels.PARAMETERS: numbers, segment_kernels.FIELDS: parameters_of(self.kind)}
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
