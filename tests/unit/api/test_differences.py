"""Bounds of explicit steps for laws that give none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from contactlab_solids.hypoelastic import Hypoelastic
from contactlab_solids.neo_hookean import NeoHookean

from contactlab.api import Floats, Kinematics, Material
from contactlab.testing import material as checks


@dataclass(frozen=True)
class Silent(Material):
    """A neo-Hookean law of somebody who says nothing of tangents and stiffening."""

    density: float = 1e-9
    kinematics: ClassVar[Kinematics] = "finite"

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        SHIPPED.stress(gradient, history, dt, stress, new_history)

    def wave_speeds(self) -> tuple[float, float]:
        return SHIPPED.wave_speeds()


SHIPPED = NeoHookean(young=1000.0, poisson=0.3, density=1e-9)


def test_the_default_bounds_all_waves() -> None:
    checks.stiffening_bounds_the_waves(Silent())


def test_a_stretch_along_an_axis_has_its_closed_form() -> None:
    """Along the axis of a stretch s mu (s + 1/s) + lambda (1 - ln s)/s, across it 2 mu/s and the same, over rest."""
    shear, lame = 1000.0 / 2.6, 1000.0 * 0.3 / 1.3 / 0.4
    stretch = np.array([0.6, 0.8, 1.0, 1.3, 2.0])
    gradient = np.zeros((4, 5))
    gradient[0], gradient[3] = 1.0 / stretch, 1.0
    out = np.zeros(5)
    Silent().stiffening(gradient, np.zeros((4, 5)), out)
    bulk = lame * (1.0 - np.log(stretch)) / stretch
    along = (shear * (stretch + 1.0 / stretch) + bulk) / (lame + 2.0 * shear)
    across = (shear * 2.0 / stretch + bulk) / (lame + 2.0 * shear)
    exact = np.maximum(along, across)
    # what may lie between two directions is added: less than 4 % of the spread
    assert np.all(out >= exact * (1.0 - 1e-8))
    assert out == pytest.approx(exact, rel=0.04)


def test_laws_that_cannot_be_asked_stay_at_one() -> None:
    law, out = Hypoelastic(young=1000.0, poisson=0.3, density=1e-9), np.zeros(3)
    Material.stiffening(law, np.zeros((4, 3)), np.zeros((4, 3)), out)
    assert out.tolist() == [1.0, 1.0, 1.0]
