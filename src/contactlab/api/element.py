"""Elements: tables on one reference cell. The core loops over the cells."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.material import Kinematics
from contactlab.errors import WrongAnswer

STEP = 2.0**-100  # of a complex argument: a power of two, whose square is negligible against 1


class Shape(NamedTuple):
    """Shape functions at s points: `value` (s, a), and `gradient` (s, a, 2) by reference coordinates."""

    value: Floats
    gradient: Floats


class Quadrature(NamedTuple):
    """Points (q, 2) in the reference square [-1, 1]^2 and weights (q,) that sum to 4."""

    points: Floats
    weights: Floats


class BlockKernels(NamedTuple):
    """The stages of an element's work on one block, outputs in place.

    gradient(geometry (N, 2), field (N, 2), connectivity (a, B), out (4, P), scratch)
        d(field)/d(geometry) at every point of the block.
    force(geometry (N, 2), connectivity (a, B), stress (4, P), force (N, 2), scratch)
        Adds the internal nodal forces of the block [N] to `force`.

    stabilise(reference (N, 2), displacement (N, 2), connectivity (a, B), shear, force (N, 2), scratch)
        For elements whose quadrature leaves modes without stiffness, None for others: adds the forces K u of
        a constant symmetric K, proportional to the law's shear modulus [MPa] and zero for every linear
        displacement. Their energy u K u/2 is counted as numerical.

    `scratch` is (6 a + 6, B). The values that `gradient` leaves there are still there when `force` is called
    for the same block and geometry; nothing else is kept between calls.
    """

    gradient: Callable[..., None]
    force: Callable[..., None]
    stabilise: Callable[..., None] | None = None


class Element(ABC):
    """A quadrilateral with nodes numbered counter-clockwise, corners first.

    An author provides the class attributes, the shape functions and a quadrature; gradients, traces, mass,
    internal forces and contact follow.

    nodes    (a, 2) reference coordinates in [-1, 1]^2
    edges    local nodes of each side: start, end, then inner ones; the cell lies on the left
    degree   complete polynomial degree; the displacement error must be O(h**(degree + 1))
    lumping  how the mass becomes diagonal: "row-sum" (integral of each shape function),
             "hrz" (Hinton, Rock & Zienkiewicz: consistent diagonal scaled to the total) or
             "quadrature" (nodal quadrature, for elements whose nodes are Lobatto points)
    exact    True if kernels give the gradient of the shape functions at the points; False for enhanced or assumed
             strains, whose mean over a cell is still the mean of the shape functions' gradient
    locks    True: too stiff in isochoric plastic flow; runs with plastic flow warn of it
    without  effects of this element ("quadratic shape functions"), each with an element without it
    beyond   effects that this element leaves out, each with the element that has it
    """

    nodes: ClassVar[Floats]
    edges: ClassVar[tuple[tuple[int, ...], ...]]
    degree: ClassVar[int]
    lumping: ClassVar[Literal["row-sum", "hrz", "quadrature"]]
    exact: ClassVar[bool] = True
    locks: ClassVar[bool] = False
    without: ClassVar[Mapping[str, str]] = {}
    beyond: ClassVar[Mapping[str, str]] = {}

    def __init_subclass__(cls, **named: Any) -> None:
        super().__init_subclass__(**named)
        if "shape" in vars(cls) and getattr(cls.functions, "__isabstractmethod__", False):
            cls.functions = _values_of_shape  # type: ignore[method-assign, assignment]

    def functions(self, points: Floats) -> Floats:
        """Return values (s, a) of the shape functions at reference `points` (s, 2), which may be complex numbers.

        Write polynomials or other analytic functions, without absolute values or comparisons.
        """
        return _values_of_shape(self, points)

    functions.__isabstractmethod__ = True  # type: ignore[attr-defined]  # of elements that do not give `shape`

    def shape(self, points: Floats) -> Shape:
        """Return shape functions at reference `points` (s, 2).

        The default takes gradients from `functions` by complex steps, exact to round-off (Squire & Trapp 1998). An
        element may give both itself, and then needs no `functions`.
        """
        shifted = [self.functions(points + 1j * STEP * along) for along in np.eye(2)]
        if not all(np.iscomplexobj(value) for value in shifted):
            name = type(self).__name__
            raise WrongAnswer(f"{name}: functions gave real numbers at complex points, needed: formulas of the points")
        gradient = np.ascontiguousarray(np.stack([value.imag / STEP for value in shifted], axis=-1))
        return Shape(np.ascontiguousarray(self.functions(points), np.float64), gradient)

    @abstractmethod
    def quadrature(self) -> Quadrature:
        """Return the rule that integrates internal forces."""

    def edge_shape(self, s: Floats) -> tuple[Floats, Floats]:
        """Return the trace on a side at s in [-1, 1]: values (len(s), b) and d/ds (len(s), b), ordered as in `edges`.

        The default is the trace on the first side.
        """
        edge = list(self.edges[0])
        start, end = self.nodes[edge[0]], self.nodes[edge[1]]
        half = 0.5 * (end - start)
        found = self.shape(0.5 * (start + end) + np.multiply.outer(s, half))
        return np.ascontiguousarray(found.value[:, edge]), np.ascontiguousarray((found.gradient @ half)[:, edge])

    def block_kernels(self, kinematics: Kinematics) -> BlockKernels | None:
        """Return kernels of the element's own, or None for the core's generic kernels made from the tables.

        `kinematics` comes from the material and decides what `field` and `geometry` are (see `Material`).
        """
        return None


def _values_of_shape(element: Element, points: Floats) -> Floats:
    """Return values of the shape functions of an element that gives them with their gradients."""
    return element.shape(points).value
