"""Parts of strangers from their sources, with pieces of them exchanged."""

from __future__ import annotations

import itertools
import re
from pathlib import Path
from typing import Any

from planted import PLANTED
from plugin_page import FILES

from contactlab.parts.registry import Registry
from contactlab.testing.subject import Subject

NUMBER = itertools.count()
HERE = Path(__file__).parent
TEMPLATES = HERE.parents[1] / "src" / "contactlab" / "data" / "new_plugin"
GIVEN: dict[str, dict[str, Any]] = {
    "effect outside remembering/src/remembering/parts.py:Maxwell": {
        "stiffness": 1e3, "relaxation": 0.5, "on": ["upper"],
    },
    "enforcement outside remembering/src/remembering/parts.py:CrushedLayer": {"stiffness": 1e4, "limit": 50.0},
    "enforcement outside remembering/src/remembering/parts.py:WornLayer": {"stiffness": 1e4, "wear": 1e-3},
}  # fmt: skip
"""Values of fields for which none is usual."""
HOOK = """

from contactlab.api.plugin import Part as _Part, hookimpl as _hookimpl


@_hookimpl
def contactlab_parts():
    return [_Part("{kind}", "{name}", "{module}:{cls}", "of a stranger")]
"""


def source_of(base: str) -> tuple[str, str, str]:
    """Kind, class and source of a part: "right NAME", "template KIND/FILE", or "KIND outside (or page) PATH:CLASS"."""
    words = base.split()
    if words[0] == "right":
        text = (HERE / "right_parts" / f"{words[1]}.py").read_text(encoding="utf-8")
        found = re.match(r"# kind (\w+) cls (\w+)\n", text)
        assert found
        return found[1], found[2], text
    if words[0] == "template":
        kind, _, file = words[1].partition("/")
        text = (TEMPLATES / kind / f"{file or 'part'}.py.template").read_text(encoding="utf-8")
        return kind, "Mine", text.replace("$class_name", "Mine").replace("$name", "mine").replace("$$", "$")
    path, _, cls = words[2].partition(":")
    text = FILES[path] if words[1] == "page" else (HERE.parent / "outside" / path).read_text(encoding="utf-8")
    return words[0], cls, text.partition("@hookimpl")[0]


def changed(base: str, changes: tuple[str, ...]) -> str:
    """The source of a part with pieces exchanged."""
    text = source_of(base)[2]
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        every = old.startswith("*")
        piece = old.removeprefix("*")
        assert piece in text, f"{base}: {piece!r} does not stand in it"
        text = text.replace(piece, new) if every else text.replace(piece, new, 1)
    return text


def subject_of(base: str, folder: Path, changes: tuple[str, ...] = ()) -> Subject:
    """The part with pieces of its source exchanged, in a file of its own."""
    kind, cls, _ = source_of(base)
    text, module = changed(base, changes), f"stranger_{next(NUMBER)}"
    file = folder / f"{module}.py"
    file.write_text(text + HOOK.format(kind=kind, name="strange", module=module, cls=cls), encoding="utf-8")
    return Subject(Registry(files=[file]), kind, "strange", GIVEN.get(base, {}))


def changes_of(base: str, says: str) -> tuple[str, ...]:
    """What a planted defect exchanges."""
    return next(defect[1:] for defect in PLANTED[base] if defect[0] == says)
