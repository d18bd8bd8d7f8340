"""Closed forms of cases against others that are known independently; nothing is run."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_cases.driven_layers import WAVE_NUMBER, exact_wave
from contactlab_cases.fourth_power import HALF
from contactlab_cases.indenters import MODULUS, half_width_of, pressure
from contactlab_cases.interface_waves import compliance, growth_and_speed, opening, sliding_wave
from contactlab_cases.rings import TwoRings, shrunk_rings
from contactlab_cases.rounded_punch import RoundedPunch
from contactlab_cases.shrink_fit import POISSON, RADII, YOUNG, ShrinkFit
from contactlab_cases.sliding_punch import exponent, sliding_pressure

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


def test_rings_that_stick_are_one_body_where_they_are_of_one_material() -> None:
    """A full disc under cos 2t: phi = (r^2/2 - r^4/(6 c^2)) cos 2t, s_r = -1 and s_rt = 1 - r^2/c^2 everywhere."""
    mean, wave, shear = TwoRings(0.0, 0.6, 1.0, STEEL, STEEL).bonded(1.0, 0.5)
    assert (mean, wave, shear) == pytest.approx((1.0, 0.5, 0.5 * (1.0 - 0.6**2)), rel=1e-12)
    # a ring cut at two radii: the outer part of it carries the same whatever is cut off below
    inner, outer = (TwoRings(0.2, cut, 1.0, STEEL, STEEL).bonded(0.0, 1.0)[1:] for cut in (0.2 + 1e-9, 1.0 - 1e-9))
    assert inner == pytest.approx((0.0, 0.0), abs=1e-6)  # the hole is free
    assert outer == pytest.approx((1.0, 0.0), abs=1e-6)  # and the outside bears the load


def test_a_punch_that_slides_leaves_the_surface_flat() -> None:
    """Johnson 2.24: int p(s)/(x - s) ds = pi mu (1 - 2 nu)/(2 (1 - nu)) p(x), s = cos t."""
    mu, poisson = 0.6, 0.2
    t = (np.arange(20000) + 0.5) * np.pi / 20000
    s, g = np.cos(t), exponent(mu, poisson)
    p = sliding_pressure(s, 1.0, 1.0, g)
    assert float((p * np.sin(t)).mean()) * np.pi == pytest.approx(1.0, rel=1e-3)  # a root at either end
    for x in (-0.5, 0.1, 0.6):
        own = float(sliding_pressure(np.array([x]), 1.0, 1.0, g)[0])
        # the integral of (1 - s^2)^(-1/2)/(x - s) is none: a flat punch without friction
        found = np.mean((p * np.sin(t) - own * np.sqrt(1.0 - x**2)) / (x - s)) * np.pi
        assert found / own == pytest.approx(np.pi * mu * (1.0 - 2.0 * poisson) / (2.0 * (1.0 - poisson)), rel=0.01)


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


def test_the_surface_of_a_half_plane_answers_waves_as_it_should() -> None:
    """At rest (1 - nu)/(G k) under a pressure (Johnson 13.2), none but at 0.8740, the Rayleigh speed at nu = 0."""
    slow = compliance(complex(1e-3, 0.0), 2.0, 1.0)
    assert slow[1, 1] == pytest.approx(-0.5, rel=1e-5)
    assert slow[1, 0] == pytest.approx(0.25j, rel=1e-5)  # (1 - 2 nu)/(2 G k), a quarter of a wave off
    rayleigh = np.sqrt(3.0 - np.sqrt(5.0))  # root of (2 - c^2)^4 = 16 (1 - c^2)(1 - c^2/2)
    assert rayleigh == pytest.approx(0.8740, abs=1e-4)
    below, above = (compliance(complex(0.0, -rayleigh * f), 1.0, 1.0)[1, 1].real for f in (1.0 - 1e-6, 1.0 + 1e-6))
    assert below * above < 0.0
    assert min(abs(below), abs(above)) > 1e4


def test_sliding_waves_grow_with_any_friction_and_the_faster_the_shorter() -> None:
    """Ranjith & Rice 2001: where the generalised Rayleigh wave exists, a small mu makes it grow in proportion to mu."""
    free = sliding_wave(1.44, 0.0)
    assert free.real == pytest.approx(0.0, abs=1e-12)
    assert 0.8740 < -free.imag < 1.0  # between the upper layer's Rayleigh and shear waves
    small, twice = sliding_wave(1.44, 1e-3), sliding_wave(1.44, 2e-3)
    assert small.real > 1e-6
    assert twice.real == pytest.approx(2.0 * small.real, rel=1e-3)
    assert abs(opening(sliding_wave(1.44, 0.9), 1.44, 0.9)) < 1e-9
    with pytest.raises(ArithmeticError, match="Rayleigh"):
        sliding_wave(1.0, 0.3)


def test_a_driven_wave_becomes_the_free_one() -> None:
    times = np.linspace(14.0, 18.0, 100)
    growth, speed = growth_and_speed(WAVE_NUMBER * times, exact_wave(times, 1.44, 0.9))
    exact = sliding_wave(1.44, 0.9)
    assert growth == pytest.approx(exact.real, rel=0.01)
    assert speed == pytest.approx(-exact.imag, rel=0.002)
