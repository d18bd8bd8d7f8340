"""data/known_parts.json: which package of this repository brings which part, for errors that name what to install.

    python tests/architecture/known_parts.py

writes it from the installed packages; `test_known_parts.py` holds it.
"""

from __future__ import annotations

import json
from pathlib import Path

from contactlab.parts.registry import default_registry

ROOT = Path(__file__).parents[2]
FILE = ROOT / "src" / "contactlab" / "data" / "known_parts.json"


def known_parts() -> dict[str, list[str]]:
    """Names of the parts of each plugin in this repository."""
    own = {path.name for path in (ROOT / "plugins").glob("contactlab-*")}
    found: dict[str, list[str]] = {}
    for offer in default_registry().parts():
        package, name = offer.origin.distribution, offer.part.name
        if package in own and name not in found.setdefault(package, []):
            found[package].append(name)
    return dict(sorted(found.items()))


if __name__ == "__main__":
    FILE.write_text(json.dumps(known_parts(), indent=1) + "\n", encoding="utf-8")
