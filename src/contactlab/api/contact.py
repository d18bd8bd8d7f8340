"""Contact algorithms: from two surfaces to gap constraints.

An algorithm depends neither on the friction law nor on enforcement or time. It is written in one of two ways, which
share `ContactMethod`:

`ContactAlgorithm`  gives local, segment-wise pieces of the operators D, M and T; the core assembles
                    them, merges and drops multipliers on partial overlap, builds the rows
                    G = T^-T [D^T | -M^T] . normal and turns multipliers into pressures.
`GapAlgorithm`      gives finished rows. Simple to write in plain NumPy; implicit runs take differences of them.

An algorithm sees a contact through one `ContactView`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from contactlab.api.arrays import Flags, Floats, Ints
from contactlab.api.compiled.bound_arrays import Floats2, Floats3, Ints2, KernelArgument
from contactlab.api.derivatives import ConditionDerivatives, GapGradients, PieceDerivatives
from contactlab.api.surface import Candidates, Surface, SurfacePositions


class ContactView(NamedTuple):
    """All data of a contact that an algorithm may see. Read-only except for `memory`.

    slave, master  the surfaces
    at             positions of their nodes [mm]
    near           master segments near each slave segment
    reach          [mm] search distance: leave out slave segments (or nodes) with a larger gap
    memory         (memory_size, m) numbers that the algorithm keeps since the last step, updated in place
    """

    slave: Surface
    master: Surface
    at: SurfacePositions
    near: Candidates
    reach: float
    memory: Floats


@dataclass(eq=False)
class Pieces(KernelArgument):
    """Arrays for the local operators of one contact pair, refilled in every call.

    A piece couples at most `s` slave nodes, `k` multipliers and `r` master nodes. Multiplier
    j = slot * m + i belongs to slave node i; slot is 0 unless the algorithm declares more rows per
    node. T may couple only multipliers of nodes that neighbour in the chain of nodes with multipliers.

    slave       (capacity, s) int32, slave nodes as positions in the slave surface
    multiplier  (capacity, k) int32
    master      (capacity, r) int32, master nodes as positions in the master surface
    D           (capacity, s, k) [mm]  integral of slave trace i times multiplier basis j
    M           (capacity, r, k) [mm]  integral of master trace l times multiplier basis j
    T           (capacity, k, k) [mm]  integral of linear hat i times multiplier basis j
    normal      (multipliers, 2) unit vectors from the master towards the slave

    Filled by algorithms between segments alone:

    ends        (capacity, 4) xi and eta, 0 to 1, at the start of an integration segment, and at its end
    segment     (capacity, 2) int32, its slave and master segment
    averaged    True if all normals are the averaged normals of the slave
    """

    slave: Ints2
    multiplier: Ints2
    master: Ints2
    D: Floats3
    M: Floats3
    T: Floats3
    normal: Floats2
    ends: Floats2
    segment: Ints2
    averaged: bool = False

    @classmethod
    def allocate(cls, capacity: int, widths: tuple[int, int, int], multipliers: int) -> Pieces:
        """Allocate zeroed arrays for `capacity` pieces with `widths` (s, k, r)."""
        s, k, r = widths
        return cls(
            np.zeros((capacity, s), np.int32),
            np.zeros((capacity, k), np.int32),
            np.zeros((capacity, r), np.int32),
            np.zeros((capacity, s, k)),
            np.zeros((capacity, r, k)),
            np.zeros((capacity, k, k)),
            np.zeros((multipliers, 2)),
            np.zeros((capacity, 4)),
            np.zeros((capacity, 2), np.int32),
        )


MERGED_BELOW = 0.05
"""Share of its length below which a multiplier is merged if its algorithm does not say otherwise."""


class ContactMethod(ABC):
    """Declarations shared by both kinds of contact algorithms. Algorithms derive from one of the classes below.

    passes_patch_test  True or False; both are checked
    explicit_only      True if constraints jump too much for Newton's method: implicit runs refuse the algorithm
    keeps_energy       True if frictionless contact creates energy in no explicit step
    rows_per_node      largest number of constraints on a slave node
    memory_size        numbers remembered per slave node between steps (zero at the start)
    """

    passes_patch_test: ClassVar[bool]
    rows_per_node: ClassVar[int] = 1
    explicit_only: ClassVar[bool] = False
    keeps_energy: ClassVar[bool] = False
    memory_size: ClassVar[int] = 0

    def half_pass(self) -> ContactAlgorithm | None:
        """Return the algorithm of each of two half passes; None, the default, for one pass.

        Each side is then the slave of a pass of its own, whose forces act on this side alone. Two half passes
        are for pressure laws.
        """
        return None


class ContactAlgorithm(ContactMethod):
    """Base of algorithms with local operators. Subclasses are frozen dataclasses; their fields are the TOML keys.

    gradient_nodes  most nodes that the weights of an integration segment depend on; 0 without `gradients`
    merged_below    share of its length: a multiplier with less overlap is merged into its neighbour, 0 to 0.5;
                    with frozen forces in explicit runs 0.05, as their later release adds energy
    points_press    True if each multiplier belongs to one integration segment, with its own pressure: reports give
                    nodes the means of the integration segments at them, weighted by D
    biorthogonal    True if T is diagonal, also on partial overlap: a multiplier sees its own hat alone
    closest_points  True if every constraint measures a distance between closest points: separations along the
                    normals are then independent of turning normals and changing weights (to first order)
    """

    gradient_nodes: ClassVar[int] = 0
    merged_below: ClassVar[float] = MERGED_BELOW
    points_press: ClassVar[bool] = False
    biorthogonal: ClassVar[bool] = False
    closest_points: ClassVar[bool] = False

    @property
    def lumped(self) -> bool:
        """True if the core lumps hats in T: each multiplier then has a gap of its own (rows.md, the strong cone)."""
        return False

    def with_friction(self) -> ContactAlgorithm:
        """Return the algorithm to use with friction. The default is the algorithm itself."""
        return self

    def carriers(self, slave: Surface) -> Flags:
        """Return which nodes (m,) of the slave carry multipliers. The default is all of them.

        At most one node between two such nodes of a chain may lack a multiplier; reports give it their mean.
        """
        return np.ones(len(slave.nodes), np.bool_)

    @abstractmethod
    def widths(self, slave: Surface, master: Surface) -> tuple[int, int, int]:
        """Return the largest numbers of slave nodes, multipliers and master nodes that one piece couples."""

    @abstractmethod
    def capacity(self, slave: Surface, near: Candidates) -> int:
        """Return the largest number of integration segments that `pieces` can give for these candidates."""

    @abstractmethod
    def pieces(self, view: ContactView, out: Pieces) -> int:
        """Fill `out` for the positions of the view and return the number of pieces."""

    def normals(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> None:
        """Fill out (multipliers, 2) with the normals that the first `count` of `pieces` have at the view's positions.

        Called with friction, at the start of the step. The default integrates all segments again; algorithms
        whose normals follow from positions alone override it.
        """
        widths = self.widths(view.slave, view.master)
        spare = Pieces.allocate(self.capacity(view.slave, view.near), widths, len(out))
        spare.normal[:] = pieces.normal
        self.pieces(view._replace(memory=view.memory.copy()), spare)
        out[:] = spare.normal

    def derivatives(self, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
        """Fill `out` with the derivatives of the first `count` of `pieces`, which were filled for this view.

        Called by implicit integrators. The default returns False, and the core takes differences of
        `pieces`: right, but about fifty calls slower. `out` has room for 2 (s + r + 8) entries
        per piece, 20 per normal and 32 more of the normals per piece.
        """
        return False

    def gradients(
        self, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats, out: GapGradients
    ) -> bool:
        """Fill `out` with the derivatives of the separations of the first `count` of `pieces`, one entry for each.

        Called in every step by explicit integrators whose contact forces are consistent, for algorithms that declare
        `gradient_nodes`. The separation of multiplier i is row owner[i] of `separation` (multipliers, 2) [mm]; `owner`
        (multipliers,) int32 is -1 for none. If it returns False, the core uses `derivatives`: same result but slower.
        """
        return False

    def feet(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> bool:
        """Fill out (p, 4): overlap ends on the slave and master segment, -1 to 1, at the start and end of each piece.

        Only the first `count` of `pieces`. Called like `gradients`, if all edges are straight, without friction.
        For algorithms that project a point of a slave segment onto a master segment along the averaged normals of the
        slave, interpolated between its nodes, and integrate over the slave segment with the projection linear in each
        piece. The core then computes `gradients` many times faster. The default returns False, and
        `gradients` is called.
        """
        return False


@dataclass(frozen=True)
class GapConditions:
    """k finished gap constraints in one sparse pattern.

    start          (k + 1,) int32 row pointers
    node           (z,) int32 global nodes
    normal_weight  (z, 2) [-]  derivative of the gap by the node's position
    tangent_weight (z, 2) [-]  derivative of the slip; (0, 2) without friction
    gap            (k,) [mm]   positive when open
    measure        (k,) [mm]   length of slave surface that belongs to each constraint
    owner          (k,) int32  multiplier slot * m + i of each constraint at slave node i, each at most once
    """

    start: Ints
    node: Ints
    normal_weight: Floats
    tangent_weight: Floats
    gap: Floats
    measure: Floats
    owner: Ints


class GapAlgorithm(ContactMethod):
    """Base of algorithms with finished gap constraints. Subclasses are frozen dataclasses; fields are the TOML keys."""

    @abstractmethod
    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        """Return the gap constraints at the positions of the view, with tangent weights if `tangent` is True."""

    def derivatives(self, view: ContactView, found: GapConditions) -> ConditionDerivatives | None:
        """Return derivatives of the weights of `found`, the constraints of this view; all is read-only, with `memory`.

        Called by implicit integrators. The default returns None, and the core takes differences of `conditions`:
        about thirty calls for a node on a segment, or four calls for each node of the widest constraint.
        If constraints depend on nodes far from the nodes that they name, the core detects it and takes more calls.
        """
        return None
