"""Scenarios: whole runs that a part is put into, and what must come out of them; plain functions of a `Subject`."""

from __future__ import annotations

import importlib
from collections.abc import Callable

from contactlab.api.part import KINDS
from contactlab.testing.subject import Subject

Scenario = Callable[[Subject], None]
"""A check of one part in whole runs; it fails and declines as unit checks do."""


def scenarios_for(kind: str) -> tuple[Scenario, ...]:
    """The scenarios of a kind; none for any other string."""
    if kind not in KINDS:
        return ()
    table: dict[str, tuple[Scenario, ...]] = importlib.import_module(f"{__name__}.by_kind").SCENARIOS
    return table.get(kind, ())
