"""Mortar contact of a slave that slides over a corner of the master: what its forces add up to is told."""

from __future__ import annotations

import numpy as np
import pytest

import contactlab
from contactlab.results.results import Results


def slid(**changes: object) -> Results:
    """A slider that leaves its base over the edge."""
    shown = {"record.frames": 100, "record.recorders": []}
    results = contactlab.simulate(contactlab.load_scene("corner-slide").with_({**changes, **shown}))
    assert results.status == "finished", results.reason
    return results


def test_a_corner_that_holds_up_a_mortar_is_told_with_the_side_to_exchange() -> None:
    """The slider presses with 4 N and tips: exchanged, forces stay at that; over the corner they are twice as large."""
    leaning, right = slid(), slid(**{"contacts.0.swap": True})
    (warning,) = leaning.warnings
    assert (warning.code, warning.key) == ("leaning-forces", "contacts.0.swap")
    assert "near (10" in warning.text  # the edge of the base
    assert right.warnings == []
    largest = [np.abs(results.history["contacts.0.fy"]).max() for results in (leaning, right)]
    # 5 %: vibrations of the block when it is put down
    assert largest[1] == pytest.approx(4.0, rel=0.06)
    assert largest[0] > 1.5 * largest[1]
