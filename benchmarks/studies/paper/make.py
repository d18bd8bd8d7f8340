"""All figures and numbers of docs/paper.md: `make paper`, or some of them: `python make.py f07 f14`.

Each figure leaves its pictures and its numbers in docs/paper; the page is page.md here with the numbers put in.
"""

from __future__ import annotations

import importlib
import json
import re
import sys
from time import process_time

from common import PICTURES, ROOT, Numbers

sys.path.append(str(ROOT / "benchmarks" / "studies"))
import pictures

MODULES = ("test1", "test2", "test3", "cases")
PAGE = ROOT / "benchmarks" / "studies" / "paper" / "page.md"
NUMBERS = PICTURES / "numbers.json"


def main(wanted: list[str]) -> int:
    """Make the wanted figures, or all; returns an exit status."""
    figures = {name: figure for module in MODULES for name, figure in importlib.import_module(module).FIGURES.items()}
    unknown = [name for name in wanted if name not in figures]
    if unknown:
        print(f"got {', '.join(unknown)}, allowed: {', '.join(figures)}")
        return 2
    numbers: dict[str, Numbers] = {}
    for name in wanted or figures:
        began = process_time()
        made = figures[name]()
        numbers = json.loads(NUMBERS.read_text()) if NUMBERS.exists() else {}
        numbers[name] = made
        print(f"{name}: {process_time() - began:.0f} s of processor time", flush=True)
        NUMBERS.write_text(json.dumps(numbers, indent=1, sort_keys=True) + "\n")
        pictures.keep(pictures.of_figure(name))
    (ROOT / "docs" / "paper.md").write_text(filled(PAGE.read_text(), numbers))
    return 0


def filled(page: str, numbers: dict[str, Numbers]) -> str:
    """The page with each {figure.number} replaced; lists become lines."""

    def value(match: re.Match[str]) -> str:
        found = numbers.get(match[1], {}).get(match[2], "(not measured)")
        return "\n".join(found) if isinstance(found, list) else str(found)

    return re.sub(r"\{(\w+)\.(\w+)\}", value, page)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
