"""What the packages of this repository need of others, a line each: `python tools/requirements.py`.

`make demo` installs it while the packages themselves are made ready. The standard library alone is used: nothing is
installed yet.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def requirements() -> Iterator[str]:
    """Requirements of all packages, without their extras and without each other."""
    files = [ROOT / "pyproject.toml", *sorted(ROOT.glob("plugins/*/pyproject.toml"))]
    projects = [tomllib.loads(file.read_text(encoding="utf-8"))["project"] for file in files]
    own = {project["name"] for project in projects}
    needed = dict.fromkeys(line for project in projects for line in project["dependencies"])
    return (line for line in needed if re.split(r"[^\w.-]", line, maxsplit=1)[0] not in own)


if __name__ == "__main__":
    print("\n".join(requirements()))
