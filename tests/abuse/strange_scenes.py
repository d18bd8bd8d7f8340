"""Scenes, and what stands beside them, as strangers write them: keys by the schema, damaged text, words, side files."""

from __future__ import annotations

import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from made_up import entry, places, strange, value, wide_number
from strange_meshes import strange_mesh

from contactlab.commands.common import parse_settings
from contactlab.model import sizes
from contactlab.scene.scene import Scene, bundled_scenes, load_scene
from contactlab.scene.toml_text import write_toml

BRIEF = {"record.recorders": [], "record.frames": 2}
KINDS: dict[str, dict[str, Any]] = {
    "explicit": {"bodies.disc.mesh.cells": [6, 2], "bodies.block.mesh.cells": [8, 2], "time.end": 2e-6},
    "quadratic": {"bodies.disc.element": "q2", "bodies.block.element": "q2-lagrange"},
    "newton": {"integrator": {"use": "newton", "steps": 24}, "time.end": 1.0, "supports.1.uy.to": -0.01},
    "implicit-dynamics": {"integrator": {"use": "implicit-dynamics", "steps": 24}, "time.end": 2e-6},
}
"""Kinds of disc-on-block that no bundled scene is."""
CHARACTERS = "[]{}\"'#=.,\n\t\\ 0123456789eE+-_axu\u00e9\u200b\x00\x1b\ufeff"
NUMBERS = (
    "9" * 4301,
    "1e999",
    "0x" + "f" * 300,
    "-0",
    "1_0",
    "+nan",
    "00",
    "1e-999",
    "2026-01-01",
    "1979-05-27T07:32:00Z",
)
CELLS = ("", "x", "nan", "-inf", "1e999", "9" * 4301, "1,2", "#", '"', "\x00")
SIDE_FILES = ("ramp", "profile", "mesh file")


class Scenes:
    """The scenes that are changed; a base is a bundled scene, or one of `KINDS`."""

    def __init__(self, few: bool) -> None:
        disc = load_scene("disc-on-block").with_({**BRIEF, **KINDS["explicit"]})
        self.bases: dict[str, Scene] = {"explicit": disc}
        if not few:
            self.bases |= {name: disc.with_(changes) for name, changes in KINDS.items()}
            self.bases |= {name: load_scene(name).with_(BRIEF) for name in bundled_scenes()}
        self.texts = {name: write_toml(base.data) for name, base in self.bases.items()}
        self.names = list(self.bases)

    def base(self, chance: random.Random) -> tuple[str, Scene]:
        """Any base."""
        name = chance.choice(self.names)
        return name, self.bases[name]

    def keys(self, chance: random.Random) -> tuple[str, dict[str, Any]]:
        """A base and one to three keys that the schema has, or that the scene has."""
        name, base = self.base(chance)
        changes = {}
        for _ in range(chance.choice((1, 1, 2, 3))):
            if chance.random() < 0.75:
                place, new = entry(base.data, chance)
            else:
                place, new = chance.choice(list(places(base.data))), nearly(base, chance)
            changes[place] = new
        return name, changes

    def mild(self, chance: random.Random) -> tuple[str, dict[str, Any]]:
        """A base and a number or two that are a little off: most of these run."""
        name, base = self.base(chance)
        numbers = {p: at(base.data, p) for p in places(base.data)}
        chosen = chance.sample([p for p, v in numbers.items() if type(v) is float and v], 2)
        return name, {place: numbers[place] * chance.choice((0.7, 0.95, 1.04, 1.3)) for place in chosen}

    def large(self, chance: random.Random, machine: float) -> tuple[str, dict[str, Any]]:
        """A base at a level at which it takes from a tenth of the machine's memory to more than it has."""
        name, base = self.base(chance)
        level, wanted = 1, chance.uniform(0.1, 1.3) * machine
        while sizes.estimated_bytes(base.with_({"level": level}), base.registry) < wanted:
            level += 1
        return name, {"level": level}

    def text(self, folder: Path, chance: random.Random) -> Path:
        """A file of a scene whose text, or bytes, were tampered with one to four times."""
        text = self.texts[self.base(chance)[0]]
        for _ in range(chance.choice((1, 1, 2, 4))):
            text = tampered(text, chance)
        content = text.encode("utf-8", "surrogatepass")
        if chance.random() < 0.1 and content:
            spot = chance.randrange(len(content))
            content = content[:spot] + chance.randbytes(chance.choice((1, 4))) + content[spot:]
        if chance.random() < 0.03:
            content = text.encode(chance.choice(("utf-16", "latin-1", "utf-8-sig")), "replace")
        path = folder / "scene.toml"
        path.write_bytes(content)
        return path

    def words(self, chance: random.Random) -> tuple[str, dict[str, Any]]:
        """A base and what one or two words after `--set` come to. Raises RequestError."""
        name, base = self.base(chance)
        words = []
        for _ in range(chance.choice((1, 1, 2))):
            place, new = (
                entry(base.data, chance) if chance.random() < 0.5 else (chance.choice(list(places(base.data))), 0)
            )
            shown = chance.choice((repr(new), str(new), "", *NUMBERS))
            word = f"{place}={shown}" if chance.random() < 0.9 else place
            words.append(tampered(word, chance) if chance.random() < 0.4 else word)
        return name, parse_settings(words)

    def beside(self, folder: Path, chance: random.Random) -> tuple[str, dict[str, Any]]:
        """A base that takes a file that was made by a stranger."""
        kind = chance.choice(SIDE_FILES)
        if kind == "mesh file":
            return "explicit", strange_mesh(folder, chance)
        path = str(table_file(folder, chance))
        if kind == "ramp":
            return "explicit", {"supports.1.uy": {"ramp": "table", "to": -0.01, "file": path}}
        return "explicit", {"loads": [{"on": "disc.top", "pressure": 1.0, "profile": {"file": path}}]}


