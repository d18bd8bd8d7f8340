"""Consistent tangents: what Newton needs is the derivative of the stress that the law really gives."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_solids.hypoelastic import Hypoelastic
from contactlab_solids.linear_elastic import LinearElastic
from contactlab_solids.linear_hardening import LinearHardening
from contactlab_solids.neo_hookean import NeoHookean
from contactlab_solids.power_law import PowerLaw

from contactlab.api import Floats, Material
from contactlab.api.differences import tangent_by_differences

LAWS: dict[str, Material] = {
    "linear-elastic": LinearElastic(7000.0, 0.3, 2.7e-9),
    "neo-hookean": NeoHookean(7000.0, 0.3, 2.7e-9),
    "hypoelastic": Hypoelastic(7000.0, 0.3, 2.7e-9),
    "power-law": PowerLaw(70000.0, 0.3, 2.7e-9, strength=348.0, prestrain=0.02, exponent=0.03),
    "linear-hardening": LinearHardening(70000.0, 0.3, 2.7e-9, yield_stress=400.0, hardening=100.0),
    "perfectly-plastic": LinearHardening(70000.0, 0.3, 2.7e-9, yield_stress=400.0),
}
POINTS = 60


def gradients(law: Material, size: float, seed: int) -> Floats:
    """Random gradients (4, P) of the kind that the law is given."""
    base = np.array([[1.0], [0.0], [0.0], [1.0]]) if law.kinematics == "finite" else np.zeros((4, 1))
    return base + np.random.default_rng(seed).uniform(-size, size, (4, POINTS))


@pytest.mark.parametrize("size", [0.01, 0.3])
@pytest.mark.parametrize("name", LAWS)
def test_tangent_is_the_derivative_of_the_stress(name: str, size: float) -> None:
    law = LAWS[name]
    history = np.zeros((law.history_size, POINTS))
    for seed in (2, 3):  # a past with plastic strain and turned stress
        law.stress(gradients(law, size, seed), history, 1.0, np.empty((4, POINTS)), history)
    gradient = gradients(law, size, 1)
    tangent, expected = np.empty((4, 4, POINTS)), np.empty((4, 4, POINTS))
    law.tangent(gradient, history, 1.0, tangent)
    tangent_by_differences(law, gradient, history, 1.0, expected)
    # central differences with step 6e-6 err by (step / yield strain)^2, 4e-7, where a point has just yielded
    np.testing.assert_allclose(tangent, expected, atol=1e-6 * np.abs(expected).max(), rtol=0.0)
