"""Contact algorithms: from two surfaces to gap conditions.

An algorithm depends neither on the friction law nor on enforcement or time. It is written in one of two ways, which
share `ContactMethod`:

`ContactAlgorithm`  gives local, segment-wise pieces of the operators D, M and T; the core assembles
                    them, merges and drops multipliers on partial cover, builds the rows
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
    """All that an algorithm may see of a contact. Read-only but for `memory`.

    slave, master  the surfaces
    at             positions of their nodes [mm]
    near           master segments near each slave segment
    reach          [mm] slave segments (or nodes) whose gap exceeds it are to be left out
    memory         (memory_size, m) numbers that the algorithm keeps from the last step, updated in place
    """

    slave: Surface
    master: Surface
    at: SurfacePositions
    near: Candidates
    reach: float
    memory: Floats


@dataclass(eq=False)
class Pieces(KernelArgument):
    """Room for the local operators of one contact pair, filled anew in every call.

    A piece couples at most `s` slave nodes, `k` multipliers and `r` master nodes. Multiplier
    j = slot * m + i belongs to slave node i; slot is 0 unless the algorithm declares more rows per
    node. T may couple only multipliers of neighbouring carriers of the chain.

    slave       (capacity, s) int32, slave nodes as positions in the slave surface
    multiplier  (capacity, k) int32
    master      (capacity, r) int32, master nodes as positions in the master surface
    D           (capacity, s, k) [mm]  integral of slave trace i times multiplier basis j
    M           (capacity, r, k) [mm]  integral of master trace l times multiplier basis j
    T           (capacity, k, k) [mm]  integral of linear hat i times multiplier basis j
    normal      (multipliers, 2) unit vectors from the master towards the slave

    Filled by algorithms between segments alone:

    ends        (capacity, 4) xi and eta, 0 to 1, where a piece begins, and where it ends
    segment     (capacity, 2) int32, its slave and master segment
    averaged    whether all normals are the averaged ones of the slave
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
        """Zeroed room for `capacity` pieces with `widths` (s, k, r)."""
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
    """What both kinds of contact algorithms declare. Algorithms derive from one of the classes below.

    passes_patch_test  True or False; checked either way
    explicit_only      True for an algorithm whose conditions jump too much for Newton's method: implicit runs refuse it
    keeps_energy       True if frictionless contact creates energy in no explicit step
    rows_per_node      conditions a slave node can carry at once
    memory_size        numbers remembered per slave node between steps (zero at the start)
    """

    passes_patch_test: ClassVar[bool]
    rows_per_node: ClassVar[int] = 1
    explicit_only: ClassVar[bool] = False
    keeps_energy: ClassVar[bool] = False
    memory_size: ClassVar[int] = 0

    def half_pass(self) -> ContactAlgorithm | None:
        """The algorithm of each of two half passes; None, the default, for one pass.

        Each side is then the slave of a pass of its own, and the forces of that pass act on it alone. Two half passes
        are for pressure laws.
        """
        return None


