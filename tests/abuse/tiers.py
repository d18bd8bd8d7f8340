"""Variants of a test of which some stand for all in `make test`, and all are tried with FULL=1."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def some(names: Iterable[Any], always: Collection[Any]) -> list[Any]:
    """Parameters of a test, or tuples of some: those in `always` in every tier, the others in the full one."""
    names = list(names)
    assert set(always) <= set(names), f"no such variant: {set(always) - set(names)}"
    values = [name if isinstance(name, tuple) else (name,) for name in names]
    marks = [() if name in always else pytest.mark.full for name in names]
    return [pytest.param(*one, marks=mark) for one, mark in zip(values, marks, strict=True)]
