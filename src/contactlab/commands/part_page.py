"""All that one part says of itself: its fields with units and defaults, its source, and a scene that uses it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactlab.commands.common import ROOM_TO_SPARE
from contactlab.commands.parts import part_json
from contactlab.errors import SceneError, show
from contactlab.parts.description import described_fields, prose
from contactlab.parts.registry import Offer, Registry
from contactlab.reports.sheet import Column, Sheet
from contactlab.scene.fields import kind_at
from contactlab.scene.scene import Scene, bundled_scenes
from contactlab.scene.toml_text import read_toml

if TYPE_CHECKING:
    from rich.console import Console

HEADS = {
    "element": "[bodies.NAME]\nelement",
    "mesh": "[bodies.NAME]\nmesh",
    "material": "[materials]\nNAME",
    "contact": "[[contacts]]\nalgorithm",
    "friction": "[[contacts]]\nfriction",
    "enforcement": "[[contacts]]\nenforcement",
    "recorder": "[record]\nrecorders",
    "effect": "effects",
    "function": '[[loads]]\nprofile.by = "x"\nprofile.function',
    "integrator": "integrator",
}
"""Key of a scene for a part of each kind."""


def page_of(offer: Offer, registry: Registry) -> dict[str, Any]:
    """The part as plain data. Raises PartError if it cannot be imported."""
    part = offer.part
    cls = registry.part_class(part.kind, part.name)
    example, scene = example_of(part.kind, part.name, registry)
    return {
        **part_json(offer),
        "says": prose(cls),
        "fields": [asdict(field) for field in described_fields(cls)],
        "example": example,
        "example_from": scene,
    }


def example_of(kind: str, name: str, registry: Registry) -> tuple[str, str]:
    """Example of the part in a scene, and the bundled scene with it; made from usual values if no scene has it."""
    for scene, path in bundled_scenes(registry).items():
        for spec in _specs(kind, _data_of(path), ()):
            if name in (spec, spec.get("use") if isinstance(spec, Mapping) else None):
                return _written(kind, spec), scene
    return (_made(kind, name, registry), "") if kind in HEADS else ("", "")


@cache
def _data_of(path: Path) -> dict[str, Any]:
    """Content of a scene's file; empty if it is broken, which is reported elsewhere."""
    try:
        return read_toml(path, path.name)[0]
    except SceneError:
        return {}


def _specs(kind: str, value: Any, path: tuple[str, ...]) -> Iterator[Any]:
    """Yield the values of a scene at keys for parts of this kind."""
    if path and kind_at(Scene, path) == kind:
        yield value
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from _specs(kind, item, (*path, str(key)))
    elif isinstance(value, list):
        for number, item in enumerate(value):
            yield from _specs(kind, item, (*path, str(number)))


def _written(kind: str, spec: Any) -> str:
    entry = show(spec, most=400)
    return f"{HEADS[kind]} = {f'[{entry}]' if kind in ('effect', 'recorder') else entry}"


def _made(kind: str, name: str, registry: Registry) -> str:
    """With usual values for what is required; empty if a field has none."""
    from contactlab.testing.assertions import NotApplicable
    from contactlab.testing.examples import example_spec

    try:
        spec = example_spec(registry, kind, name)
    except NotApplicable:
        return ""
    return _written(kind, spec if len(spec) > 1 else name)


def print_page(page: Mapping[str, Any], out: Console) -> None:
    """Print the page of a part."""
    from rich.text import Text

    out.print(Text.assemble((page["name"], "bold"), f": {page['summary']}"))
    out.print(Text(f"{page['kind']} of {page['distribution']} {page['version']}".strip(), style="dim"))
    if page["reference"]:
        out.print(Text(f"source: {page['reference']}", style="dim"))
    if page["says"]:
        out.print(Text(f"\n{page['says']}"))
    if page["fields"]:
        names = ["name", "default", "unit", "meaning", "accepts"][: 5 if out.width >= ROOM_TO_SPARE else 4]
        heads = [
            Column("field", whole=True),
            *(Column(name, keep=name in ("meaning", "default")) for name in names[1:]),
        ]
        out.print(Sheet(heads, ([field[name] for name in names] for field in page["fields"])))
    else:
        out.print("\nIt has no fields.")
    if page["example"]:
        where = f" (from {page['example_from']})" if page["example_from"] else ""
        out.print(f"\nIn a scene{where}:\n", markup=False, highlight=False)
        out.print(Text("\n".join(f"  {line}" for line in page["example"].splitlines())), soft_wrap=True)
        out.print()
