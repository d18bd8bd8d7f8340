"""Late imports: a module is imported on demand; later calls cost next to nothing."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

__all__ = ["late"]


@cache
def late(module: str) -> Any:
    """Return the module of this name, imported at the first call and kept: cheap enough for every step.

    An import statement inside a function costs as much as passing ten arrays to a kernel.
    """
    return import_module(module)
