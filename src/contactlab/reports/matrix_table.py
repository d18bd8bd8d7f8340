"""The table of a matrix: a row per case and variant, a column per contact algorithm."""

from __future__ import annotations

from contactlab.reports.sheet import Cell, Column, Sheet
from contactlab.verdicts.run import Matrix

KEYS = ("case", "variant", "slave", "element", "integrator")
SHORT = {"not-applicable": "-", "not-judged": "not judged"}
"""Verdicts that are written otherwise in cells."""


def matrix_sheet(matrix: Matrix) -> Sheet:
    """Verdicts, the worst first; reasons are shown where a reader points at them."""
    contacts = list(dict.fromkeys(cell.choices["contact"] for cell, _ in matrix.cells))
    lines: dict[tuple[str, ...], dict[str, Cell]] = {}
    for cell, result in matrix.worst_first:
        place = lines.setdefault(tuple(cell.choices[name] for name in KEYS), {})
        word = SHORT.get(result.verdict, result.verdict)
        text = f"{word} {result.number}".strip()
        place[cell.choices["contact"]] = Cell(text, kind=result.verdict, hint=result.reason)
    heads = [Column(name, keep=name not in KEYS[1:], leads=name in KEYS) for name in (*KEYS, *contacts)]
    return Sheet(heads, ([*key, *(cells.get(name, "") for name in contacts)] for key, cells in lines.items()))
