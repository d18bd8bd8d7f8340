"""Arc lengths along contact surfaces of one chain and of several."""

from __future__ import annotations

import csv
from itertools import pairwise
from pathlib import Path

import numpy as np

from contactlab import load_scene, simulate
from contactlab.api import ContactCurve
from contactlab.results.contact_report import ContactReport, arc_length

SQUARE = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0.0, 4.0]])


def segments(*paths: list[int]) -> np.ndarray:
    return np.array([pair for path in paths for pair in pairwise(path)], np.int32)


def test_one_chain_has_the_lengths_of_its_segments() -> None:
    found = arc_length(SQUARE, segments([0, 1, 2, 3]))
    assert found.s.tolist() == [0.0, 3.0, 7.0, 10.0]
    assert found.chain.tolist() == [0, 0, 0, 0]


def test_a_chain_goes_on_where_the_one_before_it_ends() -> None:
    positions = np.concatenate([SQUARE, SQUARE + 100.0])
    found = arc_length(positions, segments([0, 1, 2, 3], [4, 5, 6, 7]))
    assert found.s.tolist() == [0.0, 3.0, 7.0, 10.0, 10.0, 13.0, 17.0, 20.0]
    assert found.chain.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]


def test_closed_chains_count_the_segment_that_closes_them() -> None:
    positions = np.concatenate([SQUARE, SQUARE, SQUARE])
    found = arc_length(positions, segments([0, 1, 2, 3, 0], [8, 9, 10, 11], [4, 5, 6, 7, 4]))
    # the open chain first, then the closed ones of 14 mm each
    assert found.s.tolist() == [10.0, 13.0, 17.0, 20.0, 24.0, 27.0, 31.0, 34.0, 0.0, 3.0, 7.0, 10.0]
    assert found.chain.tolist() == [1] * 4 + [2] * 4 + [0] * 4


def test_segments_may_come_in_any_order() -> None:
    path = segments([3, 1, 0, 2])
    expected = arc_length(SQUARE, path)
    found = arc_length(SQUARE, path[[2, 0, 1]])
    assert found.s.tolist() == expected.s.tolist() == [8.0, 5.0, 13.0, 0.0]


def test_flanks_of_a_corner_follow_one_another(tmp_path: Path) -> None:
    """Two flanks of 10 mm meet in the corner of the slave: s runs from 0 to 20 and tells them apart by their chain."""
    scene = load_scene("vertex-to-vertex").with_({"contacts.0.algorithm": "mortar-p0", "time.end": 1e-7})
    curve = simulate(scene, out=tmp_path / "run").contact["contacts.0"].last
    # of a mesh of unit squares that is turned: round-off of its nodes
    assert np.abs(curve.s - [*range(11), *range(10, 21)]).max() < 1e-13
    assert curve.chain.tolist() == [0] * 11 + [1] * 11
    with (tmp_path / "run" / "contact.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["chain"]) for row in rows] == curve.chain.tolist()
    assert [float(row["s"]) for row in rows] == curve.s.tolist()


def test_what_is_pressed_on_two_chains_is_two_intervals() -> None:
    """Nodes that follow one another in the list lie far apart where one chain ends and the next begins."""
    x, one = np.array([0.0, 1.0, 50.0, 51.0]), np.ones(4)
    chain = np.array([0, 0, 1, 1], np.int32)
    curve = ContactCurve(x, x, 0.0 * x, one, 0.0 * x, one, 0.0 * x, np.full(4, 2, np.int32), chain)
    report = ContactReport(curve, np.zeros(2), np.zeros(2), np.zeros(2), 0.0, "", 0.0, 0.0, 0.0, 0.0, 4, 0)
    assert report.intervals == [[[0.0, 0.0], [1.0, 0.0]], [[50.0, 0.0], [51.0, 0.0]]]
