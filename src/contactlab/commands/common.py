"""What several commands share: settings, registries and plain tables."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactlab.errors import PartError, RequestError, one_line
from contactlab.parts.loading import Origin
from contactlab.parts.registry import Registry, default_registry
from contactlab.scene.toml_text import parse_value

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

WIDTH_OF_FILES = 160


def registry_with(files: Sequence[str]) -> Registry:
    """The installed plugins and the files given by hand."""
    return Registry(files=files) if files else default_registry()


def parse_settings(texts: Sequence[str]) -> dict[str, Any]:
    """`KEY=VALUE` words as a dictionary; a key given twice has its last value. Raises RequestError."""
    settings = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            raise RequestError("nothing is set here", where="--set", got=text, allowed="KEY=VALUE, such as level=2")
        settings[name] = parse_value(value.strip(), f"--set {name}")
    return settings


def plugin_command(name: str, target: str, origin: Origin) -> Callable[[list[str]], int]:
    """The function behind a command that a plugin brings. Raises PartError where it cannot be imported."""
    module, _, function = target.partition(":")
    try:
        command: Callable[[list[str]], int] = getattr(import_module(module), function)
    except (Exception, SystemExit) as error:
        reason = f"the command {name} cannot be imported: {one_line(error)}"
        raise PartError(reason, where=str(origin), got=target) from error
    return command


def console() -> Console:
    """Standard output; wide enough for every table where it goes to a file or a pipe."""
    from rich.console import Console

    made = Console()
    return made if made.is_terminal or "COLUMNS" in os.environ else Console(width=WIDTH_OF_FILES)


def print_how_to_look(folder: Path, registry: Registry, out: Console) -> None:
    """Say how to look at what a recorder has left in the folder, if one has."""
    parts = [registry.part_class("recorder", name) for name in registry.names("recorder")]
    if any(part.shown_file and (folder / part.shown_file).is_file() for part in parts):
        line = f"look at it: {shlex.join(['contactlab', 'view', str(folder)])}"
        out.print(line, markup=False, highlight=False, soft_wrap=True)


def table(*columns: str, title: str = "") -> Table:
    """An empty table in the one look that all commands have."""
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, title=title or None, title_justify="left", title_style="bold", pad_edge=False)
    for column in columns:
        made.add_column(column, overflow="fold")
    return made


def add_row(shown: Table, *cells: str) -> None:
    """A row of plain text, in which brackets are brackets."""
    from rich.text import Text

    shown.add_row(*(Text(cell) for cell in cells))


def number(value: Any) -> str:
    """A number for people: four figures, nothing for what has no meaning."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return f"{value:,d}".replace(",", " ") if isinstance(value, int) else "" if value != value else f"{value:.4g}"
