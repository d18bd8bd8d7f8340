"""Late imports: a module is imported when it is first needed; later calls cost next to nothing."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

__all__ = ["late"]


@cache
def late(module: str) -> Any:
    """The module of that name, imported at the first call and kept: cheap enough to be called in every step.

    An import statement inside a function costs as much as passing ten arrays to a kernel.
    """
    return import_module(module)
