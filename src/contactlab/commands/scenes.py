"""`contactlab scenes` and `contactlab new-scene`: scenes that come with the program, to read and to begin with."""

from __future__ import annotations

import argparse
import os
import re
import sys
import tomllib
from pathlib import Path
from typing import Any

from contactlab.commands.common import ROOM_TO_SPARE, console, print_json, registry_with
from contactlab.errors import RequestError, SceneError, did_you_mean
from contactlab.outside_files import text_outside, usable
from contactlab.reports.sheet import Column, Sheet
from contactlab.scene.scene import bundled_scenes, find_scene, load_scene
from contactlab.scene.toml_text import read_toml

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]*")


def scenes(options: argparse.Namespace) -> int:
    """List bundled scenes, print one of them, or print the JSON schema of all scenes."""
    if options.schema:
        from contactlab.scene.schema import scene_schema

        print_json(scene_schema(registry_with(options.files)))
        return 0
    found = bundled_scenes(registry_with(options.files))
    if options.scene is not None:
        return _print_scene(options.scene, found, options.json)
    rows = [{"name": name, **_scene_row(path)} for name, path in found.items()]
    if options.json:
        print_json({"format": 1, "scenes": rows})
        return 0
    _print_scenes(rows)
    return 0


def _print_scene(name: str, found: dict[str, Path], as_json: bool) -> int:
    if name not in found:
        names = ", ".join(found)
        raise SceneError(
            "there is no such bundled scene", where="scenes", got=name, allowed=names,
            hint=did_you_mean(name, found),
        )  # fmt: skip
    if as_json:
        print_json({"format": 1, "name": name, "scene": load_scene(name).data})
    else:
        sys.stdout.write(found[name].read_text(encoding="utf-8"))
    return 0


def _scene_row(path: Path) -> dict[str, Any]:
    try:
        data, _ = read_toml(path, path.name)
    except SceneError as error:
        return {"bodies": [], "contacts": [], "source": "", "broken": error.problem}
    pairs = [
        f"{_side(c['slave'])} on {_side(c['master'])}"
        for c in data.get("contacts", [])
        if isinstance(c, dict) and {"slave", "master"} <= set(c)
    ]
    return {"bodies": list(data.get("bodies", {})), "contacts": pairs, "source": str(data.get("source", ""))}


def _print_scenes(rows: list[dict[str, Any]]) -> None:
    out = console()
    roomy = out.width >= ROOM_TO_SPARE
    names = ("scene", "bodies", "contacts") if roomy else ("scene",)
    lines = []
    for row in rows:
        source = f"broken: {row['broken']}" if "broken" in row else row["source"]
        pairs = [_some(row["bodies"]), _some(row["contacts"])] if roomy else []
        lines.append([row["name"], *pairs, source])
    # names stay whole, the source wraps
    out.print(Sheet([*(Column(name, whole=True, keep=True) for name in names), Column("source", keep=True)], lines))
    for line in ("print one:       contactlab scenes NAME", "start your own:  contactlab new-scene MINE --from NAME"):
        out.print(line, highlight=False)


def _some(names: list[str], most: int = 3) -> str:
    """A name a line; of many the first ones and how many there are."""
    return "\n".join(names) if len(names) <= most + 1 else "\n".join([*names[:most], f"... {len(names)} in all"])


def _side(sets: str | list[str]) -> str:
    """An edge set; of several that form a surface together, the bodies they belong to."""
    return sets if isinstance(sets, str) else " + ".join(dict.fromkeys(str(name).partition(".")[0] for name in sets))


def new_scene(options: argparse.Namespace) -> int:
    """Write NAME.toml: another scene under this name, with its comments."""
    name = options.name.removesuffix(".toml")
    if not NAME.fullmatch(Path(name).name):
        allowed = "letters, digits, . _ + and -, optionally after a folder"
        raise RequestError("not a usable name", where="new-scene", got=options.name, allowed=allowed)
    registry = registry_with(options.files)
    source, shown = find_scene(options.source, registry)
    load_scene(options.source, registry)  # its errors are reported here, and not at the first run of the copy
    file = Path(f"{name}.toml")
    if usable(file, "new-scene").exists():
        raise RequestError(
            "the file exists already", where="new-scene", got=str(file), allowed="a new name",
            hint="choose another name",
        )  # fmt: skip
    text = named(text_outside(source, shown, "a scene"), Path(name).name, str(options.source))
    text = seen_from(file.parent, text, source.parent)
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise RequestError(f"the scene cannot be written: {reason}", where=str(file)) from error
    out = console()
    for line in (f"{file}: a copy of {shown}", f"next: contactlab explain {file}; contactlab run {file}"):
        out.say(line)
    return 0


def named(text: str, name: str, source: str) -> str:
    """The text of a scene under another name, otherwise unchanged; a first line gives its source."""
    head = f"# {name}, based on {source}\n"
    own, changed = f'name = "{name}"', re.compile(r"^name\s*=.*$", re.MULTILINE)
    top, table_at, rest = text.partition("\n[")
    if changed.search(top):
        return head + changed.sub(lambda _: own, top, count=1) + table_at + rest
    return f"{head}{own}\n{text}"


def seen_from(folder: Path, text: str, before: Path) -> str:
    """The text of a scene with its relative paths of files seen from another folder than before."""
    if folder.resolve() == before.resolve():
        return text
    for path in _texts(tomllib.loads(text)):
        if path and not Path(path).is_absolute() and _is_file(before / path):
            moved = Path(os.path.relpath(before / path, folder)).as_posix()
            for mark in ('"', "'"):
                text = text.replace(f"{mark}{path}{mark}", f"{mark}{moved}{mark}")
    return text


def _texts(value: Any) -> set[str]:
    """All texts in the data of a scene."""
    if isinstance(value, str):
        return {value}
    entries = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return {text for entry in entries for text in _texts(entry)}


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # no name that a file could have
        return False
