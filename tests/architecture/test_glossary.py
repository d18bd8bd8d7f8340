"""The glossary has every word that the docstrings of the contract use beyond plain English, and names that exist."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "glossary.md"
PLAIN = Path(__file__).with_name("plain_words.txt")
COLUMNS = 6
FEWEST = 40


def rows() -> list[list[str]]:
    """Cells of every term."""
    found = []
    for line in PAGE.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and cells[0] != "term" and not set(cells[0]) <= {"-"}:
            found.append(cells)
    return found


def docstrings() -> Iterator[tuple[str, str]]:
    """Place and text of every public docstring of the contract, without what it quotes from code."""
    for path in sorted((ROOT / "src" / "contactlab" / "api").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                name = getattr(node, "name", path.stem)
                text = ast.get_docstring(node)
                if text and not name.startswith("_"):
                    yield f"{path.stem}.{name}", re.sub(r"`[^`]*`", " ", text)


def words(text: str) -> set[str]:
    return {word.lower() for word in re.findall(r"[A-Za-z][a-z]{2,}", text)}


def identifiers() -> set[str]:
    """Every name in the sources of core and plugins, modules included."""
    found = set()
    for path in (*(ROOT / "src").rglob("*.py"), *(ROOT / "plugins").glob("*/src/**/*.py")):
        found |= {*path.relative_to(ROOT).with_suffix("").parts, *re.findall(r"\w+", path.read_text())}
    return found


def test_there_are_terms_enough_and_every_cell_is_filled() -> None:
    table = rows()
    assert len(table) >= FEWEST
    assert not [cells for cells in table if len(cells) != COLUMNS or not all(cells)]
    terms = [cells[0] for cells in table]
    assert len(set(terms)) == len(terms)


def test_names_in_code_exist() -> None:
    known = identifiers()
    missing = {name for cells in rows() for name in re.findall(r"`(\w+)`", cells[4]) if name not in known}
    assert not missing


def test_every_word_of_the_contract_is_plain_or_explained() -> None:
    explained = words(" ".join(cells[0] for cells in rows()))
    explained |= {f"{word}{ending}" for word in explained for ending in ("s", "es", "ed", "ing")}
    plain = set(PLAIN.read_text().split())
    unknown = {word: place for place, text in docstrings() for word in words(text) - explained - plain}
    assert not unknown, f"explain these in docs/glossary.md, or add plain English to {PLAIN.name}: {unknown}"


INVENTED = ["slopes", "windows", "exploded", "zygote", "rehearsal", "pace", "eased", "lanes", "bill"]


@pytest.mark.parametrize("word", INVENTED)
def test_words_that_were_invented_are_not_plain(word: str) -> None:
    assert word not in PLAIN.read_text().split()
