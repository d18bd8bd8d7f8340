"""Angles at ends of chains that are pressed, on broken lines."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.api import ContactCurve, Floats, Ints
from contactlab.results.chain_ends import angle_at_ends, turn_at_ends

TURN = 0.01


def curve(pressed: list[float], chain: Ints | None = None) -> ContactCurve:
    """Segments of length 1, each turned by 0.01 from the one before, the first one by half of that below y = 0."""
    angle = TURN * (np.arange(len(pressed) - 1) - 0.5)
    x = np.concatenate([[0.0], np.cumsum(np.cos(angle))])
    y = np.concatenate([[0.0], np.cumsum(np.sin(angle))])
    force: Floats = np.array(pressed)
    none, number = 0.0 * x, np.zeros(len(x), np.int32)
    return ContactCurve(x, x, y, force, none, force, none, number, number if chain is None else chain)


@pytest.mark.parametrize("pressed", [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0]])
def test_a_corner_that_touches_alone_has_the_turn_beside_it(pressed: list[float]) -> None:
    assert turn_at_ends(curve(pressed)) == pytest.approx(TURN, rel=1e-9)


def test_an_end_counts_by_its_share_of_the_force() -> None:
    """Nodes at ends have half a segment: 2 * 0.5 of a force of 2 * 0.5 + 3 * 1."""
    assert turn_at_ends(curve([2.0, 3.0, 0.0, 0.0])) == pytest.approx(0.25 * TURN, rel=1e-9)


def test_nodes_between_ends_have_none() -> None:
    assert turn_at_ends(curve([0.0, 1.0, 0.0, 0.0])) == 0.0
    assert turn_at_ends(curve([0.0, 0.0, 0.0, 0.0])) == 0.0


def test_chains_end_where_their_number_changes() -> None:
    chain = np.array([0, 0, 0, 1, 1, 1], np.int32)
    assert turn_at_ends(curve([0.0, 0.0, 1.0, 1.0, 0.0, 0.0], chain)) == pytest.approx(TURN, rel=1e-9)
    lines = np.array([0, 0, 1, 1], np.int32)  # of one segment each, which nothing turns from
    assert turn_at_ends(curve([1.0, 1.0, 1.0, 1.0], lines)) == 0.0


@pytest.mark.parametrize("lean", [0.0, 0.06, -0.3])
def test_surfaces_part_by_the_lean_of_the_body(lean: float) -> None:
    """The master runs the other way; its segments far from the corner do not count."""
    master = np.array(
        [[9.0, 9.0], [0.5 * np.cos(lean), 0.5 * np.sin(lean)], [-0.5 * np.cos(lean), -0.5 * np.sin(lean)]]
    )
    segments = np.array([[0, 1], [1, 2]], np.int32)
    found = angle_at_ends(curve([1.0, 0.0, 0.0]), master, segments)
    assert found == pytest.approx(abs(lean + 0.5 * TURN), rel=1e-9)
    assert angle_at_ends(curve([0.0, 1.0, 0.0]), master, segments) == 0.0
