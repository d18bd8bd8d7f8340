"""The parts that `contactlab check` runs on: by name, in a file or folder, or of an installed distribution."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import Distribution, EntryPoint
from pathlib import Path
from typing import Any

from contactlab.api.part import KINDS
from contactlab.errors import PartError, RequestError, did_you_mean
from contactlab.parts.loading import GROUP, installed
from contactlab.parts.registry import Offer, Registry, default_registry
from contactlab.testing.subject import Subject


def subjects(
    target: str, kind: str = "", files: Sequence[str] = (), given: Mapping[str, Any] | None = None
) -> list[Subject]:
    """The parts that `target` means, of one kind alone if one is given. Raises RequestError without any."""
    if kind and kind not in KINDS:
        hint = did_you_mean(kind, KINDS)
        raise RequestError("there is no such kind", where="--kind", got=kind, allowed=", ".join(KINDS), hint=hint)
    registry, offers = _offers(target, files)
    meant = [offer for offer in offers if not kind or offer.part.kind == kind]
    if not meant:
        raise _nothing(target, kind, registry, offers)
    found = [Subject(registry, offer.part.kind, offer.part.name, dict(given or {})) for offer in meant]
    for subject in found if given else ():
        _take(subject)
    return found


def _take(subject: Subject) -> None:
    """Raise the part's own error for given values, if it can be made without them: then they are a wrong request."""
    try:
        subject.make()
    except RequestError:
        try:
            replace(subject, given={}).make()
        except RequestError:
            return  # the part fails its checks
        raise


def _offers(target: str, files: Sequence[str]) -> tuple[Registry, list[Offer]]:
    """The registry, and what of it is meant."""
    path = Path(target)
    if path.suffix == ".py" or path.is_file():
        registry = Registry(files=[*files, path])
        return registry, [o for o in registry.parts() if o.origin.distribution == str(path.resolve())]
    if path.is_dir() and not _named(target, default_registry()):
        return _of_folder(path, files)
    registry = Registry(files=files) if files else default_registry()
    return registry, _named(target, registry)


def _named(target: str, registry: Registry) -> list[Offer]:
    """Parts of this name, or of the distribution of this name."""
    offers = registry.parts()
    return [o for o in offers if o.part.name == target] or [o for o in offers if o.origin.distribution == target]


def _of_folder(folder: Path, files: Sequence[str]) -> tuple[Registry, list[Offer]]:
    """Parts of a package that need not be installed, or of all files with hooks in a plain folder."""
    project = folder / "pyproject.toml"
    if not project.is_file():
        own = [str(p.resolve()) for p in sorted(folder.glob("*.py")) if "hookimpl" in p.read_text(encoding="utf-8")]
        registry = Registry(files=[*files, *own])
        return registry, [o for o in registry.parts() if o.origin.distribution in own]
    table = _project(project)
    name, points = str(table.get("name", folder.name)), table.get("entry-points", {}).get(GROUP, {})
    if not points:
        raise PartError(
            "the package has no entry point for contactlab",
            where=str(project),
            allowed=f"[project.entry-points.{GROUP}]",
        )
    known = [point for point in installed() if point.dist is None or point.dist.name != name]
    if len(known) == len(installed()):
        sys.path[:0] = [str(p.resolve()) for p in (folder / "src", folder) if p.is_dir()]
        known += [_of_project(EntryPoint(plugin, module, GROUP), table, folder) for plugin, module in points.items()]
    else:
        known = installed()
    registry = Registry(known, files)
    return registry, [o for o in registry.parts() if o.origin.plugin in points]


class _Project(Distribution):
    """A package that is not installed, by the table `project` of its pyproject.toml."""

    def __init__(self, table: Mapping[str, Any], folder: Path) -> None:
        self.table, self.folder = table, folder

    @property
    def name(self) -> str:
        """Name under which it would be installed."""
        return str(self.table.get("name", self.folder.name))

    @property
    def version(self) -> str:
        """Version in the table; empty without an entry."""
        return str(self.table.get("version", ""))

    def read_text(self, filename: str) -> str | None:
        """Return None: nothing is installed, so there is nothing to read."""
        return None

    def locate_file(self, path: Any) -> Any:
        """A file of the package."""
        return self.folder / path


def _of_project(point: EntryPoint, table: Mapping[str, Any], folder: Path) -> EntryPoint:
    vars(point)["dist"] = _Project(table, folder)
    return point


def _nothing(target: str, kind: str, registry: Registry, offers: Sequence[Offer]) -> RequestError:
    if offers:
        found = ", ".join(f"{o.part.kind} {o.part.name}" for o in offers)
        return RequestError("there is no part of this kind in it", where=target, got=kind, allowed=found)
    broken = [b for b in registry.broken() if b.origin.distribution in _names_of(target)]
    if broken:
        return PartError("; ".join(b.reason for b in broken), where=target)
    if Path(target).is_dir():
        return RequestError(
            "no parts in this folder", where="check", got=target,
            allowed="a package with pyproject.toml, or Python files with hooks",
        )  # fmt: skip
    if Path(target).is_file():
        return RequestError(
            "no parts in this file", where="check", got=target,
            allowed="a Python file whose hook contactlab_parts names parts",
        )  # fmt: skip
    names = sorted({o.part.name for o in registry.parts()} | {o.origin.distribution for o in registry.parts()})
    return RequestError(
        "no part, file, folder or distribution of this name", where="check", got=target,
        allowed="the name of a part (contactlab parts), a Python file, a folder, or an installed distribution",
        hint=registry.missing_from(target) or did_you_mean(target, names),
    )  # fmt: skip


def _names_of(target: str) -> set[str]:
    """Distributions that what breaks in a file, a folder or a distribution may be of."""
    path = Path(target)
    files = {str(file.resolve()) for file in path.glob("*.py")} if path.is_dir() else set()
    project = path / "pyproject.toml"
    if project.is_file():
        files.add(str(_project(project).get("name", path.name)))
    return {target, str(path.resolve()), *files}


def _project(file: Path) -> dict[str, Any]:
    """The table `project` of a pyproject.toml."""
    found: dict[str, Any] = tomllib.loads(file.read_text(encoding="utf-8")).get("project", {})
    return found
