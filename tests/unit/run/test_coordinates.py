"""Positions in messages have no digits of round-off."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from contactlab.run.coordinates import coordinates

MODEL = cast("Any", SimpleNamespace(reference=np.array([[-8.0, 6.0], [8.0, 24.0]])))


@pytest.mark.parametrize(
    ("point", "text"),
    [((1.244e-05, 20.0), "(0, 20)"), ((-8.1e-6, 14.0123), "(0, 14.01)"), ((0.0123, -0.4), "(0.0123, -0.4)")],
)
def test_what_is_round_off_of_the_size_of_the_model_is_zero(point: tuple[float, float], text: str) -> None:
    """18 mm high: a roller that rests on its race is held there to 1e-5 mm."""
    assert coordinates(MODEL, np.array(point)) == text
