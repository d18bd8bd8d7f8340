"""Averaged normals of a slave and their derivatives."""

from __future__ import annotations

import numpy as np
from contactlab_mortar.mortar import MortarP1
from dense_pieces import AGREED, SURFACES, along, central, derivatives_of, drawn_move

from contactlab.formulas.segment_normals import inward_normals
from contactlab.testing.surfaces import curved


def test_inward_normals_are_averages_weighted_by_length() -> None:
    at = curved()
    x, segments, out = at.nodes[at.slave.nodes], at.slave.segments, np.zeros((len(at.slave.nodes), 2))
    longest = inward_normals(x, segments, out)
    edge = x[segments[:, 1]] - x[segments[:, 0]]
    expected = np.zeros_like(out)
    for (i, j), (ex, ey) in zip(segments, edge, strict=True):
        expected[[i, j]] -= (ey, -ex)  # the outward normal times the length, turned inward
    expected /= np.hypot(*expected.T)[:, None]
    np.testing.assert_allclose(out, expected, atol=1e-15)
    assert longest == np.hypot(*edge.T).max()


def test_derivatives_of_normals_are_their_central_differences() -> None:
    at = SURFACES["curved"]
    found, pieces, _, view = derivatives_of(MortarP1(), at)
    move, count = drawn_move(at), found.normal_count
    change = np.zeros_like(pieces.normal)
    step = along(view, at, found.normal_moved[:count], move)
    np.add.at(change, found.normal_of[:count], step[:, None] * found.dnormal[:count])
    np.testing.assert_allclose(change, central(MortarP1(), at, move)[3], atol=AGREED)
