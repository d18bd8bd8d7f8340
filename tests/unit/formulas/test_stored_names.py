"""Names under which kernels of formulas are stored: the same in every process, and for classes of the same formulas."""

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


def test_a_class_that_changes_no_formula_has_the_kernels_of_its_base() -> None:
    modest: Any = type("Modest", (NodeOnSegment,), {"passes_patch_test": True, "__module__": __name__})
    assert stored_names(modest) == stored_names(NodeOnSegment)
