"""`contactlab new-scene`: a scene of your own, starting from another."""

from __future__ import annotations

import argparse
import os
import re
import tomllib
from pathlib import Path
from typing import Any

from contactlab.commands.common import console, registry_with
from contactlab.errors import RequestError
from contactlab.outside_files import text_outside, usable
from contactlab.scene.scene import find_scene, load_scene

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]*")


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
