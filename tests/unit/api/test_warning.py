"""Warnings of a run: each kind and key once, at its worst, the same after a restart, and every code in the docs."""

from __future__ import annotations

import ast
import math
import re
from pathlib import Path

from contactlab.api import RunWarning, Warnings

ROOT = Path(__file__).parents[3]
MAKERS = {"Invariant": 1, "RunWarning": 0, "needed": 0, "_slower": 2, "advice": 0}
"""Functions that make a warning, and the place of the code among their arguments."""


def warned(value: float, key: str = "time.step") -> RunWarning:
    return RunWarning("some-code", value, 1.0, key, f"it is {value}; try less")


def test_each_code_and_key_is_kept_once_at_its_worst() -> None:
    warnings = Warnings()
    for value in (2.0, 5.0, 3.0):
        warnings.add(warned(value))
    warnings.add(warned(1.5, "time.end"))
    assert [(w.key, w.value) for w in warnings] == [("time.step", 5.0), ("time.end", 1.5)]


def test_a_number_that_is_none_is_worse_than_any() -> None:
    warnings = Warnings()
    for value in (2.0, math.nan, 3.0):
        warnings.add(warned(value))
    (kept,) = warnings
    assert math.isnan(kept.value)


def test_each_is_told_once() -> None:
    warnings = Warnings()
    warnings.add(warned(2.0))
    assert [w.value for w in warnings.untold()] == [2.0]
    warnings.add(warned(3.0))
    assert warnings.untold() == []


def test_a_run_taken_up_again_tells_nothing_twice() -> None:
    warnings = Warnings()
    warnings.restore([warned(2.0)])
    warnings.add(warned(2.0))
    assert warnings.untold() == []
    assert [w.value for w in warnings] == [2.0]


def test_a_record_survives_its_file() -> None:
    assert RunWarning.from_data(warned(2.0).as_data()) == warned(2.0)
    assert math.isnan(RunWarning.from_data(warned(2.0).as_data() | {"value": None}).value)


def codes_in(path: Path) -> set[str]:
    """Codes of all warnings that a file makes."""
    found: set[str] = set()
    text = path.read_text()
    if not any(f"{name}(" in text for name in MAKERS):
        return found
    for node in ast.walk(ast.parse(text)):
        name = getattr(node.func, "id", getattr(node.func, "attr", "")) if isinstance(node, ast.Call) else ""
        if isinstance(node, ast.Call) and name in MAKERS and node.args:
            code = node.args[MAKERS[name]]
            if isinstance(code, ast.Constant):
                found.add(str(code.value))
    return found


def test_the_docs_list_every_code_and_no_other() -> None:
    sources = [*(ROOT / "src").rglob("*.py"), *(ROOT / "plugins").rglob("src/**/*.py")]
    made = set().union(*map(codes_in, sources))
    listed = re.findall(r"^\| `([a-z-]+)` \|", (ROOT / "docs" / "warnings.md").read_text(), re.M)
    assert set(listed) == made  # a code stands in the table of texts and in the table of rates
