"""How often each warning is right: the table of docs/warnings.md, from archives of matrices.

    contactlab matrix --full --out runs/full && python benchmarks/studies/warning_rates.py runs/full
    python benchmarks/studies/warning_rates.py runs/full --cells locking      # the cells of one warning
    python benchmarks/studies/warning_rates.py runs/some --sample 12          # 12 random cells of each case, made here

An alarm counts as right if the finished cell misses a known number: a measure of its case, or an invariant other than
the one that the warning reports. Where it misses that one alone, the warning is true and nothing else shows the error.
A cell lacks a warning if it misses a number for which its case accepts the warning, and carries none of those that the
case accepts.
"""

from __future__ import annotations

import argparse
import random
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import case_rows
from filled import filled

from contactlab.jobs.archive import Archive
from contactlab.jobs.driver import Driver
from contactlab.jobs.rows import write_csv
from contactlab.parts.registry import default_registry
from contactlab.reports.sheet import Sheet
from contactlab.verdicts.cell import cell_plan, keep
from contactlab.verdicts.plan import Cell, Request

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "docs" / "warnings.md"
STORED = HERE / "warning_rates.csv"
KEYS = ("code", "alarms", "right", "own", "lacking", "mortars", "nodes")
NODES = "node-on-segment"
SEED = 2005
LIMIT = 60.0
"""Seconds that a run of a sample may take."""


@dataclass
class Judged:
    """A finished cell: the codes that it carries, the measures that it misses, and the codes accepted for each."""

    label: str
    contact: str
    codes: frozenset[str]
    missed: dict[str, frozenset[str]] = field(default_factory=dict)

    def right(self, code: str) -> bool:
        """Whether something is missed beside what the warning reports of itself."""
        return any(accepted != {code} for accepted in self.missed.values())

    @property
    def lacking(self) -> frozenset[str]:
        """Codes of which one should have been there."""
        found = [accepted for accepted in self.missed.values() if accepted and not accepted & self.codes]
        return frozenset().union(*found)


def drawn(number: int) -> list[Cell]:
    """Up to `number` random cells of each case of the full matrix, of those that its case does not refuse."""
    by_case = defaultdict[str, list[Cell]](list)
    for cell in case_rows.applying(case_rows.asked(Request(full=True))).values():
        by_case[cell.name].append(cell)
    draw = random.Random(SEED)
    return [cell for cells in by_case.values() for cell in draw.sample(cells, min(number, len(cells)))]


def make(cells: list[Cell], folder: Path) -> None:
    """Run the cells into the archive of a folder; what it has already is not made again."""
    registry = default_registry()
    folder.mkdir(parents=True, exist_ok=True)
    with Driver(folder, time_limit=LIMIT) as driver:
        for number, result in driver.results(cell_plan(cell, registry) for cell in cells):
            keep(driver.archive, cells[number], result, registry)


def judged(folder: Path) -> Iterator[Judged]:
    """All finished cells of an archive, the newest of each configuration."""
    planned = case_rows.asked(Request(full=True))
    with Archive(folder / "archive.sqlite", write=False) as archive:
        finished = (cell for cell in archive.cells() if cell["status"] == "finished")
        for key, found in case_rows.newest(finished, planned):
            records = [archive.record(run, None) for run in found["runs"]]
            codes = frozenset(code for record in records if record is not None for code in record.warnings)
            told = {i["name"]: i["code"] for r in records if r is not None for i in r.summary.get("invariants", ())}
            yield Judged(", ".join(filter(None, key)), found["contact"], codes, _missed(found, planned[key], told))


def _missed(found: Mapping[str, Any], cell: Cell, told: dict[str, str]) -> dict[str, frozenset[str]]:
    case, setup = cell.case(default_registry()), cell.setup
    accepted = {measure.name: frozenset(measure.codes) for measure in case.measures(setup)}
    names = [m["measure"] for m in found["measures"] if m["verdict"] in ("missed", "silent")]
    return {name: accepted.get(name, frozenset({told[name]} if name in told else ())) for name in names}


def rates(cells: list[Judged]) -> list[dict[str, str]]:
    """A row for each code that some cell carries or lacks."""
    alarms, right, own, lacking = Counter[str](), Counter[str](), Counter[str](), Counter[str]()
    by_kind = Counter[tuple[str, bool]]()
    for cell in cells:
        alarms.update(cell.codes)
        right.update(code for code in cell.codes if cell.right(code))
        own.update(code for code in cell.codes if cell.missed and not cell.right(code))
        lacking.update(cell.lacking)
        by_kind.update((code, cell.contact == NODES) for code in cell.codes)
    return [
        {"code": code, "alarms": str(alarms[code]), "right": str(right[code]), "own": str(own[code]),
         "lacking": str(lacking[code]), "mortars": str(by_kind[code, False]), "nodes": str(by_kind[code, True])}
        for code in sorted({*alarms, *lacking})
    ]  # fmt: skip


def table(rows: list[dict[str, str]]) -> str:
    """The table as Markdown."""
    heads = ("code", "finished cells that carry it", "right", "own number alone", "share right", "lack it")
    lines = []
    for row in rows:
        alarms, right = int(row["alarms"]), int(row["right"])
        share = f"{right / alarms:.0%}" if alarms else ""
        lines.append([f"`{row['code']}`", alarms, right, row["own"], share, row["lacking"]])
    return Sheet(heads, lines).markdown()


def main() -> None:
    """Read archives, print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="of a matrix")
    parser.add_argument("--sample", metavar="N", type=int, help="first run N random cells of each case into the folder")
    parser.add_argument("--cells", metavar="CODE", help="print the cells that carry or lack this warning")
    parser.add_argument("--write", action="store_true", help="write docs/warnings.md and keep the rows")
    options = parser.parse_args()
    if options.sample:
        make(drawn(options.sample), options.folder)
    found = list(judged(options.folder))
    if options.cells:
        for cell in found:
            if options.cells in cell.codes | cell.lacking:
                kind = "lacks" if options.cells in cell.lacking else "right" if cell.right(options.cells) else "false"
                print(f"{kind:6} {cell.label}; missed: {', '.join(cell.missed) or 'nothing'}; {sorted(cell.codes)}")
        return
    rows = rates(found)
    print(f"{len(found)} finished cells\n{table(rows)}")
    if options.write:
        write_csv(STORED, KEYS, rows)
        PAGE.write_text(filled(PAGE, rates=table(rows)), encoding="utf-8")


if __name__ == "__main__":
    main()
