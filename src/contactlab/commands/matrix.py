"""`contactlab matrix`: cases with known answers against contact algorithms."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from contactlab.cases.verdict import WORST
from contactlab.commands.common import console, print_json, registry_with
from contactlab.commands.many import folder_of, interrupted, many
from contactlab.reports.matrix_table import SHORT, matrix_sheet
from contactlab.reports.sheet import Column, Sheet
from contactlab.verdicts.files import MEANINGS, against, plain_cells, verdicts, write_folder
from contactlab.verdicts.margins import Margin, margins_asked, run_margins
from contactlab.verdicts.orders import orders
from contactlab.verdicts.plan import Request, plan
from contactlab.verdicts.run import Matrix, run_matrix


def matrix(options: argparse.Namespace) -> int:
    """Run the cells and show them by case; exit status 1 only if `--against` finds one that is worse."""
    registry = registry_with(options.files)
    request = Request(options.cases, options.contacts, options.full, tuple(dict.fromkeys(options.levels or (1,))))
    before = verdicts(Path(options.against)) if options.against else None
    # a wrong name is reported before a folder is made
    total = len(margins_asked(request, registry) if options.margins else plan(request, registry))
    with many(options, "matrix", total) as driver:
        folder = folder_of(driver)
        if options.margins:
            margins = run_margins(request, registry, driver, folder)
        else:
            found = run_matrix(request, registry, driver)
        if driver.interrupted:
            return interrupted(options, folder)
    if options.margins:
        return show_margins(margins, folder, options)
    write_folder(found, folder)
    if options.json:
        changes = against(found, before) if before is not None else {}
        print_json({"format": 1, "folder": str(folder), "cells": plain_cells(found), "changes": changes})
        return 1 if changes.get("worse") else 0
    show(found)
    show_orders(found)
    console().say(f"page: {folder / 'matrix.html'}")
    return _show_changes(found, before) if before is not None else 0


def show_margins(margins: Sequence[Margin], folder: Path, options: argparse.Namespace) -> int:
    """Print the margins."""
    if options.json:
        print_json({"format": 1, "folder": str(folder), "margins": list(margins)})
        return 0
    heads = Column("case", keep=True), "field", "contact", "from", "met up to", "not met at", "there"
    console().print(Sheet(heads, map(_margin, margins)))
    return 0


def _margin(m: Margin) -> list[str]:
    end = f"{m.met:.4g}" + (" (the limit)" if m.missed != m.missed else "")
    missed = "" if m.missed != m.missed else f"{m.missed:.4g}"
    return [m.case, m.field, m.contact, f"{m.start:.4g}", end, missed, f"{m.verdict} {m.reason[:90]}".strip()]


def show(found: Matrix) -> None:
    """Counts, the silent ones first, and one line per case and variant."""
    out = console()
    counts = ", ".join(
        f"{found.count(verdict)} {verdict}" for verdict in WORST if found.count(verdict) or verdict == "silent"
    )
    out.say(f"{counts} of {len(found.cells)} cells")
    out.print(matrix_sheet(found))
    there = [verdict for verdict in WORST if found.count(verdict)]
    legend = "; ".join(f"{SHORT.get(verdict, verdict)}: {MEANINGS[verdict]}" for verdict in there)
    out.print(f"{legend}; numbers: the first measure with this verdict", markup=False, highlight=False)
    for cell, result in found.worst_first:
        if result.verdict in ("silent", "failed"):
            line = f"{result.verdict}: {cell.label}: {result.reason.splitlines()[0] if result.reason else ''}"
            out.say(line)


def show_orders(found: Matrix) -> None:
    """Orders of convergence, if there are several levels."""
    lines = orders(found)
    if not lines:
        return
    names = ("case", "variant", "contact", "slave", "measure", "levels")
    rows = []
    for line in lines:
        half = "" if line["interval"] is None else f" ± {line['interval']:.2f}"
        theory = "" if line["theory"] is None else f"{line['theory']:g}"
        rows.append([*(line[name] for name in names), f"{line['order']:.2f}{half}", theory])
    heads = [Column(name, keep=name in ("case", "order")) for name in (*names, "order", "theory")]
    console().print(Sheet(heads, rows))


def _show_changes(found: Matrix, before: dict[tuple[str, ...], str]) -> int:
    """Print cells that are better, worse, new or only in the earlier matrix; 1 if any is worse."""
    changes = against(found, before)
    out = console()
    said = ", ".join(f"{len(changes[name])} {name}" for name in ("better", "worse", "new"))
    out.print(f"{said}; {len(changes['gone'])} only in the earlier matrix", markup=False, highlight=False)
    for name in ("worse", "better"):
        for key, old, new in changes[name]:
            label = ", ".join(text for text in key if text)
            out.say(f"{name}: {label}: {old}, now {new}")
    return 1 if changes["worse"] else 0
