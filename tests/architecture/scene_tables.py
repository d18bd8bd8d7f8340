"""The tables of docs/scene-format.md, made from the declarations that the program itself reads by.

After a change of a key or a part: `python tests/architecture/scene_tables.py` writes them into the document.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from contactlab.api import Profile
from contactlab.errors import show
from contactlab.parts.registry import Registry, default_registry
from contactlab.scene.accepts import accepts
from contactlab.scene.fields import hints_of, is_required, keys_of
from contactlab.scene.keys import (
    Arc,
    Body,
    Contact,
    EdgePart,
    Field,
    Load,
    Ramp,
    Record,
    Rigid,
    Start,
    Support,
    Time,
    Turn,
)
from contactlab.scene.scene import Scene
from contactlab.studies.study import Pareto, Study

TABLES: dict[str, type[Any]] = {
    "The top of the file": Scene,
    "`[time]`": Time,
    "`[bodies.NAME]`": Body,
    "`[bodies.NAME.sets]`: a part of an edge set": EdgePart,
    "`[[contacts]]`": Contact,
    "An overlap before the run: `start = { overlap = ... }`": Start,
    "`[rigid.NAME]`": Rigid,
    "An arc: `{ centre = ..., radius = ..., angles = ... }`": Arc,
    "`[[supports]]`": Support,
    "A value in time: `{ ramp = ..., to = ... }`": Ramp,
    "A rotation in time: `turn = { to = ..., about = ... }`": Turn,
    "`[[loads]]`": Load,
    "What varies from place to place, by a `profile`": Profile,
    "`[fields.NAME]`": Field,
    "`[record]`": Record,
    "The top of a study": Study,
    "`[pareto]` of a study": Pareto,
}


def key_table(cls: type[Any]) -> str:
    """One row per key: what it accepts, its default, its unit, its meaning."""
    hints = hints_of(cls)
    rows = ["| key | accepts | default | unit | meaning |", "|---|---|---|---|---|"]
    for name, field in keys_of(cls).items():
        meta = field.metadata
        cells = (f"`{name}`", accepts(hints[name], meta), _default(field), meta.get("unit", ""), meta["says"])
        rows.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows)


def _default(field: dataclasses.Field[Any]) -> str:
    if is_required(field):
        return "required"
    if field.default_factory is not dataclasses.MISSING:
        return f"`{show(field.default_factory())}`"
    default = field.default
    if default is None:
        return "not written"
    if dataclasses.is_dataclass(default):
        return "all defaults"
    return f"`{show(default)}`"


NOT_IN_SCENES = ("watch", "case", "measure", "reference")


def part_table(registry: Registry) -> str:
    """One row per part of this repository that a scene can name: its fields, those with a default with it."""
    rows = ["| kind | name | fields | from |", "|---|---|---|---|"]
    for offer in (offer for offer in registry.parts() if offer.part.kind not in NOT_IN_SCENES):
        fields = keys_of(registry.part_class(offer.part.kind, offer.part.name))
        written = ", ".join(_field(field) for field in fields.values()) or "none"
        rows.append(f"| {offer.part.kind} | `{offer.part.name}` | {written} | {offer.origin.distribution} |")
    return "\n".join(rows)


def _field(field: dataclasses.Field[Any]) -> str:
    if field.default is None:
        return f"`{field.name}` (optional)"
    return f"`{field.name}`" if is_required(field) else f"`{field.name} = {show(field.default)}`"


def all_tables() -> Iterator[tuple[str, str]]:
    """Heading and table, in the order of the document."""
    for heading, cls in TABLES.items():
        yield heading, key_table(cls)
    yield "Parts", part_table(default_registry())


def renewed(document: str) -> str:
    """The document with its tables of parts and keys made anew; those of keys stand in the order of `TABLES`."""
    keys = iter(key_table(cls) for cls in TABLES.values())

    def renew(match: re.Match[str]) -> str:
        first = match[0].splitlines()[0]
        if first.startswith("| key |"):
            return next(keys) + "\n"
        return part_table(default_registry()) + "\n" if first.startswith("| kind |") else match[0]

    return re.sub(r"(?:^\|.*\n)+", renew, document, flags=re.MULTILINE)


if __name__ == "__main__":
    path = Path(__file__).parents[2] / "docs" / "scene-format.md"
    path.write_text(renewed(path.read_text()))
