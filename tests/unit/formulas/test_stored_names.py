"""Names under which kernels of formulas are stored are the same in every process."""

from __future__ import annotations

from collections.abc import Callable
from types import CodeType
from typing import Any

import pytest
from contactlab_segments.node_on_segment import NodeOnSegment

from contactlab.api.compiled import formulas
from contactlab.formulas import point_derivatives, point_kernels, points

TEMPLATES = (point_kernels.pieces, point_derivatives.piece_derivatives)


def stored_names(kind: type) -> list[str]:
    return [points._Kernels(kind).made(template).py_func.__qualname__ for template in TEMPLATES]


def in_order(names: Callable[[CodeType], set[str]], down: bool) -> Callable[[CodeType], Any]:
    """The set of names as a process may walk through it."""
    return lambda code: dict.fromkeys(sorted(names(code), reverse=down))


def test_the_order_of_sets_does_not_change_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each process has its own order: kernels were compiled again in every second one."""
    names, found = formulas._names, []
    for down in (False, True):
        monkeypatch.setattr(formulas, "_names", in_order(names, down))
        found.append(stored_names(NodeOnSegment))
    assert found[0] == found[1]
