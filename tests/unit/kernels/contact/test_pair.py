"""Where the rows of a pair are made: at positions that the last forces have pushed on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP1

from contactlab.kernels.contact import pair as kernels
from contactlab.testing.surfaces import curved, pair_of

AT = curved()
MOVED = AT.nodes + np.random.default_rng(1).normal(scale=0.01, size=AT.nodes.shape)


@pytest.fixture
def pair() -> Any:
    """A pair of curved surfaces at its positions."""
    return pair_of(MortarP1(), AT)[0]


def test_place_pushes_by_compliance_times_force_and_sums_lengths(pair: Any) -> None:
    compliance, force = np.random.default_rng(3).uniform(0.0, 0.1, size=(2, *AT.nodes.shape))
    kernels.place(pair.address, MOVED, compliance, force, True)
    x = (MOVED + compliance * force)[AT.slave.nodes]
    np.testing.assert_allclose(pair.at.slave, x, atol=1e-15)
    np.testing.assert_array_equal(pair.measured.slave, MOVED[AT.slave.nodes])
    expected = np.zeros(len(x))
    for i, j in AT.slave.segments:
        expected[[i, j]] += 0.5 * np.hypot(*(x[j] - x[i]))
    np.testing.assert_allclose(pair.coupling.full, expected, atol=1e-15)
