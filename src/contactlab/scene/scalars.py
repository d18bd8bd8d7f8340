"""Single values of a scene file: numbers, texts, paths and choices, checked as they are written."""

from __future__ import annotations

import math
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from contactlab.errors import Location, SceneError, Where, did_you_mean
from contactlab.scene.accepts import in_words

LARGEST = 2**63 - 1  # TOML's largest integer
GREATEST = 1e150  # of a measured number: its square, such as a kinetic energy, is a number still


def choice(hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> Any:
    """The member of a Literal that was written. Raises SceneError for any other value."""
    choices = get_args(hint)
    for known in choices:
        if value == known and type(value) is type(known):
            return known
    hint_text = did_you_mean(value, [str(known) for known in choices]) if isinstance(value, str) else ""
    allowed = in_words(limits.get("options", hint), limits)
    raise SceneError("not one of the choices", where=where, got=value, allowed=allowed, hint=hint_text)


def scalar(hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> Any:
    """A number within its `limits`, a string, a path or a boolean. Raises SceneError for any other value."""
    if hint in (int, float):
        return _number(hint, value, where, limits)
    if isinstance(value, str | Path):
        _check_characters(str(value), where)
    if hint is Path and isinstance(value, str | Path):
        # relative paths start where the text that names them lies
        folder = where.folder if isinstance(where, Location) else ""
        return (Path(folder) / value).resolve()
    if isinstance(hint, type) and isinstance(value, hint):
        return value
    tip = "write booleans without quotes: true, false" if hint is bool and isinstance(value, str) else ""
    raise SceneError("wrong type", where=where, got=value, allowed=_allowed(hint, limits), hint=tip)


def _allowed(hint: Any, limits: Mapping[str, Any]) -> str:
    return in_words(limits.get("options", hint), limits)


def _check_characters(text: str, where: Where) -> None:
    """Raise SceneError for what no file can keep: NUL, and halves of characters (bytes that are not UTF-8)."""
    bad = next((c for c in text if c == "\0" or "\ud800" <= c <= "\udfff"), None)
    if bad is not None:
        raise SceneError(
            f"no file can store the character {bad!a}", where=where, got=ascii(text), allowed="UTF-8 text without NUL"
        )


def _number(hint: type, value: Any, where: Where, limits: Mapping[str, Any]) -> float | int:
    if isinstance(value, bool) or not isinstance(value, int | float) or (hint is int and isinstance(value, float)):
        allowed = _allowed(hint, limits)
        raise SceneError("wrong type", where=where, got=value, allowed=allowed, hint=_number_hint(hint, value))
    try:
        number = hint(value)
    except OverflowError:
        number = math.inf
    if hint is float and not math.isfinite(number):
        raise SceneError("the number is not finite", where=where, got=value, allowed=_allowed(hint, limits))
    if hint is float and abs(number) > GREATEST:
        allowed = f"{_allowed(hint, limits)}, of a size up to {GREATEST:g}"
        raise SceneError("the number is out of bounds", where=where, got=value, allowed=allowed)
    if hint is int and abs(number) > LARGEST:
        allowed = f"{_allowed(hint, limits)}, below 2^63"
        raise SceneError("the number is out of bounds", where=where, got=value, allowed=allowed)
    if not _within(number, limits):
        raise SceneError("the number is out of bounds", where=where, got=value, allowed=_allowed(hint, limits))
    return typing.cast("float | int", number)


def _number_hint(hint: type, value: Any) -> str:
    if isinstance(value, float) and value.is_integer():
        return f"write {int(value)}"
    if isinstance(value, str):
        try:
            float(value)
        except ValueError:
            return ""
        return f"write {value} without quotes"
    return ""


def _within(number: float, limits: Mapping[str, Any]) -> bool:
    above, least, most = limits.get("above"), limits.get("least"), limits.get("most")
    return (above is None or number > above) and (least is None or number >= least) and (most is None or number <= most)
