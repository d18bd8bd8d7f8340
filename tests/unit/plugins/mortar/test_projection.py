"""Points that see each other along the field of normals of a slave segment."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.api import Vector
from contactlab.api.segments import MasterSegment, SlaveSegment

ROUND_OFF = 1e-12


def drawn(seed: int) -> tuple[SlaveSegment, MasterSegment]:
    """A slave segment with tilted normals and a master segment below it."""
    draw = np.random.default_rng(seed)
    a, e = draw.uniform(-0.2, 0.2, 2), np.array([1.0, 0.0]) + draw.uniform(-0.2, 0.2, 2)
    first, last = (np.array([np.sin(t), -np.cos(t)]) for t in draw.uniform(-0.3, 0.3, 2))
    c = np.array([1.2, -0.4]) + draw.uniform(-0.1, 0.1, 2)
    f = np.array([-1.4, 0.0]) + draw.uniform(-0.2, 0.2, 2)
    return SlaveSegment(*(Vector(*x) for x in (a, e, first, last - first))), MasterSegment(Vector(*c), Vector(*(c + f)))


@pytest.mark.parametrize("seed", range(8))
def test_what_a_slave_point_meets_lies_on_its_normal_and_sees_it(seed: int) -> None:
    slave, master = drawn(seed)
    for xi in (-0.2, 0.1, 0.5, 0.9, 1.2):
        met = master.at(slave.meets(master, xi))
        assert abs((met - slave.at(xi)).cross(slave.normal_at(xi))) < ROUND_OFF
        assert slave.sees(met) == pytest.approx(xi, abs=1e-10)


def test_with_one_normal_it_is_the_foot_of_the_perpendicular() -> None:
    slave = SlaveSegment(Vector(0.0, 0.0), Vector(2.0, 0.0), Vector(0.0, -1.0), Vector(0.0, 0.0))
    assert slave.sees(Vector(0.5, -3.0)) == pytest.approx(0.25, abs=ROUND_OFF)


def test_a_point_that_no_normal_reaches_is_seen_from_nowhere() -> None:
    """The quadratic -2 - xi^2 = 0 of this point has no root."""
    slave = SlaveSegment(Vector(0.0, 0.0), Vector(1.0, 0.0), Vector(1.0, -1.0), Vector(-2.0, -1.0))
    xi = slave.sees(Vector(-1.0, -1.0))
    assert math.isnan(xi)
    for pair in ((xi, 0.5), (0.5, xi)):
        low, high = slave.between(*pair)
        assert low > high


def test_parts_are_cut_to_the_segment() -> None:
    slave, _ = drawn(0)
    assert slave.between(1.7, 0.3) == (0.3, 1.0)
    assert slave.between(-0.4, 0.6) == (0.0, 0.6)
    low, high = slave.between(1.2, 1.9)
    assert low > high
