"""Each measure against its closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactlab.studies import measures
from contactlab.studies.profile import Profile

ROUND_OFF = 1e-12


def parabola(n: int, half_width: float = 1.0, shift: float = 0.0) -> Profile:
    x = np.linspace(-half_width, half_width, n) + shift
    return Profile(x, 1.0 - ((x - shift) / half_width) ** 2)


def tent(centre: float, half_width: float = 1.0, height: float = 1.0) -> Profile:
    return Profile(centre + half_width * np.array([-1.0, 0.0, 1.0]), height * np.array([0.0, 1.0, 0.0]))


def test_pressure_error_of_a_scaled_pressure_is_the_scale() -> None:
    p = parabola(41)
    assert measures.pressure_error(Profile(p.x, 1.03 * p.value), p) == pytest.approx(0.03, rel=1e-9)


def test_pressure_error_of_an_interpolant_is_the_interpolation_error() -> None:
    # On a parabola of second derivative -2 each segment h leaves h^5/30 of squared error; 2/h segments.
    h = 0.125
    fine = parabola(4097)
    expected = math.sqrt(2.0 / h * h**5 / 30.0) / math.sqrt(16.0 / 15.0)
    # the reference itself is an interpolant with a (h / 512)^2 smaller error
    assert measures.pressure_error(parabola(17), fine) == pytest.approx(expected, rel=1e-4)


def test_pressure_error_counts_only_the_window() -> None:
    p = parabola(41)
    wrong_outside = Profile(p.x, np.where(np.abs(p.x) > 0.5, 3.0, p.value))
    assert measures.pressure_error(wrong_outside, p, (-0.45, 0.45)) == pytest.approx(0.0, abs=ROUND_OFF)
    assert measures.pressure_error(wrong_outside, p) > 0.5


def test_largest_error_looks_inside_the_edge_only() -> None:
    p = parabola(41)
    wrong = p.value.copy()
    wrong[20] += 0.07
    wrong[1] += 0.5
    assert measures.largest_pressure_error(Profile(p.x, wrong), p) == pytest.approx(0.07, rel=1e-9)


def test_mutual_difference_of_shifted_tents() -> None:
    # ||t(x) - t(x - 2)||^2 = 2 ||t||^2 once the tents are apart: S = sqrt 2.
    assert measures.mutual_difference(tent(0.0), tent(2.0)) == pytest.approx(math.sqrt(2.0), rel=ROUND_OFF)
    assert measures.mutual_difference(tent(0.0), tent(0.0)) == 0.0
    assert measures.mutual_difference(tent(0.0, height=1.0), tent(0.0, height=3.0)) == pytest.approx(1.0, rel=ROUND_OFF)


@given(st.floats(0.01, 0.9), st.floats(0.5, 5.0))
def test_mutual_difference_is_symmetric_and_has_no_unit(shift: float, scale: float) -> None:
    a, b = parabola(23), parabola(31, shift=shift)
    scaled = [Profile(scale * p.x, 100.0 * p.value) for p in (a, b)]
    assert measures.mutual_difference(b, a) == pytest.approx(measures.mutual_difference(a, b), rel=1e-9)
    assert measures.mutual_difference(*scaled) == pytest.approx(measures.mutual_difference(a, b), rel=1e-9)


def test_mirror_asymmetry_is_zero_for_a_mirror_image_and_large_for_a_lopsided_one() -> None:
    assert measures.mirror_asymmetry(parabola(24)) == pytest.approx(0.0, abs=1e-7)  # root of round-off
    assert measures.mirror_asymmetry(parabola(24, shift=0.4), axis=0.4) == pytest.approx(0.0, abs=1e-7)
    assert measures.mirror_asymmetry(tent(1.0)) == pytest.approx(math.sqrt(2.0), rel=ROUND_OFF)


def test_second_differences_of_a_sawtooth() -> None:
    # 1 0 1 0 ... 1 with n ones: n - 1 valleys and n - 2 inner peaks, each 2.
    n = 10
    saw = np.tile([1.0, 0.0], n)[:-1]
    assert measures.second_differences(saw) == pytest.approx(2.0 * (2 * n - 3) / n, rel=ROUND_OFF)


def test_oscillation_is_zero_for_the_reference_on_any_mesh() -> None:
    reference = parabola(401)
    x = np.sort(np.random.default_rng(1).uniform(-1.2, 1.2, 40))
    assert measures.oscillation(Profile(x, reference(x)), reference) == pytest.approx(0.0, abs=ROUND_OFF)
    assert measures.excess_turning_points(Profile(x, reference(x)), reference) == 0


def test_oscillation_of_a_rippled_pressure() -> None:
    reference = parabola(401)
    x = np.linspace(-0.8, 0.8, 17)
    ripple = 0.2 * (-1.0) ** np.arange(17)
    rippled = Profile(x, reference(x) + ripple)
    # every inner second difference of the ripple is 4 * 0.2 against 2 h^2 = 0.02 of the parabola
    expected = sum(abs(-0.02 + s) for s in -2 * 2 * ripple[1:-1]) / rippled.value.sum()
    expected -= 15 * 0.02 / reference(x).sum()
    assert measures.oscillation(rippled, reference) == pytest.approx(expected, rel=1e-3)  # reference: linear pieces
    assert measures.excess_turning_points(rippled, reference) == 14  # 15 turning points against one


@pytest.mark.parametrize(("values", "turns"), [([0, 1, 2, 1, 0], 1), ([0, 1, 1, 2], 0), ([0, 1, 1, 0, 0, 1], 2)])
def test_turning_points(values: list[float], turns: int) -> None:
    assert measures.turning_points(np.array(values, float)) == turns


def test_edge_error_in_segment_lengths() -> None:
    reference = parabola(2001)
    wider = parabola(21, half_width=1.05)
    # both parabolas reach 5 % at sqrt(0.95) of their half width, up to the interpolation of the coarse one
    h = 0.105
    assert measures.edge_error(wider, reference) == pytest.approx(0.05 * math.sqrt(0.95) / h, rel=0.05)


def test_measures_without_meaning_are_nan() -> None:
    nothing = Profile(np.array([0.0, 1.0]), np.zeros(2))
    assert math.isnan(measures.pressure_error(tent(0.0), nothing))
    assert math.isnan(measures.mutual_difference(nothing, nothing))
    assert math.isnan(measures.mirror_asymmetry(nothing))
    assert math.isnan(measures.edge_error(nothing, tent(0.0)))
    assert math.isnan(measures.largest_pressure_error(nothing, nothing))
    assert math.isnan(measures.relative_difference(0.0, 0.0))


def test_relative_difference() -> None:
    assert measures.relative_difference(1.01, 0.99) == pytest.approx(0.02, rel=1e-9)
