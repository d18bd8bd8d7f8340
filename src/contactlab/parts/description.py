"""Description of a part, read from its class: sentences, and each field with its unit, default and meaning."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator
from typing import Any

from contactlab.errors import show
from contactlab.scene.accepts import accepts
from contactlab.scene.fields import hints_of, is_required, keys_of

_AFTER_NAMES = r"\s{2,}|\s(?=\[)"
_UNIT = re.compile(r"\[([^\[\]]+)\]")


@dataclasses.dataclass(frozen=True)
class FieldDescription:
    """A field of a part: what it accepts, its default as TOML has it, its unit and its meaning."""

    name: str
    accepts: str
    default: str
    unit: str
    meaning: str


def prose(cls: type[Any]) -> str:
    """Return the docstring of a part before and after its fields."""
    lines, inside = [], False
    for line in (inspect.getdoc(cls) or "").splitlines():
        names = _field_names(line, cls)
        inside = bool(names) or (inside and line.startswith("  "))
        if not inside:
            lines.append(line)
    paragraphs = re.split(r"\n\s*\n", "\n".join(lines).strip())
    return "\n\n".join(_reflowed(paragraph) for paragraph in paragraphs if paragraph.strip())


def _reflowed(paragraph: str) -> str:
    """A paragraph of plain text on one line; lists and what is indented stay as they are."""
    lines = paragraph.splitlines()
    laid_out = any(re.match(r"\s|[-*\d]|\S+\s{2,}", line) for line in lines)
    return paragraph if laid_out else " ".join(lines)


def described_fields(cls: type[Any]) -> list[FieldDescription]:
    """Every field in the order of declaration; meanings come from the docstrings of the class and of its bases."""
    hints, meanings = hints_of(cls), dict(_meanings(cls))
    return [
        FieldDescription(name, accepts(hints[name], field.metadata), default_of(field), *_with_unit(name, meanings))
        for name, field in keys_of(cls).items()
    ]


def units_of(cls: type[Any]) -> dict[str, str]:
    """The unit of each field as its docstring has it in brackets, as `mm/s` or `-`; fields without one are left out."""
    found = {name: _UNIT.search(meaning) for name, meaning in _meanings(cls)}
    return {name: unit[1] for name, unit in found.items() if unit is not None}


def default_of(field: dataclasses.Field[Any]) -> str:
    """The default of a key as TOML has it, "required" or "not written"."""
    if is_required(field):
        return "required"
    if field.default_factory is not dataclasses.MISSING:
        return show(field.default_factory())
    if field.default is None:
        return "not written"
    return "all defaults" if dataclasses.is_dataclass(field.default) else show(field.default)


def _with_unit(name: str, meanings: dict[str, str]) -> tuple[str, str]:
    meaning = meanings.get(name, "")
    found = _UNIT.search(meaning)
    if found is None:
        return "", meaning
    before, after = meaning[: found.start()].rstrip(), meaning[found.end() :]
    return found[1].replace("-", ""), (before + after if before else after.lstrip(" ,;:"))


def _meanings(cls: type[Any]) -> Iterator[tuple[str, str]]:
    """Field and meaning; a class after its bases, whose words it may replace."""
    for base in reversed(cls.__mro__):
        names: list[str] = []
        text: list[str] = []
        for line in (*inspect.cleandoc(vars(base).get("__doc__") or "").splitlines(), ""):
            if names and line.startswith("  "):
                text.append(line.strip())
                continue
            yield from ((name, " ".join(text)) for name in names)
            names = _field_names(line, cls)
            text = [re.split(_AFTER_NAMES, line, maxsplit=1)[1].strip()] if names else []


def _field_names(line: str, cls: type[Any]) -> list[str]:
    """The fields that a line of a docstring describes: their names, two blanks or one and a bracket, the meaning."""
    head = re.match(rf"(?P<names>\w+(?:(?:, | and )\w+)*)(?:{_AFTER_NAMES})\S", line)
    names = re.split(r", | and ", head["names"]) if head else []
    return names if names and all(name in keys_of(cls) for name in names) else []
