"""Progress of a run in a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable
from html import escape
from importlib import import_module
from time import monotonic
from typing import Any

PATIENCE = 0.2  # s between two pictures of a bar


def in_notebook() -> bool:
    """Return whether a Jupyter kernel runs this process."""
    return "ipykernel" in sys.modules and "IPython" in sys.modules


def notebook_bar(title: str) -> Callable[[float, int, float, float], None]:
    """A bar that is drawn over itself: call it with fraction done, step, time [s] and energy error."""
    ipython: Any = import_module("IPython.display")
    handle = ipython.display(ipython.HTML(_bar(title, 0.0, "building the model")), display_id=True)
    last = [monotonic()]

    def show(fraction: float, step: int, time: float, energy_error: float) -> None:
        if fraction < 1.0 and monotonic() - last[0] < PATIENCE:
            return
        last[0] = monotonic()
        words = f"{100.0 * fraction:.0f} %, step {step}, t = {time:.3e}, energy error {energy_error:.0e}"
        handle.update(ipython.HTML(_bar(title, fraction, words)))

    return show


def _bar(title: str, fraction: float, words: str) -> str:
    return f'<b>{escape(title)}</b> <progress max="1" value="{fraction:.4f}"></progress> {escape(words)}'
