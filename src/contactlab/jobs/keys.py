"""Identity of a run: its scene, the files that it names, the sources it goes through, and the machine."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from contactlab.api import Job
from contactlab.parts.provenance import part_specs
from contactlab.parts.registry import Registry, split_spec
from contactlab.scene.scene import Scene

CORE = Path(__file__).parents[1]


def row_key(scene: Scene, choices: str) -> str:
    """Hash of a row of a comparison: its scene with all defaults, the files it names, the sources it goes through."""
    return _hash([scene.toml(), *_files(scene.data), choices, *sources(_packages(scene.registry, part_specs(scene)))])


def run_key(job: Job, scene: Scene) -> str:
    """Hash of a job, its scene with all defaults, the files it names, the sources of the core and of the parts used."""
    asked = [list(job.watch), job.work, job.guards, job.fields, job.curves, *([job.means] if job.means else [])]
    told = json.dumps(asked, sort_keys=True, default=str)
    return _hash([scene.toml(), *_files(scene.data), told, *sources(used(job, scene))])


def _files(data: Any) -> Iterator[str]:
    """Hashes of the files that values of a scene name: tables and meshes; a checked scene has absolute paths."""
    if isinstance(data, Mapping):
        data = data.values()
    elif isinstance(data, str):
        path = Path(data)
        if path.is_absolute() and path.is_file():
            with path.open("rb") as file:
                yield hashlib.file_digest(file, "sha256").hexdigest()
        return
    if isinstance(data, Iterable):
        for value in data:
            yield from _files(value)


def used(job: Job, scene: Scene) -> set[str]:
    """Top-level packages of the parts of a job."""
    watches = [("watch", "watch", split_spec("watch", spec, "watch")[0]) for spec in job.watch]
    return _packages(scene.registry, [*part_specs(scene), *watches])


def _packages(registry: Registry, parts: Iterable[tuple[str, str, str]]) -> set[str]:
    """Packages of the parts listed by `part_specs`."""
    return {_package(registry, kind, name) for _, kind, name in parts}


def _package(registry: Registry, kind: str, name: str) -> str:
    return registry.offer(kind, name).part.target.partition(":")[0].partition(".")[0]


def case_sources(name: str, registry: Registry) -> str:
    """Hash of the package that a case comes from, and of what judges it."""
    return _hash(sources({_package(registry, "case", name)}))


def sources(packages: Iterable[str]) -> list[str]:
    """Hashes of the core's sources and of other packages' sources."""
    return [_tree(CORE)] + [_hash_of_package(name) for name in sorted(set(packages) - {"contactlab"})]


@cache
def _hash_of_package(name: str) -> str:
    found = find_spec(name)
    if found is None or found.origin is None:
        return name
    origin = Path(found.origin)
    return _tree(origin.parent) if origin.name == "__init__.py" else _hash([origin.read_text(encoding="utf-8")])


@cache
def _tree(folder: Path) -> str:
    """Hash of all files of a package that can change what is computed."""
    files = sorted(p for p in folder.rglob("*") if p.suffix in (".py", ".toml") and "__pycache__" not in p.parts)
    return _hash([f"{p.relative_to(folder)}\n{p.read_text(encoding='utf-8')}" for p in files])


def _hash(texts: Iterable[str]) -> str:
    made = hashlib.sha256()
    for text in texts:
        made.update(text.encode() + b"\0")
    return made.hexdigest()[:32]
