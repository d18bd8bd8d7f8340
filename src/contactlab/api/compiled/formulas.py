"""Kernels made of a template and an author's formulas. Imports numba when it is imported.

A template is a module of kernels in which some global names are `Slot`s. `made` copies a kernel and all that it calls,
with formulas replacing the slots: the code objects stay the same, so a debugger, a traceback and a measurement of
coverage show the template's and the author's own lines. Machine code is cached on disk under a name that contains a
hash of the formulas and of all functions that they call.
"""

from __future__ import annotations

import builtins
import dis
import hashlib
import linecache
import math
import re
from collections.abc import Callable, Hashable, Iterator, Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numba.core.errors import NumbaError

from contactlab.api import mathematics, segments, tensors
from contactlab.api.compiled import dual, kernel, records
from contactlab.api.compiled import mathematics as compiled_mathematics
from contactlab.api.compiled.compiler import Kernel, Part
from contactlab.api.compiled.unpack import unpack
from contactlab.api.formulas import Formula, in_python, members_of
from contactlab.errors import WrongAnswer

__all__ = ["FormulaError", "Slot", "compiled_point", "copied", "made", "methods_of", "plain", "slots"]

methods_of = compiled_mathematics.methods_of
_KERNEL, _PART = Kernel, Part
_FUNCTIONS = {
    getattr(module, name): getattr(mathematics, name)
    for module in (math, np)
    for name in mathematics.__all__
    if callable(getattr(module, name, None)) and callable(getattr(mathematics, name))
}


class FormulaError(WrongAnswer):
    """A formula uses something unknown to kernels: file and line, what it is, and what to do."""


