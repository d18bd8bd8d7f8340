"""Files and page of a study of cases, rewritten while points come."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from time import monotonic

from contactlab.accuracy.evaluation import Evaluation, evaluate
from contactlab.accuracy.files import write
from contactlab.accuracy.run import Accuracy

LEAST = 3.0
"""Wall time [s] from one writing of the page to the next, at least."""
SHARE = 0.05
"""Largest share of the time that is spent on writing it."""


def import_what_draws() -> None:
    """Libraries that draw the page: seconds where Python has not compiled them yet, for which no point should wait."""
    import_module("contactlab.reports.accuracy_page")


def write_all(evaluated: Evaluation, folder: Path, figures: bool = True) -> None:
    """Tables as CSV and JSON, the page, and its `figures` as files of their own."""
    from contactlab.reports.accuracy_page import write_accuracy_page

    write(evaluated, folder)
    write_accuracy_page(evaluated, folder, files=figures)


class SoFar:
    """Rewrites the page of a study while points come, unless that was done shortly before."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.next = 0.0

    def __call__(self, found: Callable[[], Accuracy]) -> None:
        """Write what there is."""
        began = monotonic()
        if began < self.next:
            return
        write_all(evaluate(found()), self.folder, figures=False)
        if not self.next:
            print(
                f"page so far, rewritten as points come: {self.folder / 'accuracy.html'}", file=sys.stderr, flush=True
            )
        now = monotonic()
        self.next = now + max(LEAST, (now - began) / SHARE)
