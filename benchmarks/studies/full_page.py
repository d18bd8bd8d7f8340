"""build/docs/full-matrix.md from the archive of `contactlab matrix --full`: verdicts, and why some are no answer.

    contactlab matrix --full --out runs/full && make pages CASES=runs/full

The newest cell of each configuration is kept in full_matrix.csv, one row each; a folder with some of the cases brings
the rows of those. Every kind of cell that is silent, that
failed or was not judged has its cause in full_causes.py, and so have numbers that are missed, where it is known.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import case_rows
from full_causes import CAUSES, UNKNOWN, why_missed
from matrix_page import applying

from contactlab.jobs.archive import CHOICES, Archive
from contactlab.jobs.rows import Row, read_csv, write_csv
from contactlab.parts.registry import default_registry
from contactlab.reports.sheet import Sheet
from contactlab.verdicts.plan import Request

HERE = Path(__file__).parent
STORED = HERE / "full_matrix.csv"
COLUMNS = (*CHOICES, "verdict", "cpu_s", "reason")
UNANSWERED = ("silent", "failed", "not-judged")
ORDER = ("silent", "failed", "missed", "not-judged", "ill-posed", "met")

HEAD = """# The full matrix

Written by `make pages` from the archive of `contactlab matrix --full`: {cells} cells that apply
(cases with all their variants, either slave, all their elements and integrators, all contact methods) in {minutes:.0f}
CPU minutes{others}. {counts}{missing}

[Cases against algorithms](matrix.md) explains the verdicts. The numbers of the quick matrix are in
[Every case](cases.md).

## By case

Cells that are met, or ill-posed where that is the answer / all cells; then the numbers of silent (s), failed (f) and
not judged (n) cells.
"""


def rows_of(archive: Path) -> list[Row]:
    """The newest cell of each configuration of the full matrix; an archive may hold more."""
    rows = []
    with Archive(archive, write=False) as kept:
        for key, cell in case_rows.newest(kept.cells(), case_rows.asked(Request(full=True))):
            reason = " ".join((cell["reason"] or "").split())[:90]
            ends = {"verdict": str(cell["verdict"]), "cpu_s": f"{cell['cpu_s']:.1f}", "reason": reason}
            rows.append({**dict(zip(CHOICES, key, strict=True)), **ends})
    return rows


def keep(rows: list[Row]) -> None:
    """Put rows into full_matrix.csv, in place of those of the same cells; what no longer applies leaves."""
    planned = case_rows.applying(case_rows.asked(Request(full=True)))
    write_csv(STORED, COLUMNS, case_rows.merged(stored(), rows, planned))


def stored() -> list[Row]:
    """The rows that are kept."""
    return read_csv(STORED)


def unanswered(rows: list[Row]) -> Counter[tuple[str, str, str]]:
    """How many cells of each kind gave no right answer."""
    return Counter((row["case"], row["contact"], row["verdict"]) for row in rows if row["verdict"] in UNANSWERED)


def page(rows: list[Row]) -> str:
    """The page of these rows."""
    found = Counter(row["verdict"] for row in rows)
    counts = ", ".join(f"{found[v]} {v}" for v in ORDER if found[v] or v == "silent") + "."
    minutes = sum(float(row["cpu_s"]) for row in rows) / 60.0
    planned = applying(full=True)[1]
    cells, others = f"all {planned}", ""
    if len(rows) < planned:
        cells, others = f"{len(rows)} of the {planned}", "; the others have not been run yet"
    head = HEAD.format(cells=cells, minutes=minutes, others=others, counts=counts, missing=_missing(rows))
    causes = (
        [f"`{case}`", contact, f"{number} {verdict}", CAUSES.get((case, contact, verdict), "")]
        for (case, contact, verdict), number in sorted(unanswered(rows).items())
    )
    missed = list(_missed(rows))
    unknown = sum(number for *_, number, _, cause in missed if cause.startswith(UNKNOWN))
    text = [
        head, _table(rows), "", "## Silent, failed and not judged, with the cause", "",
        Sheet(("case", "algorithm", "cells", "cause"), causes).markdown(), "",
        "## Missed, by the number that misses first", "", f"The cause is not known for {unknown} cells.", "",
        Sheet(("case", "algorithm", "cells", "number", "cause"), missed).markdown(),
    ]  # fmt: skip
    return "\n".join(text) + "\n"


def _missing(rows: list[Row]) -> str:
    """List the cases that have not been run yet."""
    names = sorted(set(default_registry().names("case")) - {row["case"] for row in rows})
    return f"\n\nNot run yet: {', '.join(f'`{name}`' for name in names)}." if names else ""


def _table(rows: list[Row]) -> str:
    contacts = sorted({row["contact"] for row in rows})
    lines = []
    for case in sorted({row["case"] for row in rows}):
        cells = (Counter(r["verdict"] for r in rows if (r["case"], r["contact"]) == (case, c)) for c in contacts)
        lines.append([f"`{case}`", *map(_cell, cells)])
    return Sheet(["case", *contacts], lines).markdown()


def _cell(found: Counter[str]) -> str:
    more = "".join(f", {found[verdict]} {verdict[0]}" for verdict in UNANSWERED if found[verdict])
    return f"{found['met'] + found['ill-posed']} / {found.total()}{more}"


def _missed(rows: list[Row]) -> Iterator[tuple[str, str, int, str, str]]:
    """One line per case, algorithm and number, those of the same cause together."""
    missed = ((r["case"], r["contact"], _what(r["reason"])) for r in rows if r["verdict"] == "missed")
    for (case, contact, what), number in sorted(Counter(missed).items()):
        yield f"`{case}`", contact, number, what, why_missed(case, what)


def _what(reason: str) -> str:
    """The number that misses first, without its value; how a run was stopped, without where."""
    return re.split(r" is (?=[-\d])|(?<=stopped) after ", reason)[0]
