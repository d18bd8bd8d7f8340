"""Late imports: a module is imported when it is first needed, at next to no cost in the calls that follow."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

__all__ = ["late"]


@cache
def late(module: str) -> Any:
    """The module of that name, imported at the first call and kept; cheap enough for every step.

    An import statement within a function costs as much as passing a kernel ten arrays.
    """
    return import_module(module)
