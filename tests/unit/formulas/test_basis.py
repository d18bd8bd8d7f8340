"""The shape of a basis, found from its values: breaks and degrees that are known beforehand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import pytest
from contactlab_mortar.mortar import MortarDual, MortarP0, MortarP1

from contactlab.api import formula
from contactlab.formulas.basis import DEGREE, Shape, pieces_of

JUMP = math.nextafter(0.4, 1.0)


@pytest.mark.parametrize(
    ("part", "shape"), [(MortarP0(), ((0.5,), 0)), (MortarP1(), ((), 1)), (MortarDual(), ((), 1))], ids=str
)
def test_shipped_bases_are_integrated_by_one_two_and_two_points(part: Any, shape: Any) -> None:
    assert part.basis_shape == shape


@pytest.mark.parametrize(
    ("basis", "breaks", "degree"),
    [
        (lambda x: (0.0, 0.0), (), 0),
        (lambda x: (1.0 - x * x, x * x), (), 2),
        (lambda x: (1.0, 0.0) if x < 0.4 else (0.0, 1.0), (0.4,), 0),
        (lambda x: (1.0, 0.0) if x <= 0.4 else (0.0, 1.0), (JUMP,), 0),
        (lambda x: (1.0, 0.0) if x < 0.4 else (0.0, 1.0) if x < 0.45 else (x**3, 1.0), (0.4, 0.45), 3),
        (lambda x: (1.0 - x, x) if x < 1.0 else (0.0, 0.5), (1.0,), 1),
    ],
)
def test_polynomials_are_found(basis: Any, breaks: tuple[float, ...], degree: int) -> None:
    assert pieces_of(basis) == Shape(breaks, degree)


def test_a_bend_is_found_to_the_round_off_of_the_fit() -> None:
    """A slope of three that ends: what is integrated wrongly is the square of the distance."""
    shape = pieces_of(lambda x: (min(3.0 * x, 1.0), max(0.0, 1.0 - 3.0 * x)))
    assert shape.breaks == pytest.approx((1.0 / 3.0,), abs=1e-10)
    assert shape.degree == 1


def test_what_is_no_polynomial_has_the_highest_degree() -> None:
    assert pieces_of(lambda x: (math.sqrt(x), 1.0)) == Shape((), DEGREE)


@dataclass(frozen=True)
class Split(MortarP0):
    """Constants that meet where a field of the part says."""

    at: float = 0.25

    @formula
    def basis(xi: Any, p: Any) -> Any:
        """Each end has what lies beside it."""
        return (1.0, 0.0) if xi < p.at else (0.0, 1.0)


def test_a_basis_by_a_field_has_the_shape_of_its_value() -> None:
    assert [Split(at=at).basis_shape.breaks for at in (0.25, 0.7)] == [(0.25,), (0.7,)]
