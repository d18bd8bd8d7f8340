"""Write one version everywhere it stands.

    python tools/release.py 0.2.0

It stands in `src/contactlab/__init__.py`, from where the core's package takes it; plugins are released with the core.
What the changelog has under "not released" becomes that version, of today.
"""

from __future__ import annotations

import re
import sys
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).parents[1]
CORE = ROOT / "src" / "contactlab" / "__init__.py"


def main(version: str) -> None:
    """Write it, and the range of versions that core and plugins accept of each other."""
    if not re.fullmatch(r"\d+\.\d+\.\d+((a|b|rc)\d+)?", version):
        raise SystemExit(f"got {version}, allowed: a version such as 0.2.0 or 0.2.0rc1")
    major, minor = version.split(".")[:2]
    accepted = f">={major}.{minor},<{major}.{int(minor) + 1}"
    _replace(CORE, r'__version__ = "[^"]*"', f'__version__ = "{version}"')
    _replace(ROOT / "CITATION.cff", r"(?m)^version: .*$", f"version: {version}")
    today = datetime.now(UTC).date().isoformat()
    _replace(ROOT / "docs" / "CHANGELOG.md", r"(?m)^## \S+ \(not released\)$", f"## {version} ({today})")
    for file in (ROOT / "pyproject.toml", *sorted(ROOT.glob("plugins/*/pyproject.toml"))):
        text = file.read_text(encoding="utf-8")
        text = re.sub(r'"(contactlab[a-z-]*)>=[^"]*"', rf'"\1{accepted}"', text)
        text = re.sub(r'(?m)^version = "[^"]*"$', f'version = "{version}"', text)
        file.write_text(text, encoding="utf-8")


def _replace(file: Path, pattern: str, text: str) -> None:
    file.write_text(re.sub(pattern, text, file.read_text(encoding="utf-8"), count=1), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:2])
