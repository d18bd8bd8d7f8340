"""Promises of `choose` are judged only by what is known well enough."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

STUDIES = Path(__file__).parents[3] / "benchmarks" / "studies"


@pytest.mark.parametrize(
    ("verdict", "error", "known", "told"),
    [
        ("ok", 0.01, 0.002, "kept"),
        ("ok", 0.03, 0.002, "WRONG"),
        ("ok", math.nan, 0.002, "WRONG"),
        ("ok", 0.03, 0.27, "not judged"),
        ("ok", 0.01, 0.27, "not judged"),
        ("ok", math.nan, math.nan, "not judged"),
        ("cannot", 0.03, 0.002, "none"),
    ],
)
def test_a_promise_is_judged_by_what_is_known(
    verdict: str, error: float, known: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [str(STUDIES), *sys.path])
    import choices

    found: Any = SimpleNamespace(verdict=verdict)
    assert choices.promise(found, error, known, 0.02) == told
