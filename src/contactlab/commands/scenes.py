"""`contactlab scenes`: scenes that come with the program, to read and to begin with."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from contactlab.commands.common import ROOM_TO_SPARE, console, print_json, registry_with
from contactlab.errors import SceneError, did_you_mean
from contactlab.reports.sheet import Column, Sheet
from contactlab.scene.scene import bundled_scenes, load_scene
from contactlab.scene.toml_text import read_toml


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
