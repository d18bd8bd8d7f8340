"""The watch of nodal contact forces says when it had no room for all steps."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contactlab_cases.dynamics import NodalForces
from contactlab_cases.series import table


def watched(most: int, steps: int) -> Any:
    """What a record holds of so many steps, with forces that are the numbers of the steps."""
    watch = NodalForces(every=2, most=most)
    nodes = np.array([1, 2])
    view: Any = SimpleNamespace(reference=np.arange(8.0).reshape(4, 2), slave=lambda: nodes)
    memory = watch.begin(view)
    for step in range(1, steps + 1):
        view.step, view.time = step, 0.1 * step
        view.field = lambda _, value=float(step): np.full((4, 2), value)
        watch.step(view, memory)
    return SimpleNamespace(watched={"nodal-forces": watch.end(memory)})


def test_every_second_step_is_a_row() -> None:
    found = table(watched(most=3, steps=7), "nodal-forces")
    assert found["x"].tolist() == [2.0, 4.0]
    assert found["time"] == pytest.approx([0.2, 0.4, 0.6])
    assert found["force"].tolist() == [[2.0, 2.0], [4.0, 4.0], [6.0, 6.0]]


def test_rows_without_room_are_told() -> None:
    with pytest.raises(LookupError, match="2 rows of the series nodal-forces do not fit"):
        table(watched(most=1, steps=7), "nodal-forces")
