"""Pictures, frames and HTML of scenes and results, made above them and imported when they are shown.

What holds data knows the name of a view alone, so that no run imports anything that draws.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any


def view(name: str) -> Callable[..., Any]:
    """A function of `contactlab.reports` by "module.function"."""
    module, _, function = name.rpartition(".")
    made: Callable[..., Any] = getattr(import_module(f"contactlab.reports.{module}"), function)
    return made
