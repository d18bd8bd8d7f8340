"""Differences of the runs of a comparison, except algorithm, slave and level, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def varied_text(choices: Mapping[str, Any]) -> str:
    """Values by the ends of their keys: "mu 0.2, use newton"; empty if nothing else varies."""
    return ", ".join(f"{_short(key, choices)} {_value(value)}" for key, value in choices.items())


def _short(key: str, choices: Mapping[str, Any]) -> str:
    """The end of a key, as much of it as no other varied key has."""
    parts = key.split(".")
    for count in range(1, len(parts)):
        end = ".".join(parts[-count:])
        if sum(other == end or other.endswith(f".{end}") for other in choices) == 1:
            return end
    return key


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return " ".join([str(value.get("use", "")), *(f"{k}={v}" for k, v in value.items() if k != "use")]).strip()
    return f"{value:g}" if isinstance(value, float) else str(value)
