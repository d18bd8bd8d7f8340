"""Packages of others that nightly runs install: do they load, and do their parts pass their checks?

    python tools/outside_plugins.py [LIST]

takes the packages of tests/outside_plugins.txt, which must be installed, and puts `contactlab check` to each. Exit
status 1 where one of them fails, after all were tried.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from contactlab.cli import main as contactlab

LIST = Path(__file__).parents[1] / "tests" / "outside_plugins.txt"


def packages(text: str) -> Iterator[str]:
    """Names of the packages in a list of requirements, without versions and remarks."""
    for line in text.splitlines():
        if name := re.match(r"[A-Za-z0-9][\w.-]*", line.partition("#")[0].strip()):
            yield name[0]


def failing(names: list[str], check: Callable[[list[str]], int] = contactlab) -> list[str]:
    """Those of the packages whose check did not end well."""
    return [name for name in names if check(["check", name]) != 0]


def main(file: Path) -> int:
    """Check all packages of the list and name those that failed."""
    names = list(packages(file.read_text(encoding="utf-8")))
    wrong = failing(names)
    print(f"{len(names)} packages of others" + (f", failed: {', '.join(wrong)}" if wrong else ", none failed"))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else LIST))
