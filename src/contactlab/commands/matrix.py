"""`contactlab matrix`: cases with known answers against contact algorithms."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from contactlab.cases.verdict import WORST
from contactlab.commands.common import add_row, console, fitting, print_json, registry_with, table
from contactlab.commands.interruption import interrupted
from contactlab.matrix.cell import CellResult
from contactlab.matrix.files import against, plain_cells, verdicts, write
from contactlab.matrix.orders import orders, write_orders
from contactlab.matrix.page import write_page
from contactlab.matrix.plan import Cell, Request, plan
from contactlab.matrix.run import Matrix, run_matrix
from contactlab.parts.machine import usable_cores
from contactlab.parts.registry import Registry
from contactlab.run.folders import results_folder
from contactlab.studies.resume import sigterm_as_ctrl_c
from contactlab.studies.scheduler import checked_scheduler

SHORT = {"not-applicable": "-", "not-judged": "not judged", "ill-posed": "ill-posed"}


def matrix(options: argparse.Namespace) -> int:
    """Run the cells and show them by case; exit status 1 only where `--against` finds one that is worse."""
    registry = registry_with(options.files)
    request = Request(options.cases, options.contacts, options.full, tuple(dict.fromkeys(options.levels or (1,))))
    jobs = options.jobs or usable_cores()
    checked_scheduler(options.scheduler)
    before = verdicts(Path(options.against)) if options.against else None
    plan(request, registry)  # a wrong name is told before a folder is made
    with results_folder(options.out, "matrix", options.resume) as folder:
        try:
            if options.margins:
                return show_margins(request, registry, folder, jobs, options)
            with sigterm_as_ctrl_c():
                found = run_matrix(request, registry, folder, jobs, _tell, options.scheduler)
        except KeyboardInterrupt:
            return interrupted(folder)
        write(found, folder)
        write_orders(found, folder)
        write_scenes(folder)
        write_page(found, folder)
    if options.json:
        changes = against(found, before) if before is not None else {}
        print_json({"format": 1, "folder": str(folder), "cells": plain_cells(found), "changes": changes})
        return 1 if changes.get("worse") else 0
    show(found)
    show_orders(found)
    console().print(f"page: {folder / 'matrix.html'}", markup=False, highlight=False, soft_wrap=True)
    return _show_changes(found, before) if before is not None else 0


def show_margins(request: Request, registry: Registry, folder: Path, jobs: int, options: argparse.Namespace) -> int:
    """Find the margins and print them."""
    from contactlab.matrix.margins import run_margins

    with sigterm_as_ctrl_c():
        margins = run_margins(request, registry, folder, jobs, _say, options.scheduler)
    if options.json:
        print_json({"format": 1, "folder": str(folder), "margins": list(margins)})
        return 0
    shown = table("case", "field", "contact", "from", "met up to", "not met at", "there")
    for m in margins:
        end = f"{m.met:.4g}" + (" (the limit)" if m.missed != m.missed else "")
        missed = "" if m.missed != m.missed else f"{m.missed:.4g}"
        add_row(
            shown, m.case, m.field, m.contact, f"{m.start:.4g}", end, missed, f"{m.verdict} {m.reason[:90]}".strip()
        )
    out = console()
    out.print(fitting(shown, out.width, last=("case",)))
    return 0


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def write_scenes(folder: Path) -> None:
    """The scene of every run as a file of its own, where the page leads to."""
    from contactlab.archive.archive import FILE, Archive

    (folder / "scenes").mkdir(exist_ok=True)
    with Archive(folder / FILE, write=False) as archive:
        for run in archive.runs():
            (folder / "scenes" / f"{run['key']}.toml").write_text(run["scene"], encoding="utf-8")


def _tell(cell: Cell, result: CellResult, done: int, total: int) -> None:
    """One line per cell where nobody watches a terminal, one line that is written over where somebody does."""
    line = f"{done}/{total} {result.verdict}: {cell.label}"
    if sys.stderr.isatty():
        print(f"\r\033[K{line[:110]}", end="" if done < total else "\n", file=sys.stderr, flush=True)
    else:
        print(line, file=sys.stderr, flush=True)


def show(found: Matrix) -> None:
    """Counts, the silent ones first, and one line per case and variant."""
    out = console()
    counts = ", ".join(
        f"{found.count(verdict)} {verdict}" for verdict in WORST if found.count(verdict) or verdict == "silent"
    )
    out.print(f"{counts} of {len(found.cells)} cells", markup=False, highlight=False, soft_wrap=True)
    contacts = list(dict.fromkeys(cell.choices["contact"] for cell, _ in found.cells))
    lines: dict[tuple[str, ...], dict[str, CellResult]] = {}
    for cell, result in found.cells:
        c = cell.choices
        lines.setdefault(tuple(c[n] for n in ("case", "variant", "slave", "element", "integrator")), {})[
            c["contact"]
        ] = result
    shown = table("case", "variant", "slave", "element", "integrator", *contacts)
    for head, cells in lines.items():
        words = [SHORT.get(cells[name].verdict, cells[name].verdict) if name in cells else "" for name in contacts]
        add_row(shown, *head, *words)
    out.print(fitting(shown, out.width, last=("case", *contacts)))
    for cell, result in found.cells:
        if result.verdict in ("silent", "failed"):
            line = f"{result.verdict}: {cell.label}: {result.reason.splitlines()[0] if result.reason else ''}"
            out.print(line, markup=False, highlight=False, soft_wrap=True)


def show_orders(found: Matrix) -> None:
    """Orders of convergence, where there are several levels."""
    lines = orders(found)
    if not lines:
        return
    shown = table("case", "variant", "contact", "slave", "measure", "levels", "order", "theory")
    for line in lines:
        half = "" if line["interval"] is None else f" ± {line['interval']:.2f}"
        theory = "" if line["theory"] is None else f"{line['theory']:g}"
        names = [line[name] for name in ("case", "variant", "contact", "slave", "measure", "levels")]
        add_row(shown, *names, f"{line['order']:.2f}{half}", theory)
    out = console()
    out.print(fitting(shown, out.width, last=("case", "order")))


def _show_changes(found: Matrix, before: dict[tuple[str, ...], str]) -> int:
    """What is better, worse, new or only in the earlier one; 1 where anything is worse."""
    changes = against(found, before)
    out = console()
    said = ", ".join(f"{len(changes[name])} {name}" for name in ("better", "worse", "new"))
    out.print(f"{said}; {len(changes['gone'])} in the earlier one alone", markup=False, highlight=False)
    for name in ("worse", "better"):
        for key, old, new in changes[name]:
            label = ", ".join(text for text in key if text)
            out.print(f"{name}: {label}: {old}, now {new}", markup=False, highlight=False, soft_wrap=True)
    return 1 if changes["worse"] else 0
