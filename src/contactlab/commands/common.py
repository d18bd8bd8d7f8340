"""Functions that several commands share: settings, registries, and standard output."""

from __future__ import annotations

import argparse
import json
import os
import shlex
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactlab.errors import PartError, RequestError, one_line
from contactlab.jobs.rows import finite
from contactlab.parts.loading import Origin
from contactlab.parts.registry import Registry, default_registry
from contactlab.scene.toml_text import parse_value

if TYPE_CHECKING:
    from contactlab.reports.terminal import Terminal


WIDTH_OF_FILES = 160
ROOM_TO_SPARE = 110
"""Width of a terminal above which tables have their less important columns as well."""


def registry_with(files: Sequence[str]) -> Registry:
    """Make the registry of installed plugins and of files given by hand."""
    return Registry(files=files) if files else default_registry()


def parse_settings(texts: Sequence[str]) -> dict[str, Any]:
    """`KEY=VALUE` words as a dictionary; a key given twice has its last value. Raises RequestError."""
    settings = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            raise RequestError("no value is given", where="--set", got=text, allowed="KEY=VALUE, such as level=2")
        value = {"True": "true", "False": "false"}.get(value.strip(), value.strip())  # as Python writes them
        settings[name] = parse_value(value, f"--set {name}")
    return settings


def typed(command: str, options: argparse.Namespace, *more: str) -> str:
    """A command on the scene, settings and files of `options`, and with more words, as it is typed."""
    words = [word for setting in options.settings for word in ("--set", setting)]
    words += [word for file in options.files for word in ("--with", file)]
    return shlex.join(["contactlab", command, options.scene, *words, *more])


def resume_line(options: argparse.Namespace, folder: Path) -> str:
    """The command with these options as it was typed, but resumed in `folder`."""
    words, kept = iter(options.words), []
    for word in words:
        if word == "--out":
            next(words)
        elif word != "--resume" and not word.startswith("--out="):
            kept.append(word)
    return shlex.join(["contactlab", *kept, "--out", str(folder), "--resume"])


def plugin_command(name: str, target: str, origin: Origin) -> Callable[[list[str]], int]:
    """The function behind a command of a plugin. Raises PartError if it cannot be imported."""
    module, _, function = target.partition(":")
    try:
        command: Callable[[list[str]], int] = getattr(import_module(module), function)
    except (Exception, SystemExit) as error:
        reason = f"the command {name} cannot be imported: {one_line(error)}"
        raise PartError(reason, where=str(origin), got=target) from error
    return command


def console() -> Terminal:
    """Standard output; wide enough for every table where it goes to a file or a pipe."""

    from contactlab.reports.terminal import Terminal

    made = Terminal()
    return made if made.is_terminal or "COLUMNS" in os.environ else Terminal(width=WIDTH_OF_FILES)


def written(value: Any, digits: int | None = None) -> str:
    """A value as `--set KEY=VALUE` takes it; numbers with so many `digits`, all of them by default."""
    if isinstance(value, float) and digits is not None:
        return f"{value:.{digits}g}"
    return str(value).lower() if isinstance(value, bool) else str(value)


def print_how_to_look(folder: Path, registry: Registry, out: Terminal) -> None:
    """Say how to look at what is in the folder, or what has to be installed for that."""
    from contactlab.studies.shown_file import can_be_shown, showing_recorder

    line = ""
    if can_be_shown(folder, registry):
        line = f"view it: {shlex.join(['contactlab', 'view', str(folder)])}"
    elif showing_recorder(registry) is None and (missing := registry.missing_packages(optional=False)):
        line = f"no timeline was recorded, as no viewer is installed: pip install {' '.join(missing)}"
    if line:
        out.say(line)


def print_json(data: Any) -> None:
    """Data for programs on standard output."""
    print(json_text(data))


def json_text(data: Any) -> str:
    """Data as JSON; what is no finite number is null."""
    return json.dumps(finite(data), indent=1, allow_nan=False, default=str)


def number(value: Any) -> str:
    """A number for people: four figures, nothing for what has no meaning."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return f"{value:,d}".replace(",", " ") if isinstance(value, int) else "" if value != value else f"{value:.4g}"
