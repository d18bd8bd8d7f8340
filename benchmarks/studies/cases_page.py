"""docs/cases.md from a matrix: every case with its numbers, the algorithms side by side.

    contactlab matrix --out runs/cases && python benchmarks/studies/cases_page.py runs/cases

The rows come from the archive in that folder (the newest of each configuration) and are kept in cases.csv; without a
folder the page is written anew from there. A test compares page and rows.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import kept_rows
from kept_rows import Row

from contactlab.archive.archive import CHOICES, FILE, Archive
from contactlab.matrix.plan import Request, plan
from contactlab.parts.registry import default_registry

HERE = Path(__file__).parent
STORED, PAGE = HERE / "cases.csv", HERE.parents[1] / "docs" / "cases.md"
COLUMNS = (*CHOICES, "verdict", "measure", "role", "value", "least", "most", "unit", "cell", "reason")


HEAD = """# Every case, with its numbers

Written by `make pages` from the archive of `contactlab matrix`. [Cases against algorithms](matrix.md) explains the
verdicts, and each case is described in its file in `plugins/contactlab-cases`. Numbers outside their
allowed range are bold. {counts}
"""


def rows_of(archive: Path) -> list[Row]:
    """The newest cell of each configuration of the quick matrix, one row per measure; an archive may hold more."""
    quick = {tuple(cell.choices.values()) for cell in plan(Request(), default_registry())}
    seen: set[tuple[str, ...]] = set()
    found: list[Row] = []
    with Archive(archive, write=False) as kept:
        for cell in kept.cells():
            head = {name: str(cell[name]) for name in CHOICES}
            key = tuple(head.values())
            if key not in quick or key in seen or cell["verdict"] == "not-applicable":
                continue
            seen.add(key)
            ends = {"cell": cell["verdict"], "reason": (cell["reason"] or "").splitlines()[0] if cell["reason"] else ""}
            for m in cell["measures"]:
                values = {name: short(m[name]) for name in ("value", "least", "most")}
                own = {name: m[name] for name in ("verdict", "measure", "role", "unit")}
                found.append({**head, **own, **values, **ends})
    return found


def short(value: float | None) -> str:
    """A number as the page shows it; nothing for a bound that is none."""
    return "" if value is None or math.isinf(value) else "nan" if math.isnan(value) else f"{value:.4g}"


def keep(rows: list[Row]) -> None:
    """Put rows into cases.csv."""
    kept_rows.write(STORED, COLUMNS, rows)


def stored() -> list[Row]:
    """The rows that are kept."""
    return kept_rows.read(STORED)


def page(rows: list[Row]) -> str:
    """docs/cases.md."""
    cells = {tuple(row[name] for name in CHOICES): row["cell"] for row in rows}
    order = ("silent", "failed", "missed", "not-judged", "ill-posed", "met")
    counts = ", ".join(f"{list(cells.values()).count(v)} {v}" for v in order if v in cells.values() or v == "silent")
    text = [HEAD.format(counts=f"Of {len(cells)} cells: {counts}.")]
    registry = default_registry()
    for name in dict.fromkeys(row["case"] for row in rows):
        part = registry.part_class("case", name)
        title, source = (getattr(part, what) for what in ("title", "source"))
        text += [f"\n## {title[0].upper()}{title[1:]}\n", f"`{name}`, after {source}.\n"]
        text += table([row for row in rows if row["case"] == name])
    return "\n".join(text) + "\n"


def table(rows: list[Row]) -> list[str]:
    """One line per measure, one column per algorithm; the reason of what failed or is silent below."""
    contacts = list(dict.fromkeys(row["contact"] for row in rows))
    lines = ["| measure | allowed | " + " | ".join(contacts) + " |", "|---" * (len(contacts) + 2) + "|"]
    for name in dict.fromkeys(row["measure"] for row in rows):
        own = {row["contact"]: row for row in rows if row["measure"] == name}
        first = next(iter(own.values()))
        unit = f" [{first['unit']}]" if first["unit"] else ""
        cells = [shown(own[contact]) if contact in own else "" for contact in contacts]
        lines.append(f"| {name}{unit} | {allowed(first)} | " + " | ".join(cells) + " |")
    told = {row["contact"]: row for row in rows if row["cell"] in ("silent", "failed", "not-judged", "ill-posed")}
    notes = [f"- {contact}, {row['cell']}: {row['reason'][:300]}" for contact, row in told.items()]
    return [*lines, *([""] if notes else []), *notes]


def shown(row: Row) -> str:
    """A value with its verdict."""
    if row["verdict"] in ("met", "failed", "not-judged"):
        return "" if row["value"] == "nan" else row["value"]
    return f"**{row['value']}** {row['verdict']}"


def allowed(row: Row) -> str:
    """The bounds in words."""
    least, most = row["least"], row["most"]
    if row["role"] == "reported":
        return "reported"
    if not least:
        return f"<= {most}"
    return f"+-{most}" if least == f"-{most}" else f"{least} to {most}"


def main(words: list[str]) -> None:
    """Take rows from an archive where one is named, and write the page."""
    if words:
        keep(rows_of(Path(words[0]) / FILE))
    PAGE.write_text(page(stored()), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
