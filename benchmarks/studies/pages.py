"""Pages of measured numbers, from the rows that are kept beside this file: `make pages`.

    python benchmarks/studies/pages.py              # builds them in build/docs, and fills the numbers of pages of docs
    python benchmarks/studies/pages.py runs/full    # first takes rows of cases from the archive of a matrix there
    python benchmarks/studies/pages.py runs/paper   # first draws the paper's figures from the archive of `make paper`
    python benchmarks/studies/pages.py runs/demo    # first takes rows and pictures of the comparison there
    python benchmarks/studies/pages.py runs/accuracy  # first takes the tables of `contactlab compare accuracy`
    python benchmarks/studies/pages.py --check      # writes nothing; exit status 1 if numbers in docs are stale

Pages that hold nothing but numbers are built and not committed; `make site` builds them, too. Numbers in the prose of
matrix.md and of the front page are filled in where they stand. A folder may hold some of the cases: the others stay
as they are kept.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
DOCS, BUILT_DOCS = ROOT / "docs", ROOT / "build" / "docs"
sys.path[:0] = [str(HERE / place) for place in (".", "paper", "..", "../kernels")]

import accuracy_page  # noqa: E402
import baselines  # noqa: E402
import cases_page  # noqa: E402
import demo_page  # noqa: E402
import full_page  # noqa: E402
import kept_runs  # noqa: E402
import make  # noqa: E402
import matrix_page  # noqa: E402
import methods  # noqa: E402
import references_page  # noqa: E402

from contactlab.jobs.archive import FILE  # noqa: E402


def paper() -> str:
    """Numbers of the paper's figures, as `make paper` kept them beside the pictures, in the text of its page."""
    return make.filled(make.PAGE.read_text(), json.loads(make.NUMBERS.read_text()))


BUILT: dict[str, Callable[[], str]] = {
    "cases.md": lambda: cases_page.page(cases_page.stored()),
    "full-matrix.md": lambda: full_page.page(full_page.stored()),
    "paper.md": paper,
    "performance-over-versions.md": lambda: baselines.page(baselines.load()),
    "references.md": lambda: references_page.page(references_page.stored()),
}
"""Pages that are built, and what they hold."""
FILLED: dict[str, Callable[[], str]] = {
    "accuracy.md": accuracy_page.page,
    "matrix.md": lambda: matrix_page.page(cases_page.stored()),
    "methods.md": lambda: methods.page(methods.stored(), cases_page.stored()),
    "../README.md": demo_page.page,
}
"""Pages of docs with numbers in their prose, and what they must be."""


def build(folder: Path = BUILT_DOCS) -> None:
    """Write all pages that are built."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, made in BUILT.items():
        (folder / name).write_text(made(), encoding="utf-8")


def stale() -> list[str]:
    """Pages of docs that are not what their rows say, and pictures that were drawn with other rows."""
    pages = [name for name, made in FILLED.items() if (DOCS / name).read_text(encoding="utf-8") != made()]
    return [*pages, *(f"pictures/{name}" for name in demo_page.stale_pictures())]


def _keep(folder: Path) -> None:
    """Take rows from a results folder: a comparison's for the front page, those of a matrix for its pages."""
    if (folder / "winners.csv").exists():
        accuracy_page.keep(folder)
        return
    if (folder / "study.toml").exists():
        demo_page.keep(folder)
        return
    archive = folder / FILE
    if kept_runs.held(folder):
        make.keep(folder)
    rows = full_page.rows_of(archive)
    if any(row["slave"] == "exchanged" or row["variant"] for row in rows):  # the quick matrix has none
        full_page.keep(rows)
    cases_page.keep(cases_page.rows_of(archive))


def main(words: list[str]) -> int:
    """Write all pages, or report which are stale."""
    if words == ["--check"]:
        found = stale()
        print("\n".join(f"docs/{name} is stale: make pages" for name in found) or "all pages are what their rows say")
        return 1 if found else 0
    for folder in map(Path, words):
        _keep(folder)
    for name, made in FILLED.items():
        (DOCS / name).write_text(made(), encoding="utf-8")
    build()
    print(f"built {len(BUILT)} pages in {BUILT_DOCS.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
