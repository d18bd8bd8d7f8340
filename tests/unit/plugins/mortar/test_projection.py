"""Points that see each other along the field of normals of a slave segment."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_mortar.projection import (
    MasterSegment,
    SlaveSegment,
    master_parameter,
    opening,
    parameter_beside,
    slave_parameter,
)

ROUND_OFF = 1e-12


def drawn(seed: int) -> tuple[SlaveSegment, MasterSegment]:
    """A slave segment with tilted normals and a master segment below it."""
    draw = np.random.default_rng(seed)
    a, e = draw.uniform(-0.2, 0.2, 2), np.array([1.0, 0.0]) + draw.uniform(-0.2, 0.2, 2)
    first, last = (np.array([np.sin(t), -np.cos(t)]) for t in draw.uniform(-0.3, 0.3, 2))
    c = np.array([1.2, -0.4]) + draw.uniform(-0.1, 0.1, 2)
    f = np.array([-1.4, 0.0]) + draw.uniform(-0.2, 0.2, 2)
    return SlaveSegment(*a, *e, *first, *(last - first)), MasterSegment(*c, *(c + f))


def cross(u: np.ndarray, v: np.ndarray) -> float:
    return float(u[0] * v[1] - u[1] * v[0])


@pytest.mark.parametrize("seed", range(8))
def test_what_a_slave_point_sees_lies_on_its_normal(seed: int) -> None:
    slave, master = drawn(seed)
    a, e, n, m = (np.array(slave[i : i + 2]) for i in (0, 2, 4, 6))
    c, f = np.array(master[:2]), np.array(master[2:]) - master[:2]
    for xi in (0.0, 0.3, 0.8, 1.0):
        eta = master_parameter(xi, slave, master)
        between, normal = c + eta * f - a - xi * e, n + xi * m
        assert abs(cross(between, normal)) < ROUND_OFF
        gap = opening(xi, eta, slave, master)
        assert gap == pytest.approx(float(between @ normal) / np.hypot(*normal), abs=ROUND_OFF)
        assert abs(gap) == pytest.approx(np.hypot(*between), abs=ROUND_OFF)


@pytest.mark.parametrize("seed", range(8))
def test_the_slave_point_that_sees_a_point_is_the_way_back(seed: int) -> None:
    slave, master = drawn(seed)
    c, f = np.array(master[:2]), np.array(master[2:]) - master[:2]
    for xi in (0.1, 0.5, 0.9):
        seen = c + master_parameter(xi, slave, master) * f
        assert slave_parameter(slave, *seen) == pytest.approx(xi, abs=1e-10)


@pytest.mark.parametrize("seed", range(8))
def test_a_point_beside_is_seen_from_outside_on_its_own_side(seed: int) -> None:
    """With the side told, which spares the root, overlaps begin and end where they do without."""
    slave, master = drawn(seed)
    for xi in (-0.9, -0.2, 1.1, 1.7):
        c, f = np.array(master[:2]), np.array(master[2:]) - master[:2]
        seen, side = c + master_parameter(xi, slave, master) * f, -1 if xi < 0.0 else 1
        assert np.clip(parameter_beside(slave, side, *seen), 0.0, 1.0) == np.clip(
            slave_parameter(slave, *seen), 0.0, 1.0
        )
        assert parameter_beside(slave, side, *seen) == 2.0 * side
        # a side that the root does not confirm is not taken for one
        assert parameter_beside(slave, -side, *seen) == slave_parameter(slave, *seen)


def test_with_one_normal_it_is_the_foot_of_the_perpendicular() -> None:
    assert slave_parameter(SlaveSegment(0.0, 0.0, 2.0, 0.0, 0.0, -1.0, 0.0, 0.0), 0.5, -3.0) == pytest.approx(
        0.25, abs=ROUND_OFF
    )


def test_a_point_that_no_normal_reaches_has_no_parameter() -> None:
    """The quadratic -2 - xi^2 = 0 of this point has no root."""
    slave = SlaveSegment(0.0, 0.0, 1.0, 0.0, 1.0, -1.0, -2.0, -1.0)
    assert np.isnan(slave_parameter(slave, -1.0, -1.0))
    assert np.isnan(parameter_beside(slave, -1, -1.0, -1.0))
