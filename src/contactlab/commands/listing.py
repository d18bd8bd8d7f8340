"""`contactlab scenes` and `contactlab parts`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactlab.commands.common import add_row, console, registry_with, table
from contactlab.errors import SceneError
from contactlab.parts.loading import Broken
from contactlab.parts.registry import Offer, Registry
from contactlab.scene.scene import bundled_scenes
from contactlab.scene.toml_text import read_toml

if TYPE_CHECKING:
    from rich.table import Table

NARROW = 120


def scenes(options: argparse.Namespace) -> int:
    """List bundled scenes with where they were published; a broken file is a row with its reason."""
    del options
    shown = table("scene", "bodies", "contacts", "source")
    for column in shown.columns[:3]:
        column.no_wrap = True  # names stay whole, the source wraps
    for name, path in bundled_scenes().items():
        add_row(shown, name, *_scene_row(path))
    console().print(shown)
    return 0


def _scene_row(path: Path) -> tuple[str, str, str]:
    try:
        data, _ = read_toml(path, path.name)
    except SceneError as error:
        return "", "", f"broken: {error.problem}"
    contacts = data.get("contacts", [])
    pairs = [
        f"{_side(c['slave'])} on {_side(c['master'])}"
        for c in contacts
        if isinstance(c, dict) and {"slave", "master"} <= set(c)
    ]
    return "\n".join(data.get("bodies", {})), "\n".join(pairs), str(data.get("source", ""))


def _side(sets: str | list[str]) -> str:
    """An edge set; of several that form a surface together, the bodies they belong to."""
    return sets if isinstance(sets, str) else " + ".join(dict.fromkeys(str(name).partition(".")[0] for name in sets))


def parts(options: argparse.Namespace) -> int:
    """List usable parts by kind, and everything broken with its reason."""
    registry = registry_with(options.files)
    broken = [*registry.broken(), *registry.incomplete()]
    unusable = {(item.origin, item.item) for item in broken}
    usable = [
        offer for offer in registry.parts() if (offer.origin, f"{offer.part.kind} {offer.part.name}") not in unusable
    ]
    commands = registry.commands()
    if options.json:
        print(json.dumps(_as_json(usable, broken, registry), indent=1))
        return 0
    _print_parts(usable, broken, commands)
    return 0


def _as_json(usable: list[Offer], broken: list[Broken], registry: Registry) -> dict[str, Any]:
    return {
        "format": 1,
        "parts": [_part_json(offer) for offer in usable],
        "commands": [{"name": name, **_origin_json(origin)} for name, (_, origin) in registry.commands().items()],
        "broken": [{"item": item.item, "reason": item.reason, **_origin_json(item.origin)} for item in broken],
    }


def _part_json(offer: Offer) -> dict[str, Any]:
    part = offer.part
    named = {"kind": part.kind, "name": part.name, "summary": part.summary, "reference": part.reference}
    return {**named, "target": part.target, **_origin_json(offer.origin)}


def _origin_json(origin: Any) -> dict[str, str]:
    return {"plugin": origin.plugin, "distribution": origin.distribution, "version": origin.version}


def _print_parts(usable: list[Offer], broken: list[Broken], commands: Any) -> None:
    out = console()
    out.print(_parts_table(usable, narrow=out.width < NARROW))
    if commands:
        more = table("command", "from", title="further commands")
        for name, (_, origin) in commands.items():
            add_row(more, name, str(origin))
        out.print(more)
    if broken:
        wrong = table("plugin", "from", "what", "why it is left out", title="broken")
        for item in broken:
            add_row(wrong, item.origin.plugin, str(item.origin), item.item, item.reason)
        out.print(wrong)


def _parts_table(usable: list[Offer], narrow: bool) -> Table:
    """Each kind is named once; where a part was published only shows where there is room."""
    columns = ("kind", "name", "from", "what it is", "published in")
    shown = table(*columns[: 4 if narrow else 5])
    for column in shown.columns[:3]:
        column.no_wrap = True
    kind = ""
    for offer in usable:
        part = offer.part
        cells = (part.kind if part.kind != kind else "", part.name, str(offer.origin), part.summary, part.reference)
        add_row(shown, *cells[: len(shown.columns)])
        kind = part.kind
    return shown
