"""docs/troubleshooting.md says what the program says."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest


def _tool() -> ModuleType:
    specification = importlib.util.spec_from_file_location(
        "wrong_requests", Path(__file__).with_name("wrong_requests.py")
    )
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["wrong_requests"] = module
    specification.loader.exec_module(module)
    return module


TOOL = _tool()
PAGE = TOOL.PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("wrong", TOOL.REQUESTS, ids=lambda wrong: wrong.title)
def test_an_answer_is_as_the_page_says(wrong: object) -> None:
    """Exit status 2, no traceback; where, what was got, and what is allowed or to be tried."""
    said = TOOL.answer(wrong)
    assert said in PAGE, "run python tests/docs/wrong_requests.py"
    assert "Traceback" not in said
    assert said.startswith("contactlab: ")
    assert re.search(r"^  (allowed|try|got) ", said, re.MULTILINE)


def test_there_are_thirty_and_ten_about_meshes() -> None:
    assert len(TOOL.REQUESTS) >= 30
    assert len(TOOL.MESHES) >= 10
    titles = re.findall(r"^### (.*)$", PAGE, re.MULTILINE)
    assert titles == [wrong.title for wrong in TOOL.REQUESTS]
