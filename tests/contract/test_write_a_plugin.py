"""What docs/write-a-plugin.md shows is short and needs the contract alone; test_strangers.py installs and runs it."""

from __future__ import annotations

import re

import pytest
from plugin_page import FILES, PAGE

LINES = {"dual_mortar": 25, "contact": 15, "material": 30, "element": 20, "integrator": 15, "cylinder": 35}
"""Most lines of a part, without blank ones."""
USED = {"dataclasses", "typing", "math", "contactlab.api", "contactlab.api.plugin", "contactlab.api.case"}
PARTS = {path: LINES[name] for path in FILES if (name := path.rpartition("/")[2].removesuffix(".py")) in LINES}


def test_the_page_is_short_and_has_its_files() -> None:
    others = {"pyproject.toml", "src/gauss_contact/plugin.py", "tests/test_parts.py"}
    assert FILES.keys() == PARTS.keys() | others
    assert len(PARTS) == len(LINES)
    assert len(PAGE.split()) <= 2300


@pytest.mark.parametrize("path", PARTS)
def test_parts_are_short_and_plain(path: str) -> None:
    """Formulas need no NumPy."""
    assert len([line for line in FILES[path].splitlines() if line.strip()]) <= PARTS[path]
    imported = set(re.findall(r"^(?:from|import) ([\w.]+)", FILES[path], re.MULTILINE))
    assert imported <= (USED if "@formula" in FILES[path] else USED | {"numpy"})
