"""Lumped masses and stable steps of one square cell against closed forms and exact eigenvalues."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contactlab_quads.q1 import Q1
from contactlab_quads.q2 import Q2
from contactlab_quads.q2_lagrange import Q2Lagrange
from contactlab_solids.linear_elastic import LinearElastic

from contactlab.api import Element
from contactlab.meshing import ArcBlock, Rectangle
from contactlab.meshing.mesh import cell_measures, inverted_cells
from contactlab.model.bodies.body import Body
from contactlab.model.bodies.stiffness import cell_frequencies


def square(element: Element, poisson: float, side: float = 1.0) -> Body:
    """One square cell of modulus and density 1."""
    mesh = Rectangle((0.0, side), (0.0, side), (1, 1)).mesh(element, 1)
    return Body("cell", element, LinearElastic(1.0, poisson, 1.0), mesh, 0, len(mesh.nodes), mesh.cells)


@pytest.mark.parametrize(
    ("element", "fractions"),
    [
        (Q1(), [1 / 4] * 4),
        (Q2(), [3 / 76] * 4 + [16 / 76] * 4),
        (Q2Lagrange(), [1 / 36] * 4 + [4 / 36] * 4 + [16 / 36]),
    ],
)
def test_lumped_mass_fractions(element: Element, fractions: list[float]) -> None:
    body = square(element, 0.3, side=3.0)
    # sums of at most nine products: round-off
    np.testing.assert_allclose(cell_measures(body.mesh, element)[0], 9.0 * np.array(fractions), rtol=1e-14)


@pytest.mark.parametrize("element", [Q1(), Q2(), Q2Lagrange()])
def test_mass_of_a_distorted_mesh_is_positive_and_complete(element: Element) -> None:
    mesh = ArcBlock(1.0, 0.8, 0.6, (6, 3)).mesh(element, 1)
    measures = cell_measures(mesh, element)
    arc = 1.6 * 1.0 - (0.8 * 0.6 + math.asin(0.8))  # area under the arc
    assert measures.min() > 0.0
    # curved quadratic sides follow the arc to h^4; straight ones to h^2
    assert measures.sum() == pytest.approx(1.6 * 0.6 - arc, rel=3e-2 if element.degree == 1 else 2e-4)
    assert not len(inverted_cells(mesh, element))


@pytest.mark.parametrize(
    ("element", "poisson", "limit"),
    [
        (Q1(), 0.3, 0.8367),
        (Q1(), 0.499, 0.7078),
        (Q2(), 0.3, 0.2627),
        (Q2(), 0.499, 0.2699),
        (Q2Lagrange(), 0.3, 0.3349),
        (Q2Lagrange(), 0.499, 0.2889),
    ],
)
def test_stable_step_of_a_square(element: Element, poisson: float, limit: float) -> None:
    body = square(element, poisson)
    step = 2.0 / cell_frequencies(body, body.mesh.nodes).max()
    assert step * body.material.wave_speeds()[0] == pytest.approx(limit, abs=6e-5)  # digits of the table


def test_highest_frequency_of_a_square_q1() -> None:
    """w^2 = 8 (lambda + mu)/(rho h^2); 4.4721 for h = rho = mu = 1 and lambda = 1.5."""
    lame, shear = 1.5, 1.0
    young = shear * (3.0 * lame + 2.0 * shear) / (lame + shear)
    mesh = Rectangle((0.0, 1.0), (0.0, 1.0), (1, 1)).mesh(Q1(), 1)
    body = Body("cell", Q1(), LinearElastic(young, lame / (2.0 * (lame + shear)), 1.0), mesh, 0, 4, mesh.cells)
    assert cell_frequencies(body, mesh.nodes)[0] == pytest.approx(math.sqrt(20.0), rel=1e-12)