class Slot:
    """A name in a template that an author's value replaces."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __call__(self, *arguments: Any) -> Any:
        """Raise TypeError: the value of the slot is still unknown."""
        raise TypeError(f"{self.name}: a template is called")


def slots(*names: str) -> tuple[Any, ...]:
    """Return slots of these names, which kernels use like their later values: functions, numbers, tuples."""
    return tuple(map(Slot, names))


def made(template: Any, name: str, given: Mapping[Slot, Any], plain: bool | None = None) -> Any:
    """Return the kernel of a template with `given` in its slots, compiled under `name`, or `plain` Python."""
    if in_python() if plain is None else plain:
        return copied(template, given)
    return _Copies(given, compiled=True).kernel(template, name)


def copied(template: Any, given: Mapping[Slot, Any]) -> Any:
    """Return the function of a template with `given` in its slots, in plain Python."""
    return _Copies(given, compiled=False).of(template)


def plain(function: Callable[..., Any]) -> Any:
    """Return a formula as plain Python, for floats and for the dual numbers of `contactlab.api.mathematics`."""
    return _Copies({}, compiled=False).of(function)


@cache
def compiled_point(function: Callable[..., Any]) -> Any:
    """Return a formula, or a function that it calls, for kernels; always the same object."""
    return kernel.point(_Copies({}, compiled=True).copied(function))


class _Copies:
    """Copies of functions whose globals have other values: made once for each function."""

    def __init__(self, given: Mapping[Slot, Any], compiled: bool) -> None:
        self.given, self.compiled = given, compiled
        self.known: dict[Any, Any] = {}

    def kernel(self, template: Any, name: str) -> Any:
        """Return the compiled kernel of a template."""
        function = self.copied(template.py_func)
        function.__qualname__ = f"{name}.{template.py_func.__name__}.{_hash(function)}"
        return kernel.formula_kernel(FormulaKernel, function)

    def of(self, held: Any) -> Any:
        """Return the replacement for the value of a global name."""
        if not isinstance(held, FunctionType | _KERNEL | _PART | Formula):
            return self._of(held)
        if held not in self.known:
            self.known[held] = self._of(held)
        return self.known[held]

    def _of(self, held: Any) -> Any:
        if isinstance(held, Slot):
            return self.of(self.given[held])
        if isinstance(held, ModuleType):
            return mathematics if held in (math, np) else held
        if isinstance(held, np.ufunc | BuiltinFunctionType):
            return _FUNCTIONS.get(held, held)
        if isinstance(held, Formula | FunctionType):
            function: Any = held.function if isinstance(held, Formula) else held
            if function.__module__ == mathematics.__name__:
                return function
            _refuse(function)
            return compiled_point(function) if self.compiled else self.copied(function)
        if not self.compiled and isinstance(held, Hashable) and held in _PYTHON:
            return _PYTHON[held]
        if isinstance(held, _KERNEL | _PART):
            return self._dispatcher(held)
        return held

    def _dispatcher(self, held: Any) -> Any:
        if not self.compiled:
            return (
                held if isinstance(held, _KERNEL) and not self._has_slots(held.py_func) else self.copied(held.py_func)
            )
        if not self._has_slots(held.py_func):
            return held
        return kernel.point(self.copied(held.py_func))

    def _has_slots(self, function: Any, seen: set[Any] | None = None) -> bool:
        seen = set() if seen is None else seen
        if function in seen:
            return False
        seen.add(function)
        for _, held in _globals_of(function):
            if isinstance(held, Slot):
                return True
            inner = getattr(held, "py_func", None)
            if inner is not None and self._has_slots(inner, seen):
                return True
        return False

    def copied(self, function: Any) -> Any:
        """Return a function of the same code with other globals; core functions keep the arrays of NumPy."""
        of_core = function.__module__.startswith("contactlab.")
        names: dict[str, Any] = {"__builtins__": builtins, "__name__": function.__module__}
        cells = tuple(CellType(self.of(cell.cell_contents)) for cell in function.__closure__ or ())
        copy = FunctionType(function.__code__, names, function.__name__, function.__defaults__, cells)
        copy.__module__, copy.__qualname__ = function.__module__, function.__qualname__
        copy.__kwdefaults__ = function.__kwdefaults__
        self.known[function] = copy
        for name, held in _globals_of(function):
            names[name] = held if of_core and isinstance(held, ModuleType) else self.of(held)
        return copy


def _globals_of(function: Any) -> Iterator[tuple[str, Any]]:
    """Yield global names that a function uses and that are no builtins, with their values."""
    for name in sorted(_names(function.__code__)):
        if name in function.__globals__:
            yield name, function.__globals__[name]


def _names(code: CodeType) -> set[str]:
    found = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            found |= _names(constant)
    return found


def _hash(function: Any) -> str:
    """Return a hash of the code of a function and of all that it calls, and of the constants that they use."""
    digest, seen, waiting = hashlib.sha256(), set(), [function]
    while waiting:
        held = waiting.pop()
        if held in seen:
            continue
        seen.add(held)
        _add_code(digest, held.__code__)
        for name, found in _globals_of(held):
            modules = [found] if isinstance(found, ModuleType) and found is not mathematics else []
            names = sorted(_names(held.__code__))  # a set has another order in each process
            for one in [getattr(module, name, None) for module in modules for name in names] or [found]:
                inner = getattr(one, "py_func", getattr(one, "function", one))
                if isinstance(inner, FunctionType) and inner.__module__ != mathematics.__name__:
                    waiting.append(inner)
                known = getattr(one, "_fields", ()) if isinstance(one, type) else one
                if isinstance(known, float | int | str | tuple):
                    digest.update(f"{name}={known!r}".encode())
    return digest.hexdigest()[:12]


def _add_code(digest: Any, code: CodeType) -> None:
    digest.update(code.co_code)
    digest.update(repr((code.co_names, code.co_varnames)).encode())
    for constant in code.co_consts[1:]:  # the first is the docstring
        if isinstance(constant, CodeType):
            _add_code(digest, constant)
        else:
            digest.update(repr(constant).encode())


class FormulaKernel(Kernel):
    """A kernel of a template: compilation errors are reported in terms of the formula."""

    def compile(self, sig: Any) -> Any:
        """Compile at the first call with arguments of new types."""
        try:
            return super().compile(sig)
        except NumbaError as error:
            raise FormulaError(_told(error)) from None


_REFUSED = {
    "BUILD_LIST": "a list", "BUILD_SET": "a set", "BUILD_MAP": "a dict", "BUILD_CONST_KEY_MAP": "a dict",
    "LIST_APPEND": "a comprehension", "MAKE_FUNCTION": "a function within it", "IMPORT_NAME": "an import",
    "STORE_SUBSCR": "an entry that is written", "STORE_ATTR": "an attribute that is written",
    "STORE_GLOBAL": "a global name that is written", "YIELD_VALUE": "a generator", "LOAD_BUILD_CLASS": "a class",
    "FORMAT_VALUE": "a string",
}  # fmt: skip


def _refuse(function: Any) -> None:
    """Raise FormulaError for code that is no formula, whether kernels could compile it or not."""
    code = function.__code__
    instructions = list(dis.get_instructions(code))
    starred = any(instruction.opname == "LIST_TO_TUPLE" for instruction in instructions)  # (*a, b) begins as a list
    for before, now in pairwise([None, *instructions]):
        assert now is not None
        name = str(now.argval)
        found = None if starred and now.opname in ("BUILD_LIST", "LIST_APPEND") else _REFUSED.get(now.opname)
        if before is not None and before.opname == "LOAD_GLOBAL" and now.opname in ("LOAD_ATTR", "LOAD_METHOD"):
            module = function.__globals__.get(before.argval)
            if module in (math, np) and name not in vars(mathematics):
                found = f"{module.__name__}.{name}"
        if found is not None:
            line = now.positions.lineno if now.positions is not None else None
            raise FormulaError(_refusal(code.co_filename, line or code.co_firstlineno, found))


def _refusal(file: str, line: int, got: str) -> str:
    text = linecache.getline(file, line).strip()
    unknown, allowed = _UNKNOWN.match(got), _ALLOWED
    kind = (vars(segments) | vars(tensors)).get(unknown[2]) if unknown else None
    if unknown and kind:
        got, allowed = f"{unknown[2]} has no {unknown[1]}", members_of(kind)
    rows = f"{file}, line {line}: not for a formula: {text}", f"got      {got}", f"allowed  {allowed}"
    return "\n  ".join((*rows, f"try      {_HINT}"))


def _told(error: Any) -> str:
    """Return the line of a formula that cannot be compiled, and numba's first reason, in two lines."""
    lines = [line.strip() for line in str(error).splitlines()]
    places = [match.groups() for line in lines for match in _PLACE.finditer(line)]
    own = [(first or second, int(one or other)) for first, one, second, other in places if _is_own(first or second)]
    said = [i for i, line in enumerate(lines) if _SAYS.match(line)]
    reason = lines[said[-1]] if said else lines[0]
    called = [line[4:] for line in lines if line.startswith(">>> ")]
    if called and reason.startswith("No implementation"):
        reason = f"no such function: {called[-1]}"
    if not own or reason.startswith("NameError"):  # which has no line
        formula = _INLINED.search(str(error))
        return f"a formula cannot be compiled: {f'{formula[1]}: ' if formula else ''}{reason}\n  try      {_HINT}"
    return _refusal(*own[-1], reason)


