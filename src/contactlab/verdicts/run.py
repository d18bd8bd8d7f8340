"""Running a matrix: a plan per cell, each kept in the archive when it is judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from contactlab.cases.verdict import WORST
from contactlab.jobs.driver import Driver
from contactlab.parts.registry import Registry
from contactlab.verdicts.cell import CellResult, cell_plan, keep
from contactlab.verdicts.plan import Cell, Request, plan
from contactlab.views import view


@dataclass(frozen=True, repr=False)
class Matrix:
    """Cells with what came of them, in the order of the plan."""

    cells: Sequence[tuple[Cell, CellResult]]

    def count(self, verdict: str) -> int:
        """Number of cells that have a verdict."""
        return sum(result.verdict == verdict for _, result in self.cells)

    @property
    def worst_first(self) -> list[tuple[Cell, CellResult]]:
        """The cells with silent ones first, then as the plan has them."""
        return sorted(self.cells, key=lambda pair: WORST.index(pair[1].verdict))

    def __repr__(self) -> str:
        return str(view("notebook.texts.matrix_text")(self))

    def _repr_html_(self) -> str:
        return str(view("notebook.html.matrix_html")(self))

    def to_frame(self) -> Any:
        """A pandas frame with a row for each measure."""
        return view("notebook.frames.matrix_frame")(self)


def run_matrix(request: Request, registry: Registry, driver: Driver) -> Matrix:
    """Every cell of the request; the driver says whether it was interrupted.

    Raises RequestError for a wrong request.
    """
    cells = plan(request, registry)
    done: dict[int, CellResult] = {}
    for number, result in driver.results(cell_plan(cell, registry) for cell in cells):
        keep(driver.archive, cells[number], result, registry)
        done[number] = result
        if result.whole:
            driver.progress.told(f"{result.verdict}: {cells[number].label}")
    return Matrix([(cell, done[number]) for number, cell in enumerate(cells)])
