"""All pages that hold measured numbers, written from what is kept: `make pages`.

    python benchmarks/studies/pages.py              # from the rows that are kept beside this file
    python benchmarks/studies/pages.py runs/full    # first takes rows of cases from the archive of a matrix there
    python benchmarks/studies/pages.py runs/paper   # first draws the paper's figures from the archive of `make paper`
    python benchmarks/studies/pages.py runs/demo    # first takes rows and pictures of the comparison there
    python benchmarks/studies/pages.py --check      # writes nothing; exit status 1 where a page is stale

docs/cases.md, full-matrix.md, numbers of matrix.md, hard-cases.md, statics-cases.md and friction.md come from archives
of `contactlab matrix` (what studies add on finer meshes is marked there); docs/paper.md and its figures from that of
`make paper`; the front page has pictures and numbers of `make demo`. A folder may hold some of the cases: the others
stay as they are kept.
Numbers in prose are marks in a page's source, filled like tables.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
sys.path[:0] = [str(HERE), str(HERE / "paper")]

import bundled_scenes  # noqa: E402
import case_rows  # noqa: E402
import cases_page  # noqa: E402
import demo_page  # noqa: E402
import effect_costs  # noqa: E402
import foreseen_prices  # noqa: E402
import friction  # noqa: E402
import full_page  # noqa: E402
import hard_cases  # noqa: E402
import kept_runs  # noqa: E402
import make  # noqa: E402
import matrix_page  # noqa: E402
import references_page  # noqa: E402
import statics_cases  # noqa: E402


def cases() -> str:
    """docs/cases.md."""
    return cases_page.page(cases_page.stored())


def full() -> str:
    """docs/full-matrix.md."""
    return full_page.page(full_page.stored())


def matrix() -> str:
    """docs/matrix.md."""
    return matrix_page.page(cases_page.stored())


def hard() -> str:
    """docs/hard-cases.md."""
    return hard_cases.page(hard_cases.stored())


def statics() -> str:
    """docs/statics-cases.md."""
    return statics_cases.page(statics_cases.stored())


def rubbing() -> str:
    """docs/friction.md."""
    return friction.page(friction.stored())


def paper() -> str:
    """docs/paper.md: numbers of its figures, as `make paper` kept them beside the pictures."""
    return make.filled(make.PAGE.read_text(), json.loads(make.NUMBERS.read_text()))


def scenes() -> str:
    """docs/bundled-scenes.md."""
    return bundled_scenes.page(bundled_scenes.stored())


def prices() -> str:
    """docs/prices.md."""
    return foreseen_prices.page(foreseen_prices.stored())


def effects() -> str:
    """docs/effect-costs.md."""
    return effect_costs.page(effect_costs.stored())


def references() -> str:
    """docs/references.md."""
    return references_page.page(references_page.stored())


PAGES: dict[str, Callable[[], str]] = {
    "cases.md": cases, "full-matrix.md": full, "matrix.md": matrix, "hard-cases.md": hard, "statics-cases.md": statics,
    "friction.md": rubbing, "paper.md": paper, "bundled-scenes.md": scenes,
    "effect-costs.md": effects,
    "prices.md": prices,
    "references.md": references,
    "../README.md": demo_page.page,
}  # fmt: skip
"""Every page, seen from docs, and what it must be."""


def stale() -> list[str]:
    """Pages that are not what their rows say, and pictures that were drawn with other rows."""
    pages = [name for name, made in PAGES.items() if (DOCS / name).read_text(encoding="utf-8") != made()]
    return [*pages, *(f"pictures/{name}" for name in demo_page.stale_pictures())]


def _keep(folder: Path) -> None:
    """Take rows from a results folder: a comparison's for the front page, those of a matrix for its pages."""
    if (folder / "study.toml").exists():
        demo_page.keep(folder)
        return
    archive = folder / cases_page.FILE
    if kept_runs.held(folder):
        make.keep(folder)
    rows = full_page.rows_of(archive)
    if any(row["slave"] == "exchanged" or row["variant"] for row in rows):  # the quick matrix has none
        full_page.keep(rows)
    cases_page.keep(cases_page.rows_of(archive))
    case_rows.keep(archive)


def main(words: list[str]) -> int:
    """Write all pages, or say which are stale."""
    if words == ["--check"]:
        found = stale()
        print("\n".join(f"docs/{name} is stale: make pages" for name in found) or "all pages are what their rows say")
        return 1 if found else 0
    for folder in map(Path, words):
        _keep(folder)
    for name, made in PAGES.items():
        (DOCS / name).write_text(made(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
