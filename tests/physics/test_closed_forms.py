"""Closed forms of cases against others that are known independently; nothing is run."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_cases.fourth_power import HALF
from contactlab_cases.indenters import MODULUS, half_width_of, pressure
from contactlab_cases.rings import TwoRings, shrunk_rings
from contactlab_cases.rounded_punch import RoundedPunch
from contactlab_cases.shrink_fit import POISSON, RADII, YOUNG, ShrinkFit

STEEL = (70000.0, 0.3)


def test_flat_punches_add_up_to_hertz() -> None:
    """h = x^2/(2 R): F = pi c^2/(4 R), and p = E* (b^2 - x^2)^(1/2)/(2 R)."""
    radius, b = 10.0, 0.2
    x = np.linspace(-b, b, 11)
    found = pressure(x, b, lambda c: np.full_like(c, 0.5 * np.pi / radius))
    assert found == pytest.approx(MODULUS * np.sqrt(np.maximum(0.0, b**2 - x**2)) / (2.0 * radius), abs=1e-9)
    force = MODULUS * np.pi * b**2 / (4.0 * radius)
    assert half_width_of(force, lambda c: 0.25 * np.pi * c**2 / radius, 1.0) == pytest.approx(b, rel=1e-9)


def test_a_rounded_punch_carries_what_its_pressure_adds_up_to() -> None:
    """The quadrature of the pressure is P(b), and without a flat part the punch is Hertz's cylinder."""
    case = RoundedPunch()
    a, b = case.flat * HALF, HALF
    # x = b sin t takes the root at the edge out of the integrand; the kinks at +-a are left, of fourth order here
    t = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 20001)
    p = pressure(b * np.sin(t), b, lambda c: np.arccos(np.minimum(1.0, a / c)) / case.radius, a)
    total = float(np.trapezoid(p * b * np.cos(t), t))
    assert total == pytest.approx(MODULUS * float(case.total(np.asarray(b))), rel=1e-5)  # 40 points on a root
    round_one = RoundedPunch(flat=0.0)
    assert float(round_one.total(np.asarray(b))) == pytest.approx(0.25 * np.pi * b**2 / round_one.radius, rel=1e-12)


def test_rings_agree_with_published_pressures() -> None:
    """A disc in a ring of its material is one disc; two shrunk rings are Lame's; a split ring adds nothing."""
    disc = TwoRings(0.0, 0.6, 1.0, STEEL, STEEL)
    assert disc.pressure(1.0, 0.0)[0] == pytest.approx(1.0, rel=1e-12)
    a, b, c = RADII
    both = shrunk_rings([(a, b), (b, c)], [(YOUNG, POISSON)] * 2, [1e-3 * b])
    assert both[0] == pytest.approx(ShrinkFit(interference=1e-3).exact(), rel=1e-12)
    # a third ring that is not shrunk on at all, cut from the outer one: the pressure in the first joint is the same
    cut = shrunk_rings([(a, b), (b, 0.8), (0.8, c)], [(YOUNG, POISSON)] * 3, [1e-3 * b, 0.0])
    assert cut[0] == pytest.approx(both[0], rel=1e-12)
