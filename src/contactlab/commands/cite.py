"""`contactlab cite`: what to cite for a run or a comparison."""

from __future__ import annotations

import argparse
import json
import tomllib
from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from contactlab.commands.common import console, print_json, registry_with
from contactlab.errors import PartError, RequestError, one_line
from contactlab.parts.provenance import LIBRARIES
from contactlab.parts.registry import Registry
from contactlab.reports.sheet import Sheet
from contactlab.scene.fields import kind_at
from contactlab.scene.scene import Scene
from contactlab.studies.find_reference import find_reference, matching_reference

PROGRAM = "a laboratory for finite-element contact algorithms"
FOLDERS = "the folder of a run or a comparison"


def cite(options: argparse.Namespace) -> int:
    """Print program, scene, parts and reference with the citation of each."""
    folder = Path(options.path)
    cited = cited_in(folder, registry_with(options.files))
    if options.json:
        print_json({"format": 1, "folder": str(folder), **cited})
        return 0
    out = console()
    say = out.say
    say(f"{cited['program']}\nscene {cited['scene']['name']}: {cited['scene']['source'] or 'names no source'}")
    if reference := cited["reference"]:
        say(f"reference {reference['name']}: {reference['title']}")
    rows = ([part["name"], part["package"], part["cite"]] for part in cited["parts"])
    out.print(Sheet(("part", "package", "cite"), rows))
    for text in cited["literature"].values():
        say(text)
    return 0


def cited_in(folder: Path, registry: Registry) -> dict[str, Any]:
    """Return the citations for the folder of a run or comparison. Raises RequestError for any other."""
    scene, used, versions, reference = _read(folder)
    parts: dict[str, dict[str, str]] = {}
    for key, text in used:
        name, _, package = text.removesuffix(")").partition(" (")
        # none where the part is not installed
        try:
            source = registry.offer(kind_at(Scene, tuple(key.split("."))) or "", name).part.reference
        except PartError:
            source = ""
        parts.setdefault(f"{name} {package}", {"name": name, "package": package, "cite": source})
    libraries = ", ".join(f"{name} {versions[name]}" for name in LIBRARIES[1:] if name in versions)
    own = str(scene.get("source", ""))
    return {
        "program": f"contactlab {versions['contactlab']}: {PROGRAM} (with {libraries})",
        "scene": {"name": scene["name"], "source": own},
        "parts": list(parts.values()),
        "reference": _reference(reference, scene, registry),
        "literature": literature([own, *(part["cite"] for part in parts.values())]),
    }


def literature(texts: Iterable[str]) -> dict[str, str]:
    """Full references of works that texts name by authors and year, in the order of their names."""
    known = tomllib.loads(files("contactlab").joinpath("data/literature.toml").read_text(encoding="utf-8"))
    named = [work.strip() for text in texts for work in text.split(";")]
    return {key: full for key, full in sorted(known.items()) if any(work.startswith(key) for work in named)}


def _reference(name: str | None, scene: Mapping[str, Any], registry: Registry) -> dict[str, str] | None:
    """Reference of the pressures, or the known solution of the scene."""
    try:
        found = find_reference(name, registry).at(scene) if name else matching_reference(scene, registry)
    except RequestError:  # a file of the user's that has moved
        return {"name": str(name), "title": ""}
    return None if found is None else {"name": found.name, "title": found.title}


def _read(folder: Path) -> tuple[dict[str, Any], list[tuple[str, str]], Mapping[str, str], str | None]:
    """The scene as data, keys with the parts of all runs, versions, and the name of the reference."""
    if not any((folder / name).is_file() for name in ("table.json", "summary.json")):
        raise RequestError("no run has ended here", where="cite", got=str(folder), allowed=FOLDERS)
    try:
        if (folder / "table.json").is_file():
            kept = json.loads((folder / "table.json").read_text(encoding="utf-8"))
            rows = [row for row in kept["rows"] if row.get("parts")]
            used = [item for row in rows for item in row["parts"].items()]
            return tomllib.loads(kept["scene"]), used, rows[0], kept["study"].get("reference")
        kept = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        scene = tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8"))
        return scene, list(kept["parts"].items()), kept["versions"], None
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise RequestError(
            f"the summary of the run cannot be read: {one_line(error)}", where="cite", got=str(folder), allowed=FOLDERS
        ) from error
