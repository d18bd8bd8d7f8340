"""Prices of effects by version: what became dearer is found."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    folders = (BENCHMARKS, BENCHMARKS / "kernels", BENCHMARKS / "studies")
    monkeypatch.setattr(sys, "path", [*map(str, folders), *sys.path])


def test_what_became_dearer_is_found() -> None:
    import price_history

    before = {"time step: friction": 10.0, "time step: gravity": 1.0, "time step: contact": 30.0, "gone": 5.0}
    now = {"time step: friction": 12.5, "time step: gravity": 1.9, "time step: contact": 33.0, "new": 9.0}
    assert price_history.dearer(before, now) == {"time step: friction": pytest.approx(0.25)}


def row(run: str, foreseen: float | None, measured: float | None, **more: str) -> dict[str, str]:
    known = {
        "scene": "a", "kind": "fixed", "foreseen_steps": "10", "steps": "10", "least_s": "0.5", "most_s": "3",
        "foreseen_mib": "1", "mib": "2", "ended": "finished",
        "tried_s": "", "tried_least_s": "", "tried_most_s": "", "tried": "",
    }  # fmt: skip
    costs = {"foreseen_s": str(foreseen or ""), "measured_s": str(measured or "")}
    return {**known, "run": run, **costs, **more}


def test_lines_of_bills_are_differences_of_runs() -> None:
    import foreseen_prices

    rows = [
        row("as declared", 2.0, 2.5), row("without contact", 1.0, 1.0), row("with gravity", 2.2, 3.0),
        row("without damping", 1.0, None, ended="diverged"),
    ]  # fmt: skip
    contact, gravity = foreseen_prices.effects(rows)
    assert (contact.foreseen_s, contact.measured_s) == pytest.approx((1.0, 1.5))
    assert contact.of_bill == pytest.approx(-0.2)
    assert contact.of_itself == pytest.approx(-1.0 / 3.0)
    assert (gravity.foreseen_s, gravity.measured_s) == pytest.approx((0.2, 0.5))
    told = dict(foreseen_prices.findings(rows))
    assert told["lines of the bills, errors over the cost of the run"].startswith("50 % of 2 within 15 %")
    assert told["memory of arrays"].startswith("0 % of 3")
    page = foreseen_prices.page(rows)
    assert "| a | contact | 1 | 1.5 | -20 |" in page
    assert "diverged" in page
