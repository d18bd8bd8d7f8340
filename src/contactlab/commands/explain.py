"""`contactlab explain`: what a scene calls for and what it does not."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from contactlab.commands.common import add_row, console, number, parse_settings, registry_with, table
from contactlab.scene.scene import load_scene


def explain(options: argparse.Namespace) -> int:
    """Print the explanation of the scene as tables; but for the first steps, which are thrown away, nothing is run."""
    from contactlab.explain.explain import explain as explanation_of
    from contactlab.explain.trial_run import rehearse

    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry).with_(parse_settings(options.settings))
    shown = console()
    for title, content in plain(explanation_of(scene, registry, rehearse(scene))).items():
        shown.print(section(title.replace("_", " "), content))
    return 0


def plain(explanation: Any) -> dict[str, Any]:
    """Sections of an explanation by title: the fields of its dataclass, single values gathered first."""
    values = {field.name: getattr(explanation, field.name) for field in dataclasses.fields(explanation)}
    gathered = {name: value for name, value in values.items() if _is_single(value)}
    return {**({"scene": gathered} if gathered else {}), **{k: v for k, v in values.items() if k not in gathered}}


def _is_single(value: Any) -> bool:
    return isinstance(value, str | int | float | bool | type(None))


def section(title: str, content: Any) -> Any:
    """A table of rows (records or plain values), or of names and values."""
    if isinstance(content, Mapping):
        shown = table("quantity", "value", title=title)
        for name, value in content.items():
            add_row(shown, str(name).replace("_", " "), _cell(value))
        return shown
    rows = [_record(row) for row in content] if isinstance(content, Sequence | set | frozenset) else [_record(content)]
    names = rows[0] if rows else ["name"]
    shown = table(*(name.replace("_", " ") for name in names), title=title)
    for row in rows or [{"name": "none"}]:
        add_row(shown, *(_cell(value) for value in row.values()))
    return shown


def _record(row: Any) -> dict[str, Any]:
    if dataclasses.is_dataclass(row) and not isinstance(row, type):
        return {field.name: getattr(row, field.name) for field in dataclasses.fields(row)}
    if isinstance(row, Mapping):
        return dict(row)
    if hasattr(row, "_asdict"):
        return dict(row._asdict())
    return {"name": row}


def _cell(value: Any) -> str:
    if isinstance(value, tuple | list | set | frozenset):
        return ", ".join(_cell(item) for item in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return number(value)
