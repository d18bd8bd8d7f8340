"""Lines of a part's formulas that ran, while formulas run as plain Python."""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType, FunctionType, ModuleType, TracebackType
from typing import Any

from contactlab.api.formulas import Formula, formulas_of

VARIABLE = "CONTACTLAB_PYTHON"


@dataclass(frozen=True)
class FormulaRun:
    """A formula, or a function that it calls: place, lines with code, and lines among them that did not run."""

    name: str
    file: str
    lines: tuple[int, ...]
    missed: tuple[int, ...]

    @property
    def share(self) -> str:
        """Number of its lines that ran, as text."""
        return f"{len(self.lines) - len(self.missed)} of {len(self.lines)}"


class FormulaLines:
    """Context in which kernels that are made run as plain Python, and lines of the formulas of parts are noted.

    Parts that were compiled before stay compiled, so it begins before any is used.
    """

    def __init__(self) -> None:
        self.ran: set[tuple[str, int]] = set()
        self.files: set[str] = set()
        self.before: str | None = None
        self.tracer: Any = None

    def __enter__(self) -> FormulaLines:
        self.before = os.environ.get(VARIABLE)
        os.environ[VARIABLE] = "1"
        self.tracer = sys.gettrace()
        sys.settrace(self._called)
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        sys.settrace(self.tracer)
        if self.before is None:
            del os.environ[VARIABLE]
        else:
            os.environ[VARIABLE] = self.before

    def watch(self, kind: type) -> None:
        """Note lines of the files that the formulas of a part and the functions that they call stand in."""
        self.files |= {function.__code__.co_filename for _, function in _functions_of(kind)}

    def of(self, kind: type) -> list[FormulaRun]:
        """The formulas of a part, in the order of their definition, then the functions that they call."""
        found = []
        for name, function in _functions_of(kind):
            code = function.__code__
            lines = tuple(sorted(set(_lines(code))))
            missed = tuple(line for line in lines if (code.co_filename, line) not in self.ran)
            found.append(FormulaRun(name, Path(code.co_filename).name, lines, missed))
        return found

    def _called(self, frame: FrameType, event: str, _: Any) -> Any:
        return self._line if frame.f_code.co_filename in self.files else None

    def _line(self, frame: FrameType, event: str, _: Any) -> Any:
        if event == "line":
            self.ran.add((frame.f_code.co_filename, frame.f_lineno))
        return self._line


def _functions_of(kind: type) -> list[tuple[str, FunctionType]]:
    """Return the formulas of a part and all functions that they call, by name, without those of the core."""
    found = [(name, formula.function) for name, formula in formulas_of(kind).items()]
    for _, function in found:  # which grows
        for name, held in _named_in(function):
            inner = held.function if isinstance(held, Formula) else getattr(held, "py_func", held)
            own = isinstance(inner, FunctionType) and not inner.__module__.startswith(("contactlab.", "numpy"))
            if own and all(inner is not known for _, known in found):
                found.append((name, inner))
    return found


def _named_in(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Global names that a function uses, and names of modules among them, with their values."""
    for name, held in inspect.getclosurevars(function).globals.items():
        if isinstance(held, ModuleType):
            yield from ((inner, getattr(held, inner)) for inner in function.__code__.co_names if hasattr(held, inner))
        else:
            yield name, held


def _lines(code: CodeType) -> Iterator[int]:
    """Lines with code of a function and of what is defined in it, without the line of its name."""
    for _, _, line in code.co_lines():
        if line is not None and line != code.co_firstlineno:
            yield line
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _lines(constant)