def _is_own(file: str) -> bool:
    """Return whether a file is an author's."""
    return file.endswith(".py") and not Path(file).resolve().is_relative_to(_CORE)


_PLACE = re.compile(r'File "([^"]+)", line (\d+)|at (\S+\.py) \((\d+)\)')
_SAYS = re.compile(
    r"NameError|No implementation|Unknown attribute|Untyped global|Use of|Cannot|Unsupported|Invalid|.*no attribute"
)
_INLINED = re.compile(r"Inlined\(<function (\S+)")  # the innermost comes first
_UNKNOWN = re.compile(r"Unknown attribute '(\w+)' of type (\w+)")
_ALLOWED = (
    "numbers, tuples of them, + - * / **, comparisons, min, max, abs, the functions of math, if, for, while, other "
    "functions of numbers"
)
_HINT = "CONTACTLAB_PYTHON=1 runs formulas as plain Python; arrays belong in a method of the part"
_CORE = Path(__file__).resolve().parents[2]


def _seed(x: float, direction: int, directions: int) -> Any:
    unit = np.zeros(directions)
    unit[direction] = 1.0
    return mathematics.DualNumber(float(x), unit)


def _derivatives(x: Any, directions: int) -> tuple[float, ...]:
    return tuple(x.derivatives[:directions]) if isinstance(x, mathematics.DualNumber) else (0.0,) * directions


def _value(x: Any) -> Any:
    return x.value if isinstance(x, mathematics.DualNumber) else x


def _put_column(array: Any, number: int, numbers: Any) -> None:
    for row, found in enumerate(numbers):
        array[(row, number)[: array.ndim]] = _value(found)


_PYTHON: dict[Any, Any] = {
    unpack: lambda table, kind: table,
    dual.value: _value,
    dual.seed: _seed,
    dual.derivatives: _derivatives,
    records.column: lambda array, number, kind: kind(*(array[:, number] if array.ndim == 2 else array).tolist()),
    records.put_column: _put_column,
    compiled_mathematics.log: mathematics.log,
    compiled_mathematics.exp: mathematics.exp,
    kernel.power: mathematics.power,
}
"""Replacements of the functions that only kernels know."""
