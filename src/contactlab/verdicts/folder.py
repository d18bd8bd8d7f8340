"""All files that a matrix leaves beside its archive."""

from __future__ import annotations

from pathlib import Path

from contactlab.jobs.archive import FILE, Archive
from contactlab.verdicts.files import write
from contactlab.verdicts.orders import write_orders
from contactlab.verdicts.page import write_page
from contactlab.verdicts.run import Matrix


def write_folder(found: Matrix, folder: Path) -> None:
    """Write tables, orders of convergence, page, and the scene of every run, where the page leads to."""
    write(found, folder)
    write_orders(found, folder)
    (folder / "scenes").mkdir(exist_ok=True)
    with Archive(folder / FILE, write=False) as archive:
        for run in archive.runs():
            (folder / "scenes" / f"{run['key']}.toml").write_text(run["scene"], encoding="utf-8")
    write_page(found, folder)
