"""Running a matrix: cells side by side, each kept in the archive as it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, as_completed
from dataclasses import dataclass
from pathlib import Path

from contactlab.matrix.archive import FILE, Archive
from contactlab.matrix.cell import CellResult, cell_key, run_cell
from contactlab.matrix.keys import machine
from contactlab.matrix.plan import Cell, Request, plan
from contactlab.parts.registry import Registry
from contactlab.studies.pool import ProcessDiedError, RaisedError, WorkerPool

Told = Callable[[Cell, CellResult, int, int], None]
"""Called after each cell with how many are done of how many."""


@dataclass(frozen=True)
class Matrix:
    """Cells with what came of them, in the order of the plan."""

    cells: Sequence[tuple[Cell, CellResult]]

    def count(self, verdict: str) -> int:
        """Cells with a verdict."""
        return sum(result.verdict == verdict for _, result in self.cells)


def run_matrix(request: Request, registry: Registry, folder: Path, jobs: int, told: Told) -> Matrix:
    """Every cell of the request. What the archive in `folder` holds is not run again.

    Raises RequestError for a wrong request, and KeyboardInterrupt; what is done is in the archive then.
    """
    cells = plan(request, registry)
    done: dict[int, CellResult] = {}
    with Archive(folder / FILE) as archive, WorkerPool(jobs) as pool:
        for number, result in _all(cells, registry, folder / FILE, pool):
            keep(archive, cells[number], result, registry)
            done[number] = result
            told(cells[number], result, len(done), len(cells))
    return Matrix([(cell, done[number]) for number, cell in enumerate(cells)])


def keep(archive: Archive, cell: Cell, result: CellResult, registry: Registry) -> None:
    """Put a cell and its new runs into the archive."""
    for run in result.made:
        archive.add_run(run, machine())
    result.made.clear()
    archive.add_cell(cell_key(cell, registry, result.runs), machine(), cell.choices, result.as_data())


def _all(
    cells: Sequence[Cell], registry: Registry, archive: Path, pool: WorkerPool
) -> Iterator[tuple[int, CellResult]]:
    futures: dict[Future[CellResult], int] = {
        pool.submit(run_cell, cell, registry, archive): number for number, cell in enumerate(cells)
    }
    for future in as_completed(futures):
        yield futures[future], _result(future)


def _result(future: Future[CellResult]) -> CellResult:
    try:
        return future.result()
    except ProcessDiedError as error:
        return CellResult("failed", "failed", str(error))
    except RaisedError as error:
        return CellResult("failed", "failed", f"{error}\n{error.details}")
