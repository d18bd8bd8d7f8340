"""Elements: tables on one reference cell. The core loops over the cells."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar, Literal, NamedTuple

from contactlab.api.arrays import Floats
from contactlab.api.material import Kinematics


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

    An author provides the class attributes and three methods; the core derives mass, gradients,
    internal forces and contact traces from them.

    nodes    (a, 2) reference coordinates in [-1, 1]^2
    edges    local nodes of each side: start, end, then inner ones; the cell lies on the left
    degree   complete polynomial degree; the displacement error must be O(h**(degree + 1))
    lumping  how the mass becomes diagonal: "row-sum" (integral of each shape function),
             "hrz" (Hinton, Rock & Zienkiewicz: consistent diagonal scaled to the total) or
             "quadrature" (nodal quadrature, for elements whose nodes are Lobatto points)
    exact    kernels give the gradient of the shape functions at the points; False for enhanced or assumed strains,
             whose mean over a cell is still that of the shape functions
    locks    True: too stiff where plastic flow keeps the volume; runs in which it flows warn of it
    without  effects of this element ("quadratic shape functions"), each with the element that leaves it out
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

    @abstractmethod
    def shape(self, points: Floats) -> Shape:
        """Shape functions at reference `points` (s, 2)."""

    @abstractmethod
    def quadrature(self) -> Quadrature:
        """The rule that integrates internal forces."""

    @abstractmethod
    def edge_shape(self, s: Floats) -> tuple[Floats, Floats]:
        """Trace on a side at s in [-1, 1]: values (len(s), b) and d/ds (len(s), b), ordered as in `edges`."""

    def block_kernels(self, kinematics: Kinematics) -> BlockKernels | None:
        """Kernels of the element's own, or None for the core's generic ones made from the tables.

        `kinematics` is that of the law and decides what `field` and `geometry` are (see `Material`).
        """
        return None
