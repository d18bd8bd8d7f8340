"""The Python of the page on results runs, on a run that is there."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from contactlab.run.simulation import simulate

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "results-in-paraview-and-python.md"
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
LARGEST_PICTURE = 150_000  # bytes: pages load, and a clone stays small


def test_python_of_the_page_runs(
    small_scene: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    simulate(small_scene({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}), tmp_path / "runs" / "rough")
    names: dict[str, Any] = {}
    blocks = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    assert len(blocks) >= 5
    for block in blocks:
        if "vtkmodules" in block:
            pytest.importorskip("vtkmodules.vtkIOHDF", reason="VTK is not installed (extra: test)")
        exec(compile(block, str(PAGE), "exec"), names)


def test_step_columns_are_explained() -> None:
    from contactlab.results.step_columns import step_columns

    text = PAGE.read_text(encoding="utf-8")
    for name in step_columns(["disc.top"], ["contacts.0"]):
        assert name in text or name.rpartition(".")[2] in text, name


@pytest.mark.parametrize("page", ["look-inside-a-contact.md", "find-the-step.md", "results-in-paraview-and-python.md"])
def test_pictures_of_a_page_are_there_and_small(page: str) -> None:
    for picture in re.findall(r"!\[[^\]]+\]\(([^)]+)\)", (DOCS / page).read_text(encoding="utf-8")):
        assert (DOCS / picture).stat().st_size < LARGEST_PICTURE, picture
