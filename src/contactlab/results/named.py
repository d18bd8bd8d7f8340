"""Dictionaries whose KeyError names the nearest name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from contactlab.errors import did_you_mean

T = TypeVar("T")
MOST = 12
"""Names in a message."""


class UnknownName(KeyError):
    """A name that is not there; prints as a sentence."""

    def __str__(self) -> str:
        return str(self.args[0])


def unknown(what: str, name: object, known: list[str], hint: str = "") -> UnknownName:
    """The error for a name that none of the known ones is."""
    shown = ", ".join(known[:MOST]) + (f" and {len(known) - MOST} more" if len(known) > MOST else "")
    hint = did_you_mean(str(name), known) or hint
    return UnknownName(
        f"no {what} {name!r}" + (f"; {hint}" if hint else "") + (f"; there are: {shown}" if known else "")
    )


class Named(dict[str, T]):
    """A dictionary of `what`, "history column"; `hint` says why it may be empty, `same` gives other names of keys."""

    what: str
    hint: str
    same: Mapping[str, str]

    @classmethod
    def of(cls, what: str, values: Mapping[str, T], hint: str = "", same: Mapping[str, str] | None = None) -> Named[T]:
        """The same values with messages about `what`."""
        made = cls(values)
        made.what, made.hint, made.same = what, hint, same or {}
        return made

    def __missing__(self, name: str) -> T:
        if self.same.get(name) in self:
            return self[self.same[name]]
        raise unknown(self.what, name, [str(known) for known in self], self.hint)