class ContactAlgorithm(ContactMethod):
    """Gives local operators. Subclasses are frozen dataclasses; their fields are the TOML keys.

    gradient_nodes  most nodes that the weights of a piece depend on; 0 without `gradients`
    merged_below    share of its length: a multiplier of which less is covered is merged into its neighbour, 0 to 0.5;
                    with frozen forces in explicit runs 0.05, since they make energy of what comes free later
    points_press    True if each multiplier belongs to one piece, with a pressure of its own: nodes are reported with
                    the means of the pieces at them, weighted by D
    biorthogonal    True if T is diagonal, also on partly covered segments: a multiplier sees its own hat alone
    closest_points  True if every condition measures the distance between closest points where separations lie along
                    the normals: normals that turn and weights that change do not change it then (to first order)
    """

    gradient_nodes: ClassVar[int] = 0
    merged_below: ClassVar[float] = MERGED_BELOW
    points_press: ClassVar[bool] = False
    biorthogonal: ClassVar[bool] = False
    closest_points: ClassVar[bool] = False

    def with_friction(self) -> ContactAlgorithm:
        """The algorithm to use where friction is declared. The default is the algorithm itself."""
        return self

    def carriers(self, slave: Surface) -> Flags:
        """Which nodes (m,) of the slave carry multipliers. The default is all of them.

        At most one node between two carriers of a chain may be without a multiplier; reports give it their mean.
        """
        return np.ones(len(slave.nodes), np.bool_)

    @abstractmethod
    def widths(self, slave: Surface, master: Surface) -> tuple[int, int, int]:
        """Largest numbers of slave nodes, multipliers and master nodes that one piece couples."""

    @abstractmethod
    def capacity(self, slave: Surface, near: Candidates) -> int:
        """Largest number of pieces that `pieces` can give for these candidates."""

    @abstractmethod
    def pieces(self, view: ContactView, out: Pieces) -> int:
        """Fill `out` for the positions of the view and return the number of pieces."""

    def normals(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> None:
        """Fill out (multipliers, 2) with the normals that the first `count` of `pieces` have at the view's positions.

        Called with friction, at the start of the step. The default integrates all pieces again; algorithms
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
        of each piece, for 20 of each normal and 32 more of the normals for each piece.
        """
        return False

    def gradients(
        self, view: ContactView, pieces: Pieces, count: int, owner: Ints, separation: Floats, out: GapGradients
    ) -> bool:
        """Fill `out` with the derivatives of the separations of the first `count` of `pieces`, one entry for each.

        Called in every step by explicit integrators whose contact forces are consistent, for algorithms that declare
        `gradient_nodes`. The separation of multiplier i is row owner[i] of `separation` (multipliers, 2) [mm]; `owner`
        (multipliers,) int32 is -1 for none. If it returns False, the core takes `derivatives`: the same but slower.
        """
        return False

    def feet(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> bool:
        """Fill out (p, 4): on the slave and on the master segment, -1 to 1, where each piece begins, and where it ends.

        Of the first `count` of `pieces`. Called like `gradients`, where all edges are straight, without friction.
        For algorithms that project a point of a slave segment onto a master segment along the averaged normals of the
        slave, interpolated between its nodes, and integrate over the slave segment with the projection linear in each
        piece. The core then finds the result of `gradients` many times faster. The default returns False, and
        `gradients` is called.
        """
        return False


@dataclass(frozen=True)
class GapConditions:
    """k finished gap conditions in one sparse pattern.

    start          (k + 1,) int32 row pointers
    node           (z,) int32 global nodes
    normal_weight  (z, 2) [-]  derivative of the gap by the node's position
    tangent_weight (z, 2) [-]  derivative of the slip; (0, 2) where no friction is declared
    gap            (k,) [mm]   positive when open
    measure        (k,) [mm]   length of slave surface that belongs to each condition
    owner          (k,) int32  multiplier slot * m + i of each condition at slave node i, each at most once
    """

    start: Ints
    node: Ints
    normal_weight: Floats
    tangent_weight: Floats
    gap: Floats
    measure: Floats
    owner: Ints


class GapAlgorithm(ContactMethod):
    """Gives finished gap conditions. Subclasses are frozen dataclasses; their fields are the TOML keys."""

    @abstractmethod
    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        """The gap conditions at the positions of the view, with tangent weights if `tangent` is True."""

    def derivatives(self, view: ContactView, found: GapConditions) -> ConditionDerivatives | None:
        """Derivatives of the weights of `found`, the conditions of this view; all is read-only, `memory` included.

        Called by implicit integrators. The default returns None, and the core takes differences of `conditions`:
        about thirty calls for one node on one segment, or four calls for each node of the widest condition.
        Where conditions depend on nodes far from those that they name, the core detects it and takes more calls.
        """
        return None
