"""Warnings of a run about its own result, each with its number, and the list that keeps them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

__all__ = ["RunWarning", "Warnings"]


@dataclass(frozen=True)
class RunWarning:
    """A sign that a result may be wrong: a number, its limit, its key, and what to change.

    code   kebab-case, one per kind; `docs/warnings.md` lists all
    value  the measured number
    limit  the largest or smallest allowed, in the same unit
    key    of the scene, where the cause can be changed
    text   one sentence: position, the number in its unit, and after a semicolon what to try
    """

    code: str
    value: float
    limit: float
    key: str
    text: str

    def __str__(self) -> str:
        return self.text

    def as_data(self) -> dict[str, Any]:
        """Return the warning as plain data, as it is written to `summary.json`."""
        return asdict(self)

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> RunWarning:
        """Return a warning read from `summary.json`, which writes null for NaN."""
        numbers = {name: math.nan if data[name] is None else float(data[name]) for name in ("value", "limit")}
        return cls(str(data["code"]), key=str(data["key"]), text=str(data["text"]), **numbers)

    @property
    def excess(self) -> float:
        """Distance of the value beyond the limit; infinite if it is not finite."""
        return abs(self.value - self.limit) if math.isfinite(self.value) else math.inf


class Warnings:
    """The warnings of one run: each code and key once, with its worst value.

    Any part of a run may `add` one at any time, to `model.warnings`.
    """

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], RunWarning] = {}
        self._untold: list[tuple[str, str]] = []

    def __iter__(self) -> Iterator[RunWarning]:
        return iter(self._found.values())

    def __len__(self) -> int:
        return len(self._found)

    def add(self, *warnings: RunWarning) -> None:
        """Keep warnings; each replaces a warning of the same code and key unless the older is worse."""
        for warning in warnings:
            name = warning.code, warning.key
            before = self._found.get(name)
            if before is None:
                self._untold.append(name)
            if before is None or warning.excess >= before.excess:
                self._found[name] = warning

    def untold(self) -> list[RunWarning]:
        """Return the warnings added since the last call, with their present values."""
        names, self._untold = self._untold, []
        return [self._found[name] for name in names]

    def keep(self, warnings: Iterable[RunWarning]) -> None:
        """Replace warnings of the same code and key by these."""
        self._found |= {(warning.code, warning.key): warning for warning in warnings}

    def restore(self, warnings: Iterable[RunWarning]) -> None:
        """Restore the warnings of a resumed run, as already reported."""
        self._found = {(warning.code, warning.key): warning for warning in warnings}
        self._untold = []
