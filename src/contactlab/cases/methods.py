"""Contact methods by name: "mortar-p1", "gauss-point passes=2 + linear-pressure", "mortar-p0 + penalty factor=10".

A method is a contact algorithm, and an enforcement if it has one of its own. Fields follow the name of their part.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from contactlab.errors import RequestError, did_you_mean
from contactlab.parts.registry import Registry

FILE = Path(__file__).parent.parent / "data" / "methods.toml"
PLUS = " + "
KINDS = ("contact", "enforcement")


def method_name(algorithm: Any, enforcement: Any = "") -> str:
    """The name of a method."""
    return PLUS.join(_label(spec) for spec in (algorithm, enforcement) if spec)


def _label(spec: Any) -> str:
    if not isinstance(spec, Mapping):
        return str(spec)
    return " ".join([str(spec.get("use", "")), *(f"{k}={v}" for k, v in spec.items() if k != "use")])


def method_of(name: str, registry: Registry, where: str) -> tuple[Any, Any]:
    """The algorithm and the enforcement ("" for none) of a name. Raises RequestError for parts that are not there."""
    found: list[Any] = []
    for kind, words in zip(KINDS, name.split(PLUS), strict=False):
        use, *fields = words.split()
        if use not in registry.names(kind):
            raise RequestError(
                f"no {kind} of this name is installed", where=f"{where}, {kind}", got=use,
                allowed=", ".join(registry.names(kind)),
                hint=registry.missing_from(use) or did_you_mean(use, registry.names(kind)),
            )  # fmt: skip
        found.append({"use": use, **dict(map(_field, fields))} if fields else use)
    return found[0], found[1] if len(found) > 1 else ""


def _field(word: str) -> tuple[str, Any]:
    name, _, value = word.partition("=")
    try:
        return name, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return name, value


def methods(registry: Registry, variants: bool = False) -> list[str]:
    """All installed contact algorithms, and methods of `FILE` whose parts are installed, with `variants` of them."""
    known: dict[str, list[str]] = tomllib.loads(FILE.read_text(encoding="utf-8"))
    there = [
        name for name in known["methods"] + (known["variants"] if variants else [])
        if all(words.split()[0] in registry.names(kind) for kind, words in zip(KINDS, name.split(PLUS), strict=False))
    ]  # fmt: skip
    return [*registry.names("contact"), *there]
