"""The kernels of one class of contact algorithms: templates with its formulas in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contactlab.api.compiled.bound_arrays import BoundArrays, table_of
from contactlab.api.compiled.formulas import Slot, made
from contactlab.api.formulas import formulas_of, in_python


class ClassKernels:
    """Makes kernels of templates, compiled, or in plain Python if that is asked for when it is made itself."""

    def __init__(self, kind: Any) -> None:
        self.kind, self.formulas, self.in_python = kind, formulas_of(kind), in_python()

    def given_arrays(self, bound: BoundArrays, table: type) -> Any:
        """How the kernels are given bound arrays: by their address, or in plain Python as the table that they fill."""
        return table_of(table, iter(bound.arrays)) if self.in_python else bound.address

    def called(self, name: str, arguments: str, named: Mapping[str, Any], **given: str) -> Any:
        """A formula, called with what the templates have: `arguments`, or expressions of them and of `named`."""
        words = ", ".join(given.get(word, word) for word in self.formulas[name].arguments)
        names: dict[str, Any] = {**named, "formula": self.formulas[name].function, "__name__": self.kind.__module__}
        exec(f"def {name}({arguments}):\n    return formula({words})", names)
        return names[name]

    def made(self, template: Any, given: Mapping[Slot, Any]) -> Any:
        """The kernel of a template with `given` in its slots."""
        return made(template, f"{self.kind.__module__}.{self.kind.__qualname__}", given, self.in_python)
