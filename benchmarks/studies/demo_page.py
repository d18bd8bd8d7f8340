"""The front page's pictures and numbers, from the comparison that `make demo` runs.

    make demo && make pages DEMO=runs/demo

takes the rows that the README quotes from the archive of the comparison, and the report's pictures; rows are kept in
demo.csv. Each picture carries the hash of the rows and of the reference that it was drawn with: a test finds one
of another run, or with another reference.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from filled import filled
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from contactlab.jobs.archive import FILE, Archive
from contactlab.jobs.rows import Row, read_csv, write_csv
from contactlab.reports.sheet import Sheet
from contactlab.studies.reference import bundled

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
STORED, README, PICTURES = HERE / "demo.csv", ROOT / "README.md", ROOT / "docs" / "pictures"
DRAWN = {"pressure.png": "comparison.png", "error-against-cost.png": "error-against-cost.png"}
"""Pictures of the report, and what they are called here."""
COLUMNS = ("algorithm", "slave", "level", "status", "pressure_error", "cpu_s", "steps")
REFERENCE = [bundled()["disc-on-block-deep"].with_suffix(suffix) for suffix in (".json", ".csv")]
"""What errors are measured against."""
MARK = "rows"


def rows_of(archive: Path) -> list[Row]:
    """The newest row of each algorithm, slave and level in the archive of a comparison."""
    found: dict[tuple[str, ...], Row] = {}
    with Archive(archive, write=False) as kept:
        for row in kept.rows():
            values = {**row["values"], **{name: row[name] for name in ("algorithm", "slave", "level", "status")}}
            own = {name: "" if values.get(name) is None else str(values[name]) for name in COLUMNS}
            found.setdefault((own["algorithm"], own["slave"], own["level"]), own)
    return list(found.values())


def keep(folder: Path) -> None:
    """Take rows and pictures of a comparison."""
    write_csv(STORED, COLUMNS, rows_of(folder / FILE))
    for name, own in DRAWN.items():
        told = PngInfo()
        told.add_text(MARK, hash_of_rows())
        with Image.open(folder / name) as picture:
            picture.save(PICTURES / own, pnginfo=told, optimize=True)


def hash_of_rows() -> str:
    """Of what is kept, and of the reference that pictures show with its uncertainty."""
    shown = [STORED.read_text(encoding="utf-8"), *(path.read_text(encoding="utf-8") for path in REFERENCE)]
    return hashlib.sha256("".join(shown).encode()).hexdigest()


def drawn_with(picture: Path) -> str:
    """Hash of the rows that a picture was drawn with; empty where it says none."""
    with Image.open(picture) as found:
        found.load()
        return str(getattr(found, "text", {}).get(MARK, ""))


def stale_pictures() -> list[str]:
    """Pictures that belong to other rows."""
    return [own for own in DRAWN.values() if drawn_with(PICTURES / own) != hash_of_rows()]


def page() -> str:
    """README.md with the numbers of the kept rows between its two marks."""
    return filled(README, **{"numbers of make demo": _said(read_csv(STORED))})


def _said(rows: list[Row]) -> str:
    """Errors of the finest level for either slave, and who did not finish."""
    levels = sorted({int(row["level"]) for row in rows})
    lines = [
        [name, *(" / ".join(_error(_row(rows, name, slave, level)) for level in levels) for slave in ("disc", "block"))]
        for name in dict.fromkeys(row["algorithm"] for row in rows)
    ]
    head = f"pressure error, level {' / '.join(map(str, levels))}", "disc as slave", "block as slave"
    finest = [row for row in rows if row["level"] == str(levels[-1]) and row["status"] == "finished"]
    seconds = sorted(float(row["cpu_s"]) for row in finest)
    took = f"A finished run of level {levels[-1]} took {seconds[0]:.1f} to {seconds[-1]:.1f} CPU seconds."
    return f"\n{Sheet(head, lines).markdown()}\n\n{took}\n"


def _row(rows: list[Row], algorithm: str, slave: str, level: int) -> Row:
    (found,) = [r for r in rows if (r["algorithm"], r["slave"], r["level"]) == (algorithm, slave, str(level))]
    return found


def _error(row: Row) -> str:
    return row["status"] if row["status"] != "finished" else f"{100.0 * float(row['pressure_error']):.2g} %"
