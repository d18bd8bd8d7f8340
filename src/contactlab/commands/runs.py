"""`contactlab runs`: list result folders, or remove some."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from fnmatch import fnmatch
from pathlib import Path
from shutil import rmtree
from time import localtime, strftime
from typing import Any

from contactlab.commands.common import console, print_json
from contactlab.errors import RequestError, did_you_mean, show, visible
from contactlab.reports.sheet import Column, Sheet
from contactlab.results.inventory import Folder, folders_in
from contactlab.run.folders import RUNS

FAILED = "failed"
"""Word after `--remove` for every folder in which something did not finish."""


def runs(options: argparse.Namespace) -> int:
    """List the folders, or remove those that are named."""
    places = [Path(name) for name in options.folders] or [RUNS]
    for place in places:
        if options.folders and not place.is_dir():
            raise RequestError("there is no such folder", where="runs", got=str(place), allowed="a folder of runs")
    from contactlab.scene.scene import bundled_scenes, load_scene

    names = bundled_scenes()
    found = folders_in(places, lambda name: load_scene(name).data if name in names else None)
    if options.remove:
        return _remove(_chosen(found, options.remove), options.yes)
    if options.json:
        print_json({"format": 1, "folders": [_record(folder) for folder in found]})
        return 0
    out = console()
    if not found:
        out.print(f"no results in {', '.join(map(str, places))}", markup=False, highlight=False)
        return 0
    rows = []
    for folder in found:
        path = folder.path.name if len(places) == 1 else str(folder.path)
        scene = "" if path.startswith(folder.scene) else folder.scene
        changed = changed_text(folder.changes)
        rows.append([path, _date(folder), scene, changed, folder.status, _size(folder.bytes)])
    name, size = Column("folder", whole=True), Column("size", whole=True, number=True)
    out.print(Sheet((name, "date", Column("scene", leaves=1), "changed", "status", size), rows, more="--json"))
    total = _size(sum(folder.bytes for folder in found))
    out.print(f"{_folders(len(found))}, {total}; remove some: contactlab runs --remove NAME ...", highlight=False)
    return 0


def changed_text(changes: Mapping[str, Any]) -> str:
    """Changed keys as `--set` takes them."""
    return ", ".join(f"{key}={'none' if value is None else _value(value)}" for key, value in changes.items())


def _value(value: Any) -> str:
    return value if isinstance(value, str) else show(value, 40)


def _date(folder: Folder) -> str:
    return strftime("%Y-%m-%d %H:%M", localtime(folder.date))


def _folders(number: int) -> str:
    return "1 folder" if number == 1 else f"{number} folders"


def _size(size: int) -> str:
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.0f} kB"


def _record(folder: Folder) -> dict[str, Any]:
    return {
        "folder": str(folder.path), "kind": folder.kind, "scene": folder.scene, "date": _date(folder),
        "changed": dict(folder.changes), "status": folder.status, "bytes": folder.bytes,
    }  # fmt: skip


def _chosen(found: Sequence[Folder], names: Sequence[str]) -> list[Folder]:
    """Folders that are named. Raises RequestError for a name or pattern of none."""
    chosen: dict[Path, Folder] = {}
    for name in names:
        if name == FAILED:
            meant = [folder for folder in found if not folder.finished]
        else:
            meant = [f for f in found if fnmatch(f.path.name, name) or f.path == Path(name)]
        if not meant and name != FAILED:
            known = [folder.path.name for folder in found]
            raise RequestError(
                "there is no such result folder", where="--remove", got=name,
                allowed=f"{', '.join(known)}, a pattern, or {FAILED}", hint=did_you_mean(name, known),
            )  # fmt: skip
        chosen |= {folder.path: folder for folder in meant}
    return list(chosen.values())


def _remove(chosen: Sequence[Folder], sure: bool) -> int:
    total = _size(sum(folder.bytes for folder in chosen))
    if not sure and not sys.stdin.isatty():
        raise RequestError("no terminal to confirm", where="--remove", hint="add --yes to remove without asking")
    for folder in chosen:
        print(visible(f"{folder.path}  {folder.status}  {_size(folder.bytes)}"))
    if not chosen:
        print("nothing to remove")
        return 0
    if not sure and input(f"remove {_folders(len(chosen))}, {total}? [y/N] ").strip().lower() not in ("y", "yes"):
        print("nothing removed")
        return 1
    for folder in chosen:
        rmtree(folder.path)
    print(f"removed {_folders(len(chosen))}, {total}")
    return 0
