"""`contactlab matrix`: cases with known answers against contact algorithms."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from math import isfinite, nan
from pathlib import Path

from contactlab.cases.verdict import WORST
from contactlab.commands.common import add_row, console, fitting, print_json, registry_with, table
from contactlab.commands.many import folder_of, interrupted, many
from contactlab.verdicts.cell import CellResult
from contactlab.verdicts.files import MEANINGS, against, plain_cells, verdicts, write_folder
from contactlab.verdicts.margins import Margin, margins_asked, run_margins
from contactlab.verdicts.orders import orders
from contactlab.verdicts.plan import Request, plan
from contactlab.verdicts.run import Matrix, run_matrix

SHORT = {"not-applicable": "-", "not-judged": "not judged", "ill-posed": "ill-posed"}


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
            return interrupted(folder)
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


def show(found: Matrix) -> None:
    """Counts, the silent ones first, and one line per case and variant."""
    out = console()
    counts = ", ".join(
        f"{found.count(verdict)} {verdict}" for verdict in WORST if found.count(verdict) or verdict == "silent"
    )
    out.say(f"{counts} of {len(found.cells)} cells")
    contacts = list(dict.fromkeys(cell.choices["contact"] for cell, _ in found.cells))
    lines: dict[tuple[str, ...], dict[str, CellResult]] = {}
    for cell, result in found.worst_first:
        c = cell.choices
        lines.setdefault(tuple(c[n] for n in ("case", "variant", "slave", "element", "integrator")), {})[
            c["contact"]
        ] = result
    shown = table("case", "variant", "slave", "element", "integrator", *contacts)
    for head, cells in lines.items():
        words = [_word(cells[name]) if name in cells else "" for name in contacts]
        add_row(shown, *head, *words)
    out.print(fitting(shown, out.width, last=("case", *contacts)))
    there = [verdict for verdict in WORST if found.count(verdict)]
    legend = "; ".join(f"{SHORT.get(verdict, verdict)}: {MEANINGS[verdict]}" for verdict in there)
    out.print(f"{legend}; numbers: the first measure with this verdict", markup=False, highlight=False)
    for cell, result in found.worst_first:
        if result.verdict in ("silent", "failed"):
            line = f"{result.verdict}: {cell.label}: {result.reason.splitlines()[0] if result.reason else ''}"
            out.say(line)


def _word(result: CellResult) -> str:
    """The verdict and the value of the first measure that has it, errors before others."""
    same = [m for m in result.measures if m["verdict"] == result.verdict and isfinite(m["value"] or nan)]
    first = min(same, key=lambda m: m["role"] != "error", default=None)
    word = SHORT.get(result.verdict, result.verdict)
    return word if first is None else f"{word} {first['value']:.2g} {first['unit']}".strip()


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
            out.say(f"{name}: {label}: {old}, now {new}")
    return 1 if changes["worse"] else 0
