"""Algorithms are compared with each other on runs that differ in nothing else."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from contactlab.results.results import ContactCurve
from contactlab.studies.table import Row
from contactlab.studies.table_files import agreements

X = np.linspace(-1.0, 1.0, 21)
P = 1.0 - X**2


def test_pairs_share_everything_but_the_algorithm(curve_of: Callable[..., ContactCurve]) -> None:
    def row(algorithm: str, swap: bool, factor: float, status: str = "finished") -> Row:
        varied = {"contacts.0.algorithm": algorithm, "contacts.0.swap": swap}
        measures = {"reaction": 100.0 * factor}
        slave = "b" if swap else "a"
        return Row("", algorithm, slave, 1, varied, status, "", measures, curve=curve_of(X, factor * P))

    rows = [
        row("one", False, 1.0),
        row("one", True, 1.0),
        row("two", False, 1.02),
        row("two", True, 0.98, "not-converged"),
        row("three", False, 5.0, "diverged"),
    ]
    first, second = agreements(rows)
    assert (first.first, first.second, first.slave) == ("one", "two", "a")
    assert first.reaction == pytest.approx(2 * 0.02 / 2.02)
    assert first.pressure == pytest.approx(2 * 0.02 / 2.02)
    assert (second.slave, second.reaction) == ("b", pytest.approx(2 * 0.02 / 1.98))


def test_a_run_that_stopped_under_half_of_the_load_is_not_compared(curve_of: Callable[..., ContactCurve]) -> None:
    """Statics have no other state than that at which they stopped; runs in time may be loaded and not settled."""
    whole = Row("", "one", "a", 1, {}, "finished", "", curve=curve_of(X, P))
    for share, compared in ((0.5, 0), (1.0, 1)):
        other = Row("", "two", "a", 1, {}, "not-converged", "", curve=curve_of(X, P), share=share)
        assert len(agreements([whole, other])) == compared


def test_one_algorithm_has_nothing_to_agree_with(curve_of: Callable[..., ContactCurve]) -> None:
    rows = [Row("", "one", "a", level, {"level": level}, "finished", "", curve=curve_of(X, P)) for level in (1, 2)]
    assert agreements(rows) == []
