"""Formulas: small functions of numbers that an author writes once.

A formula takes and returns numbers, tuples of numbers, and the vectors, tensors and named tuples that the core hands to
it; it knows no arrays. In the body of a plugin component it makes the array method of its name: the core compiles it
for numbers and dual numbers, which differentiate it, and loops over points or segments. With `CONTACTLAB_PYTHON=1` in
the environment it runs as plain Python, under a debugger if need be.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property, update_wrapper, wraps
from typing import Any

from contactlab.api.compiled.late import late

__all__ = ["Formula", "array_method", "declare", "formula", "formulas_of", "in_python", "install", "members_of"]


class Formula:
    """A function of numbers; see `formula`."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function: Any = function
        update_wrapper(self, function)
        if next(iter(self.arguments), "") == "self":
            raise TypeError(f"{function.__qualname__}: a formula takes no self; its parameters are fields of p")

    def __call__(self, *arguments: Any) -> Any:
        """Evaluate in plain Python, on floats or dual numbers."""
        return self.plain(*arguments)

    @cached_property
    def plain(self) -> Any:
        """The function with functions of numbers that replace `math` and NumPy functions, which take floats alone."""
        from contactlab.api.compiled.formulas import plain

        return plain(self.function)

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        """Names of its arguments, which the core supplies."""
        return tuple(inspect.signature(self.function).parameters)

    @property
    def place(self) -> str:
        """File and line."""
        code = self.function.__code__
        return f"{code.co_filename}:{code.co_firstlineno}"

    @property
    def _numba_type_(self) -> Any:
        """Return its numba type; numba calls this if a kernel calls the formula."""
        from contactlab.api.compiled.formulas import compiled_point

        return compiled_point(self.function)._numba_type_

    def __reduce__(self) -> str:
        return str(self.function.__qualname__)


def formula(function: Callable[..., Any]) -> Any:
    """Declare a formula, in the body of a plugin component or next to it as a helper for other formulas.

    It may use + - * / ** and comparisons, `min`, `max`, `abs`, the functions of `math`, `if`, loops, tuples, other
    formulas and plain functions of the same kind. Argument names state the inputs that it needs.
    At a kink, as of `min` or an `if`, the derivative is one-sided, on the side of the values.
    """
    return Formula(function)


def formulas_of(kind: type) -> dict[str, Formula]:
    """Return the formulas of a plugin component by name, with its base classes."""
    found: dict[str, Formula] = {}
    for base in reversed(kind.__mro__):
        found.update(vars(base).get("__formulas__", {}))
    return found


def install(kind: type, root: type, allowed: Mapping[str, Iterable[str]], methods: str) -> None:
    """Replace the formulas `allowed` in the body of a plugin component by array methods, and note all formulas.

    Formulas of other names serve these: an argument with such a name is this formula. A method `NAME_by_hand` of the
    plugin component is a faster array method of the formula NAME; derivatives still come from the formula.

    allowed  names of formulas, each with the names of its other permitted arguments
    methods  module that has a function of each name, called with the part and the arguments of the method
    root     the abstract class: methods that the author writes are not replaced
    """
    own = {name for name, value in vars(kind).items() if isinstance(value, Formula)}
    helps = (own | set(formulas_of(kind))) - allowed.keys()
    declare(kind, {name: (*arguments, *helps) for name, arguments in allowed.items()})
    for name in own & allowed.keys():
        by_hand = getattr(kind, f"{name}_by_hand", None)
        setattr(kind, name, by_hand or array_method(getattr(root, name), methods, name))


def declare(kind: type, allowed: Mapping[str, Iterable[str]]) -> None:
    """Note the formulas in a plugin component's body; TypeError if arguments are not `allowed` for its name."""
    found = {name: value for name, value in vars(kind).items() if isinstance(value, Formula)}
    for name in found.keys() & allowed.keys():
        for argument in found[name].arguments:
            if argument not in allowed[name]:
                raise TypeError(
                    f"{kind.__name__}.{name}: got the argument {argument}, allowed: "
                    f"{', '.join(sorted(allowed[name]))} ({found[name].place})"
                )
    kind.__formulas__ = found  # type: ignore[attr-defined]


def array_method(like: Callable[..., Any], module: str, name: str) -> Callable[..., Any]:
    """Return a method of a plugin component that calls `name` of a module, imported at the first call."""

    function: Any = None

    def method(self: Any, *arguments: Any, **named: Any) -> Any:
        nonlocal function
        if function is None:
            function = getattr(late(module), name)
        return function(self, *arguments, **named)

    return wraps(like, assigned=("__name__", "__doc__", "__annotations__"), updated=())(method)


def in_python() -> bool:
    """Return whether formulas are to run as plain Python."""
    return os.environ.get("CONTACTLAB_PYTHON", "") not in ("", "0")


def members_of(kind: type[Any]) -> str:
    """Return the fields and methods of a named tuple that formulas see, as they are written."""
    methods = [name for name, value in vars(kind).items() if inspect.isfunction(value) and not name.startswith("_")]
    return ", ".join([*kind._fields, *(f"{name}()" for name in methods)])
