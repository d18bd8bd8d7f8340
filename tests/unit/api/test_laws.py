"""Laws whose methods are partly formulas, and the waves that the core finds in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from contactlab_solids.linear_elastic import LinearElastic
from contactlab_solids.neo_hookean import NeoHookean

from contactlab.api import Floats, Material, formula
from contactlab.api.differences import BETWEEN, DIRECTIONS, stiffening_of_waves
from contactlab.testing import material

P = 50


@dataclass(frozen=True)
class ByBoth(Material):
    """Hooke's law: its stress in NumPy, its energy by a formula."""

    young: float
    poisson: float
    density: float
    kinematics: ClassVar = "small"

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        LinearElastic(self.young, self.poisson, self.density).stress(gradient, history, dt, stress, new_history)

    @formula
    def energy(H: Any, p: Any) -> Any:
        mu = 0.5 * p.young / (1.0 + p.poisson)
        lame = 2.0 * mu * p.poisson / (1.0 - 2.0 * p.poisson)
        return 0.5 * lame * H.trace() ** 2 + mu * H.symmetric().dot(H.symmetric())


@pytest.mark.parametrize("check", material.CHECKS)
def test_an_energy_by_a_formula_stands_beside_a_stress_by_hand(check: Any) -> None:
    try:
        check(ByBoth(young=1000.0, poisson=0.3, density=1e-9))
    except material.NotApplicable:
        assert check not in (material.energy_is_positive, material.energy_belongs_to_the_stress)


def test_formulas_of_a_law_see_one_deformation() -> None:
    with pytest.raises(
        TypeError, match=r"ByOther.energy: got the argument H, allowed: F, as kinematics is 'finite' \("
    ):

        class ByOther(NeoHookean):
            @formula
            def energy(H: Any, p: Any) -> Any:
                return H.dot(H)


def test_stiffening_is_that_of_the_acoustic_tensor() -> None:
    """Against stresses of strained points that a wave moves on, by differences, in each direction."""
    law, step = NeoHookean(young=1000.0, poisson=0.3, density=1e-9), 1e-6
    inverse = np.eye(2).reshape(4, 1) + np.random.default_rng(2).uniform(-0.2, 0.2, (4, P))
    none, moduli = np.zeros((0, P)), np.empty((DIRECTIONS, P))
    for number, angle in enumerate(np.arange(DIRECTIONS) * np.pi / DIRECTIONS):
        n, acoustic = np.array([np.cos(angle), np.sin(angle)]), np.empty((P, 2, 2))
        for k in range(2):
            ends = []
            for sign in (1.0, -1.0):
                motion = np.linalg.inv(np.eye(2) + sign * step * np.outer(np.eye(2)[k], n))
                moved = np.einsum("aip,ij->ajp", inverse.reshape(2, 2, P), motion).reshape(4, P)
                stress = np.empty((4, P))
                law.stress(moved, none, 0.0, stress, none)
                ends.append(stress)
            xx, yy, _, xy = (ends[0] - ends[1]) / (2.0 * step)
            acoustic[:, 0, k], acoustic[:, 1, k] = xx * n[0] + xy * n[1], xy * n[0] + yy * n[1]
        moduli[number] = np.linalg.eigvalsh(0.5 * (acoustic + acoustic.transpose(0, 2, 1)))[:, 1]
    most, least = moduli.max(axis=0), moduli.min(axis=0)
    found = np.empty(P)
    stiffening_of_waves(law, inverse, found)
    expected = (most + BETWEEN * (most - least)) / (law.density * law.wave_speeds()[0] ** 2)
    np.testing.assert_allclose(found, expected, rtol=1e-8)  # of central differences: round-off over the step is 1e-10


def test_stiffening_of_what_is_no_number_is_none() -> None:
    inverse, found = np.eye(2).reshape(4, 1) * np.ones(3), np.empty(3)
    inverse[1, 1] = np.nan
    stiffening_of_waves(NeoHookean(young=1000.0, poisson=0.3, density=1e-9), inverse, found)
    assert [*np.isnan(found)] == [False, True, False]
