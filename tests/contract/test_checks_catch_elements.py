"""Every check of elements catches a planted defect, and right elements pass all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from contactlab_quads.q1 import Q1
from contactlab_quads.q2 import Q2

from contactlab.api import BlockKernels, Element, Floats, Quadrature, Shape
from contactlab.errors import WrongAnswer
from contactlab.kernels.cells import table_kernels
from contactlab.testing import NotApplicable, element
from contactlab.testing.assertions import Check
from contactlab.testing.mesh import FourNodes


@dataclass(frozen=True)
class EightNodes(Element):
    """A right serendipity element: its checks differ from those of the bilinear one in degree and lumping."""

    nodes: ClassVar[Floats] = np.array(
        [[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0]], dtype=float
    )
    edges: ClassVar[tuple[tuple[int, ...], ...]] = ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7))
    degree: ClassVar[int] = 2
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "hrz"

    def shape(self, points: Floats) -> Shape:
        """Corners (1 + a)(1 + b)(a + b - 1)/4 and middles (1 - xi^2)(1 + b)/2, with a = xi_k xi, b = eta_k eta."""
        xi, eta = points[:, :1], points[:, 1:]
        k, m = self.nodes[:, 0], self.nodes[:, 1]
        a, b = xi * k, eta * m
        corner = 0.25 * (1 + a) * (1 + b) * (a + b - 1)
        corner_derivative = np.stack([0.25 * k * (1 + b) * (2 * a + b), 0.25 * m * (1 + a) * (a + 2 * b)], axis=-1)
        across = 0.5 * (1 - xi**2) * (1 + b)
        across_derivative = np.stack([-xi * (1 + b), 0.5 * (1 - xi**2) * m], axis=-1)
        along = 0.5 * (1 + a) * (1 - eta**2)
        along_derivative = np.stack([0.5 * k * (1 - eta**2), -eta * (1 + a)], axis=-1)
        kind = np.where(k == 0, 1, np.where(m == 0, 2, 0))
        return Shape(
            np.choose(kind, [corner, across, along]),
            np.choose(kind[:, None], [corner_derivative, across_derivative, along_derivative]),
        )

    def quadrature(self) -> Quadrature:
        """3x3 Gauss points."""
        x, w = np.polynomial.legendre.leggauss(3)
        return Quadrature(np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2), np.outer(w, w).ravel())

    def edge_shape(self, s: Floats) -> tuple[Floats, Floats]:
        """Start, end, middle."""
        value = np.stack([0.5 * s * (s - 1), 0.5 * s * (s + 1), 1 - s * s], axis=1)
        return value, np.stack([s - 0.5, s + 0.5, -2 * s], axis=1)


RIGHT: tuple[Element, ...] = (FourNodes(), EightNodes())


@pytest.mark.parametrize("check", element.CHECKS)
@pytest.mark.parametrize("part", RIGHT)
def test_right_elements_pass(part: Element, check: Check) -> None:
    try:
        check(part)
    except NotApplicable:
        assert check is element.stabilisation_sees_no_linear_field


def test_gradients_and_traces_of_functions_are_those_by_hand() -> None:
    """Complex steps are exact to round-off (Squire & Trapp 1998)."""
    hand, formulas = EightNodes(), Q2()
    points, s = np.random.default_rng(5).uniform(-1.0, 1.0, (40, 2)), np.linspace(-1.0, 1.0, 9)
    np.testing.assert_allclose(formulas.shape(points).value, hand.shape(points).value, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(formulas.shape(points).gradient, hand.shape(points).gradient, rtol=0.0, atol=1e-15)
    for found, right in zip(formulas.edge_shape(s), hand.edge_shape(s), strict=True):
        np.testing.assert_allclose(found, right, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(hand.functions(points), hand.shape(points).value)


def test_functions_that_drop_the_imaginary_part_are_refused() -> None:
    class Compared(Q2):
        def functions(self, points: Floats) -> Floats:
            return np.abs(super().functions(points))

    with pytest.raises(WrongAnswer, match="functions gave real numbers at complex points"):
        Compared().shape(np.zeros((1, 2)))


@dataclass(frozen=True)
class Flawed(FourNodes):
    """The bilinear element with one named flaw in its tables."""

    flaw: str = ""

    def shape(self, points: Floats) -> Shape:
        value, gradient = super().shape(points)
        if self.flaw == "sum above one":
            value = 1.001 * value
        if self.flaw == "two nodes exchanged":
            value, gradient = value[:, [1, 0, 2, 3]], gradient[:, [1, 0, 2, 3]]
        if self.flaw == "single precision":
            value = value.astype(np.float32)
        if self.flaw == "derivative halved":
            gradient = gradient * [1.0, 0.5]
        return Shape(value, gradient)

    def quadrature(self) -> Quadrature:
        points, weights = super().quadrature()
        if self.flaw == "weights sum to 3.96":
            return Quadrature(points, 0.99 * weights)
        return Quadrature(points, weights)

    def edge_shape(self, s: Floats) -> tuple[Floats, Floats]:
        value, derivative = super().edge_shape(s)
        return (value[:, ::-1], derivative[:, ::-1]) if self.flaw == "trace turned round" else (value, derivative)

    def block_kernels(self, kinematics: str) -> BlockKernels | None:
        right = table_kernels(FourNodes())

        def gradient(geometry: Floats, field: Floats, connectivity: Any, out: Floats, scratch: Floats) -> None:
            if self.flaw == "field centred in place":
                field -= field.mean(axis=0)
            right.gradient(geometry, field, connectivity, out, scratch)
            if self.flaw == "shear components exchanged":
                out[[1, 2]] = out[[2, 1]]
            if self.flaw == "depends on the block":
                out *= 1.0 + 1e-15 * connectivity.shape[1]

        def force(geometry: Floats, connectivity: Any, stress: Floats, out: Floats, scratch: Floats) -> None:
            if self.flaw == "forces overwritten":
                out[:] = 0.0
            if self.flaw == "shear forgotten":
                stress = stress * np.array([[1.0], [1.0], [1.0], [0.0]])
            right.force(geometry, connectivity, stress, out, scratch)

        def stabilise(
            reference: Floats, displacement: Floats, connectivity: Any, shear: float, out: Floats, scratch: Floats
        ) -> None:
            np.add.at(out, connectivity, shear * displacement[connectivity])

        springs = stabilise if self.flaw == "stabilised by springs to the ground" else None
        return BlockKernels(gradient, force, springs)


class Clockwise(FourNodes):
    """Corners in the wrong sense."""

    nodes: ClassVar[Floats] = FourNodes.nodes[[0, 3, 2, 1]]


class TurnedEdge(FourNodes):
    """One side has the cell on its right."""

    edges: ClassVar[tuple[tuple[int, ...], ...]] = ((0, 1), (2, 1), (2, 3), (3, 0))


class Boastful(FourNodes):
    """Promises quadratics."""

    degree: ClassVar[int] = 2


class OnePoint(FourNodes):
    """Hourglasses are free."""

    def quadrature(self) -> Quadrature:
        return Quadrature(np.zeros((1, 2)), np.array([4.0]))


class NegativeCorners(EightNodes):
    """Row sums of the serendipity element: -1/12 at the corners."""

    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]] = "row-sum"


class Outward(Q1):
    """Says that its points are elsewhere than its kernels have them."""

    def quadrature(self) -> Quadrature:
        return Quadrature(0.9 * self.nodes, np.ones(4))


@dataclass(frozen=True)
class Silent(Flawed):
    """It locks, and does not say so."""

    locks: ClassVar[bool] = False


WRONG: list[tuple[Check, Element]] = [
    (element.kernels_are_at_the_points, Outward()),
    (element.reference_nodes, Clockwise()),
    (element.locking_is_declared, Silent()),
    (element.edges_of_the_cell, TurnedEdge()),
    (element.tables_are_of_their_types, Flawed("single precision")),
    (element.partition_of_unity, Flawed("sum above one")),
    (element.delta_property, Flawed("two nodes exchanged")),
    (element.gradient_is_the_derivative, Flawed("derivative halved")),
    (element.complete_to_its_degree, Boastful()),
    (element.quadrature_exactness, Flawed("weights sum to 3.96")),
    (element.trace_is_the_shape, Flawed("trace turned round")),
    (element.linear_field_is_exact, Flawed("shear components exchanged")),
    (element.constant_stress_is_balanced, Flawed("shear forgotten")),
    (element.rigid_motion_is_free, OnePoint()),
    (element.rigid_motion_is_free, Flawed("stabilised by springs to the ground")),
    (element.lumped_mass, NegativeCorners()),
    (element.forces_are_added, Flawed("forces overwritten")),
    (element.stabilisation_sees_no_linear_field, Flawed("stabilised by springs to the ground")),
    (element.any_cut_gives_the_same, Flawed("depends on the block")),
    (element.kernels_leave_inputs_alone, Flawed("field centred in place")),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
def test_wrong_elements_are_caught(caught: Any, check: Check, part: Element) -> None:
    caught(check, part)


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} == set(element.CHECKS)
