"""The contact record of several contacts, put together block by block."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np


def blocks_of(sources: Mapping[str, Sequence[np.ndarray]]) -> Iterator[dict[str, np.ndarray]]:
    """The record of all contacts, block after block, as a recorder is given it."""
    at_once = {name: iter(source) for name, source in sources.items()}
    waiting: dict[str, np.ndarray] = {}
    while sources:
        for name, source in at_once.items():
            if not len(waiting.get(name, ())):
                waiting[name] = next(source, np.zeros(0))
        size = min(len(rows) for rows in waiting.values())
        if not size:
            return
        yield {name: rows[:size] for name, rows in waiting.items()}
        waiting = {name: rows[size:] for name, rows in waiting.items()}
