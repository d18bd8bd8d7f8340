"""Answers of cases are those of the rows that they come from, and no better known than these say."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from contactlab_cases.disc_with_friction import FORCES
from contactlab_cases.tresca_block import LIFTS

STUDIES = Path(__file__).parents[3] / "benchmarks" / "studies"
ROUNDED = 1e-4
"""Answers are written with four or five digits."""


@pytest.fixture(scope="module")
def found() -> dict[tuple[str, str], tuple[float, float]]:
    """Value and error by question and quantity, from the rows."""
    sys.path.insert(0, str(STUDIES))
    try:
        import references_page
    finally:
        sys.path.remove(str(STUDIES))
    return {
        (one.question, one.quantity): (one.value, one.error) for one in references_page.found(references_page.stored())
    }


@pytest.mark.parametrize("key", list(FORCES))
def test_reactions_with_friction(key: tuple[float, float], found: dict[tuple[str, str], tuple[float, float]]) -> None:
    mu, depth = key
    value, error = found[f"disc-with-friction, mu={mu}, depth={depth}", "reaction [N/mm]"]
    answer, known, _ = FORCES[key]
    assert answer == pytest.approx(value, rel=ROUNDED)
    assert error / value <= known <= 1.2 * error / value


@pytest.mark.parametrize("where", list(LIFTS))
def test_lifts(where: str, found: dict[tuple[str, str], tuple[float, float]]) -> None:
    value, error = found[f"tresca-block, {where}", "lift of the free corner [mm]"]
    answer, known = LIFTS[where]
    assert answer == pytest.approx(value, rel=ROUNDED)
    assert known == pytest.approx(error / value, rel=0.05)
