"""`contactlab cite`: what to cite for a run, a comparison or a scene."""

from __future__ import annotations

import argparse
import json
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from contactlab.commands.common import console, print_json, registry_with
from contactlab.errors import PartError, RequestError, one_line
from contactlab.parts.provenance import LIBRARIES, parts_of, versions
from contactlab.parts.registry import Registry
from contactlab.reports.literature import bibtex, reference, works
from contactlab.reports.sheet import Sheet
from contactlab.scene.fields import kind_at
from contactlab.scene.scene import Scene, load_scene
from contactlab.studies.find_reference import find_reference, matching_reference

PROGRAM = "a laboratory for finite-element contact algorithms"
ALLOWED = "the folder of a run or a comparison, a bundled scene, or a TOML file"


def cite(options: argparse.Namespace) -> int:
    """Print program, scene, parts and reference with the citation of each."""
    cited = cited_in(options.path, registry_with(options.files))
    if options.json:
        print_json({"format": 1, "folder": options.path, **cited})
        return 0
    if options.bibtex:
        print("\n\n".join(_entries(cited)))
        return 0
    out = console()
    say = out.say
    say(f"{cited['program']}\nscene {cited['scene']['name']}: {cited['scene']['source'] or 'names no source'}")
    if known := cited["reference"]:
        say(f"reference {known['name']}: {known['title']}")
    rows = ([part["name"], part["package"], part["cite"]] for part in cited["parts"])
    out.print(Sheet(("part", "package", "cite"), rows))
    for text in cited["literature"].values():
        say(text)
    return 0


def _entries(cited: Mapping[str, Any]) -> Iterator[str]:
    """Entries for the program and all works, and a comment for each source that is no work with a full reference."""
    version = cited["program"].partition(":")[0].removeprefix("contactlab ")
    yield bibtex(
        "contactlab", {"author": "{contactlab developers}", "title": f"contactlab: {PROGRAM}", "version": version}
    )
    sources = {f"{part['name']} ({part['package']})": part["cite"] for part in cited["parts"]}
    sources[f"scene {cited['scene']['name']}"] = cited["scene"]["source"]
    found = works(sources.values())
    yield from (bibtex(key, work) for key, work in found.items())
    for what, source in sources.items():
        for text in filter(None, map(str.strip, source.split(";"))):
            if not text.startswith(tuple(found)):
                yield f"% {what}: {text}"


def cited_in(path: str, registry: Registry) -> dict[str, Any]:
    """Return the citations for the folder of a run or comparison, or a scene. Raises RequestError for any other."""
    scene, used, installed, named = _read(path, registry)
    parts: dict[str, dict[str, str]] = {}
    for key, text in used:
        name, _, package = text.removesuffix(")").partition(" (")
        # none where the part is not installed
        try:
            source = registry.offer(kind_at(Scene, tuple(key.split("."))) or "", name).part.reference
        except PartError:
            source = ""
        parts.setdefault(f"{name} {package}", {"name": name, "package": package, "cite": source})
    libraries = ", ".join(f"{name} {installed[name]}" for name in LIBRARIES[1:] if name in installed)
    own = str(scene.get("source", ""))
    return {
        "program": f"contactlab {installed['contactlab']}: {PROGRAM} (with {libraries})",
        "scene": {"name": scene["name"], "source": own},
        "parts": list(parts.values()),
        "reference": _reference(named, scene, registry),
        "literature": {
            key: reference(work) for key, work in works([own, *(part["cite"] for part in parts.values())]).items()
        },
    }


def _reference(name: str | None, scene: Mapping[str, Any], registry: Registry) -> dict[str, str] | None:
    """Reference of the pressures, or the known solution of the scene."""
    try:
        found = find_reference(name, registry).at(scene) if name else matching_reference(scene, registry)
    except RequestError:  # a file of the user's that has moved
        return {"name": str(name), "title": ""}
    return None if found is None else {"name": found.name, "title": found.title}


def _read(
    path: str, registry: Registry
) -> tuple[Mapping[str, Any], list[tuple[str, str]], Mapping[str, str], str | None]:
    """The scene as data, keys with the parts of all runs, versions, and the name of the reference."""
    folder = Path(path)
    if not folder.is_dir():
        scene = load_scene(path, registry)
        return scene.data, list(parts_of(scene, registry).items()), versions(scene, registry), None
    try:
        if (folder / "table.json").is_file():
            kept = json.loads((folder / "table.json").read_text(encoding="utf-8"))
            rows = [row for row in kept["rows"] if row.get("parts")]
            used = [item for row in rows for item in row["parts"].items()]
            return tomllib.loads(kept["scene"]), used, rows[0], kept["study"].get("reference")
        kept = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        data = tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8"))
        return data, list(kept["parts"].items()), kept["versions"], None
    except FileNotFoundError as error:
        raise RequestError("no run has ended here", where="cite", got=path, allowed=ALLOWED) from error
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise RequestError(
            f"the summary of the run cannot be read: {one_line(error)}", where="cite", got=path, allowed=ALLOWED
        ) from error
