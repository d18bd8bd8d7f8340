"""Tractions around half a circle as functions of the angle."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contactlab_cases.nested import around


@pytest.mark.parametrize("below", [0.0, -1e-17])
def test_an_end_a_rounding_below_the_axis_is_still_the_end(below: float) -> None:
    """A node at (-r, -1e-17) has the angle -pi by arctan2; half a circle in the other half-plane likewise."""
    at = np.linspace(0.0, np.pi, 9)
    for way in (1.0, -1.0):
        x, y = 0.6 * np.cos(at), way * 0.6 * np.sin(at)
        y[-1] = below
        curve = SimpleNamespace(x=x, y=y, pressure=1.0 + at)
        record: Any = SimpleNamespace(curve=lambda name, curve=curve: curve)
        assert around(record)(way * at) == pytest.approx(1.0 + at, abs=1e-12)
