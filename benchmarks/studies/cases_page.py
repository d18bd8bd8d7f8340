"""The page of every case with its numbers, the algorithms side by side, from rows that are kept in cases.csv.

`make pages CASES=FOLDER` takes them from the archive of a matrix (the newest of each configuration).
"""

from __future__ import annotations

from pathlib import Path

import case_rows

from contactlab.jobs.archive import CHOICES
from contactlab.jobs.rows import Row, read_csv, write_csv
from contactlab.parts.registry import default_registry
from contactlab.reports.sheet import Sheet
from contactlab.verdicts.plan import Request

HERE = Path(__file__).parent
ORDER = ("silent", "failed", "missed", "not-judged", "ill-posed", "met")
STORED = HERE / "cases.csv"

HEAD = """# Every case, with its numbers

Written by `make pages` from the archive of `contactlab matrix`. [Cases against algorithms](matrix.md) explains the
verdicts, and each case is described in its file in `plugins/contactlab-cases`. Numbers outside their
allowed range are bold. {counts}

What the benchmarks of Di Stasio et al. 2019 for explicit dynamics with impacts ask of a scheme is asked by cases of
other scenes, with answers of their own:

| asked | cases |
|---|---|
| energy at impact | `bouncing-bar`, `bar-between-walls`, `two-bars`, `dropped-block`, `chatter`, `rocking-block` |
| angular momentum | `spinning-pair`, `oblique-discs`, `rolling-disc` |
| what is not linear | `vertex-to-vertex` (large turns), `taylor-bar` (plastic flow), `spring-friction` |
"""


def rows_of(archive: Path) -> list[Row]:
    """The newest cell of each configuration of the quick matrix, one row per measure; an archive may hold more."""
    return case_rows.rows_of(archive, case_rows.asked(Request()))


def keep(rows: list[Row]) -> None:
    """Put rows into cases.csv, in place of those of the same cells."""
    write_csv(STORED, case_rows.COLUMNS, case_rows.merged(stored(), rows, case_rows.asked(Request())))


def stored() -> list[Row]:
    """The rows that are kept."""
    return read_csv(STORED)


def page(rows: list[Row]) -> str:
    """The page of these rows."""
    cells = {tuple(row[name] for name in CHOICES): row["cell"] for row in rows}
    counts = ", ".join(f"{list(cells.values()).count(v)} {v}" for v in ORDER if v in cells.values() or v == "silent")
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
    if not rows:
        return ["Not run yet."]
    contacts = list(dict.fromkeys(row["contact"] for row in rows))
    lines = []
    for name in dict.fromkeys(row["measure"] for row in rows):
        own = {row["contact"]: row for row in rows if row["measure"] == name}
        first = next(iter(own.values()))
        unit = f" [{first['unit']}]" if first["unit"] else ""
        cells = [shown(own[contact]) if contact in own else "" for contact in contacts]
        lines.append([f"{name}{unit}", allowed(first), *cells])
    told = {row["contact"]: row for row in rows if row["cell"] in ("silent", "failed", "not-judged", "ill-posed")}
    notes = [f"- {contact}, {row['cell']}: {row['reason'][:300]}" for contact, row in told.items()]
    table = Sheet(["measure", "allowed", *contacts], lines).markdown()
    return [table, *([""] if notes else []), *notes]


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
    if not most:
        return f">= {least}"
    return f"+-{most}" if least == f"-{most}" else f"{least} to {most}"
