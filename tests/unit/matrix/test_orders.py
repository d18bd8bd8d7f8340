"""Orders in a matrix: slopes that are known, and which errors take part."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from contactlab.api import Setup
from contactlab.verdicts.cell import CellResult
from contactlab.verdicts.orders import orders, write_orders
from contactlab.verdicts.plan import Cell
from contactlab.verdicts.run import Matrix


def cell(level: int, error: float, role: str = "error", order: float | None = 2.0) -> tuple[Cell, CellResult]:
    measure = {"measure": "L2", "role": role, "value": error, "order": order}
    setup = Setup("mortar-p0", False, "q1", "newton", level)
    return Cell("two-rings", {"ratio": 2.0}, setup), CellResult("met", "finished", "", [measure], [], 0.0)


def test_the_slope_of_a_power_is_its_exponent_with_no_interval(tmp_path: Path) -> None:
    found = Matrix([cell(n, -0.01 / n**1.5) for n in (1, 2, 4)])  # of either sign
    (line,) = orders(found)
    assert line["order"] == pytest.approx(1.5, rel=1e-12)
    assert line["interval"] == pytest.approx(0.0, abs=1e-12)
    assert (line["levels"], line["theory"], line["variant"]) == ("1 2 4", 2.0, "ratio=2")
    write_orders(found, tmp_path)
    assert (tmp_path / "orders.csv").read_text().splitlines()[0].endswith("measure,levels,order,interval,theory")


def test_two_levels_have_no_interval_and_others_no_order() -> None:
    (line,) = orders(Matrix([cell(1, 0.02), cell(2, 0.01)]))
    assert (line["order"], line["interval"]) == (pytest.approx(1.0), None)
    for without in (
        [cell(1, 0.02)],
        [cell(1, 0.02), cell(2, math.nan)],
        [cell(1, 0.02, "reported"), cell(2, 0.01, "reported")],
    ):
        assert orders(Matrix(without)) == []
    assert orders(Matrix([cell(1, 1e-14), cell(2, 3e-15), cell(4, 0.01)])) == []  # round-off is no mesh's error
