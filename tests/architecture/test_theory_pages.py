"""Pages of docs/theory say what the code does: their Python is run, block after block."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from tiers import some

PAGES = sorted((Path(__file__).parents[2] / "docs" / "theory").glob("*.md"))
_BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize(
    "page", some(PAGES, [page for page in PAGES if page.stem != "surfaces"]), ids=lambda page: page.stem
)
def test_the_code_of_a_page_runs(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    names: dict[str, Any] = {"__name__": page.stem}
    blocks = list(_BLOCK.finditer(text))
    assert blocks, f"{page.name} has formulas without calls"
    for block in blocks:
        # blank lines in front make line numbers in a traceback those of the page
        lines = "\n" * text.count("\n", 0, block.start(1))
        exec(compile(lines + block[1], str(page), "exec"), names)


def test_files_that_the_pages_name_are_there() -> None:
    root = Path(__file__).parents[2]
    known = [path.as_posix() for folder in ("src", "plugins", "tests") for path in (root / folder).rglob("*.py")]
    named = {name for page in PAGES for name in re.findall(r"`([\w/]+/\w+\.py)`", page.read_text(encoding="utf-8"))}
    assert named
    assert not [name for name in named if not any(path.endswith(f"/{name}") for path in known)]