def at(data: Any, place: str) -> Any:
    """What stands at a dotted key."""
    for name in place.split("."):
        data = data[name] if isinstance(data, Mapping) else data[int(name)]
    return data


def nearly(base: Scene, chance: random.Random) -> Any:
    """What stands somewhere else in the scene, or anything."""
    if chance.random() < 0.5:
        return at(base.data, chance.choice(list(places(base.data))))
    return value({"type": "number"}, chance) if chance.random() < 0.3 else strange(chance)


def tampered(text: str, chance: random.Random) -> str:
    """The text with one thing changed."""
    lines, spot = text.splitlines(keepends=True), chance.randrange(len(text) + 1)
    kind = chance.choice(("insert", "delete", "repeat", "line", "swap", "number", "cut", "deep", "join"))
    if kind == "insert":
        return text[:spot] + "".join(chance.choices(CHARACTERS, k=chance.choice((1, 2, 9)))) + text[spot:]
    if kind == "delete":
        return text[:spot] + text[spot + chance.choice((1, 3, 30)) :]
    if kind == "repeat":
        return text[:spot] + text[max(0, spot - 40) :]
    if kind == "number":
        begin = next((n for n in range(spot, len(text)) if text[n].isdigit()), len(text))
        end = next((n for n in range(begin, len(text)) if not (text[n].isdigit() or text[n] in ".eE-")), len(text))
        new = chance.choice((*NUMBERS, str(chance.randrange(-3, 50)), repr(wide_number(chance))))
        return text[:begin] + new + text[end:]
    if kind == "cut":
        return text[:spot]
    if kind == "deep":
        depth = chance.choice((3, 200, 20_000))
        return text[:spot] + chance.choice(("[", "{a=", "a.", '"')) * depth + text[spot:]
    if len(lines) < 2:
        return text * 2
    a, b = chance.randrange(len(lines)), chance.randrange(len(lines))
    if kind == "swap":
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == "line":
        lines.insert(a, lines[b])
    else:
        del lines[a]
    return "".join(lines)


def table_file(folder: Path, chance: random.Random) -> Path:
    """A file of two columns of numbers, right or wrong in some way."""
    path = folder / chance.choice(("table.csv", "table.txt", "table.csv.gz", "tablé.csv", "table"))
    rows = [[repr(number * 1e-7), repr(chance.random())] for number in range(chance.choice((0, 1, 2, 3, 20)))]
    for _ in range(chance.choice((0, 1, 1, 2))):
        if rows:
            row = chance.choice(rows)
            row[chance.randrange(len(row))] = chance.choice(
                ("", "x", "nan", "-inf", "1e999", "9" * 4301, "1,2", "#", '"', "\x00")
            )
    between = chance.choice((",", ",", ",", ";", " ", "\t"))
    content = "\n".join(between.join(row) for row in rows)
    path.write_bytes(content.encode() if chance.random() < 0.85 else chance.randbytes(chance.choice((0, 1, 300))))
    return path
