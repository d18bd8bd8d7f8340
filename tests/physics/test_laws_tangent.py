"""Consistent tangents: what Newton needs is the derivative of the stress that the law really gives."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_solids.linear_elastic import LinearElastic
from contactlab_solids.neo_hookean import NeoHookean

from contactlab.api import Floats, Material
from contactlab.api.differences import tangent_by_differences

LAWS: dict[str, Material] = {
    "linear-elastic": LinearElastic(7000.0, 0.3, 2.7e-9),
    "neo-hookean": NeoHookean(7000.0, 0.3, 2.7e-9),
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
    gradient = gradients(law, size, 1)
    tangent, expected = np.empty((4, 4, POINTS)), np.empty((4, 4, POINTS))
    law.tangent(gradient, history, 1.0, tangent)
    tangent_by_differences(law, gradient, history, 1.0, expected)
    # central differences with step 6e-6 are good to about 1e-10 of the largest modulus times the curvature
    np.testing.assert_allclose(tangent, expected, atol=1e-8 * np.abs(expected).max(), rtol=0.0)
