"""All figures and numbers of the paper's page: `make paper`, or some of them: `python make.py f07 f14`.

Runs go into the archive in runs/paper, and what is there is not run again. Each figure leaves its pictures and its
numbers in docs/paper; the page is page.md here with the numbers put in. `make pages CASES=FOLDER` draws all figures
from such an archive and runs nothing.
"""

from __future__ import annotations

import importlib
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from time import process_time

from common import PICTURES, ROOT, Numbers
from kept_runs import use

MODULES = ("test1", "test2", "test3")
PAGE = ROOT / "benchmarks" / "studies" / "paper" / "page.md"
NUMBERS = PICTURES / "numbers.json"


def main(wanted: list[str]) -> int:
    """Make the wanted figures, or all; returns an exit status."""
    figures = known()
    unknown = [name for name in wanted if name not in figures]
    if unknown:
        print(f"got {', '.join(unknown)}, allowed: {', '.join(figures)}")
        return 2
    for name in wanted or figures:
        began = process_time()
        draw(name, figures[name])
        print(f"{name}: {process_time() - began:.0f} s of processor time", flush=True)
    return 0


def known() -> dict[str, Callable[[], Numbers]]:
    """Every figure by its name."""
    return {name: figure for module in MODULES for name, figure in importlib.import_module(module).FIGURES.items()}


def draw(name: str, figure: Callable[[], Numbers]) -> None:
    """Make the pictures of a figure, and keep its numbers."""
    made = figure()
    numbers = json.loads(NUMBERS.read_text()) if NUMBERS.exists() else {}
    numbers[name] = made
    NUMBERS.write_text(json.dumps(numbers, indent=1, sort_keys=True) + "\n")


def keep(folder: Path) -> None:
    """Draw all figures from the archive of a folder. Raises LookupError where it lacks a run."""
    use(folder, only_kept=True)
    for name, figure in known().items():
        draw(name, figure)


def filled(page: str, numbers: dict[str, Numbers]) -> str:
    """The page with each {figure.number} replaced; lists become lines."""

    def value(match: re.Match[str]) -> str:
        found = numbers.get(match[1], {}).get(match[2], "(not measured)")
        return "\n".join(found) if isinstance(found, list) else str(found)

    return re.sub(r"\{(\w+)\.(\w+)\}", value, page)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
