"""Running a matrix: cells side by side, each kept in the archive as it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contactlab.archive.archive import FILE, Archive
from contactlab.matrix.cell import CellResult, cell_key, known_cell, run_cell
from contactlab.matrix.plan import Cell, Request, plan
from contactlab.parts.registry import Registry
from contactlab.studies.call import Call, Pool
from contactlab.studies.pool import ProcessDiedError, RaisedError
from contactlab.studies.scheduler import LOCAL, open_pool
from contactlab.views import view

Told = Callable[[Cell, CellResult, int, int], None]
"""Called after each cell with how many are done of how many."""


@dataclass(frozen=True, repr=False)
class Matrix:
    """Cells with what came of them, in the order of the plan."""

    cells: Sequence[tuple[Cell, CellResult]]

    def count(self, verdict: str) -> int:
        """Number of cells that have a verdict."""
        return sum(result.verdict == verdict for _, result in self.cells)

    def __repr__(self) -> str:
        return str(view("texts.matrix_text")(self))

    def _repr_html_(self) -> str:
        return str(view("html.matrix_html")(self))

    def to_frame(self) -> Any:
        """A pandas frame with a row for each measure."""
        return view("frames.matrix_frame")(self)


def run_matrix(
    request: Request, registry: Registry, folder: Path, jobs: int, told: Told, scheduler: str = LOCAL
) -> Matrix:
    """Every cell of the request. What the archive in `folder` holds is not run again.

    Raises RequestError for a wrong request, and KeyboardInterrupt; what is done is in the archive then.
    """
    cells = plan(request, registry)
    done: dict[int, CellResult] = {}
    with Archive(folder / FILE) as archive, open_pool(scheduler, jobs) as pool:
        for number, result in _all(cells, registry, folder / FILE, pool):
            keep(archive, cells[number], result, registry)
            done[number] = result
            told(cells[number], result, len(done), len(cells))
    return Matrix([(cell, done[number]) for number, cell in enumerate(cells)])


def keep(archive: Archive, cell: Cell, result: CellResult, registry: Registry) -> None:
    """Put a cell and its new runs into the archive."""
    for run in result.made:
        archive.add_run(run)
    result.made.clear()
    archive.add_cell(cell_key(cell, registry, result.runs), result.machine, cell.choices, result.as_data())


def _all(cells: Sequence[Cell], registry: Registry, archive: Path, pool: Pool) -> Iterator[tuple[int, CellResult]]:
    futures: dict[Future[CellResult], int] = {}
    for number, cell in enumerate(cells):
        # a worker on another machine cannot look into the archive of this one
        known = known_cell(cell, registry, archive) if pool.elsewhere else None
        if known is not None:
            yield number, known
        else:
            futures[pool.submit(Call(run_cell, (cell, registry, archive)))] = number
    for future in as_completed(futures):
        yield futures[future], _result(future)


def _result(future: Future[CellResult]) -> CellResult:
    try:
        return future.result()
    except ProcessDiedError as error:
        return CellResult("failed", "failed", str(error))
    except RaisedError as error:
        return CellResult("failed", "failed", f"{error}\n{error.details}")
