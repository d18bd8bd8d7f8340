"""Enforcements: forces from gap constraints."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.compiled.bound_arrays import Floats1, Floats2, Floats3, Ints1, Ints2, KernelArgument
from contactlab.api.compiled.late import late

ROUND_OFF = 1e-16


class GapRows(KernelArgument):
    """The gap constraints of all contacts of a model in any form: a matrix G, k normal rows by 2N coordinates.

    Gaps change by G u with a motion u of the nodes, and forces of the constraints push the nodes by G^T y. Rows of
    frozen and of consistent forces differ in the values of G alone. With friction k tangential rows follow. Every form
    has the `count`, `gap`, `size` and `slot` of `Rows`. These methods serve Python; compiled enforcements take the
    arrays of a form.
    """

    def to_csr(self, nodes: int) -> Any:
        """Return G as a sparse matrix, for a model of so many nodes."""
        raise NotImplementedError

    def apply(self, motion: Floats) -> Floats:
        """Return G u, the changes (k,) [mm] of the gaps by a motion (N, 2) [mm]; slips follow with friction."""
        return np.asarray(self.to_csr(len(motion)) @ motion.ravel())

    def apply_transposed(self, y: Floats, nodes: int) -> Floats:
        """Return G^T y, the nodal forces (N, 2) [N] of forces (k,) [N] of the constraints, normal, then tangential."""
        return np.asarray(self.to_csr(nodes).T @ y).reshape(-1, 2)

    def diagonal(self, compliance: Floats) -> Floats:
        """Return the change (k,) [mm/N] of each gap by its own force, with the compliance (N, 2) [mm/N] of nodes."""
        return np.asarray(self.to_csr(len(compliance)).power(2) @ compliance.ravel())


def _sparse(start: Ints1, node: Ints1, weight: Floats, nodes: int) -> Any:
    """Return rows of `weight` (z, 2) on nodes as a sparse matrix (k, 2N); entries of a row and node are summed."""
    end, column = start[-1], 2 * node[: start[-1], None] + np.arange(2)
    parts = weight[:end].ravel(), column.ravel(), 2 * start
    return late("scipy.sparse").csr_array(parts, (len(start) - 1, 2 * nodes))


@dataclass
class Rows(GapRows):
    """Gap constraints, written out, `count` of them in use.

    start          (k + 1,) int32
    node           (z,) int32 global nodes
    normal_weight  (z, 2) [-]  d(gap)/d(position)
    tangent_weight (z, 2) [-]  d(slip)/d(position); (0, 2) without friction
    gap            (k,) [mm]   at the predicted positions
    slip           (k,) [mm]   of the step at the predicted positions; (0,) without friction
    measure        (k,) [mm]   length of slave surface that belongs to the constraint
    size           (k,) [mm]   length of the slave segments there, to scale gaps
    slot           (k,) int32  index of the constraint's multiplier in the state
    offset         (k,) [mm]   gap less weights times positions, for records
    bound          (3, k)      friction bound per row: coefficient, adhesion, cap; (3, 0) without friction
    work           (4, k)      scratch for the enforcement
    """

    count: int
    start: Ints1
    node: Ints1
    normal_weight: Floats2
    tangent_weight: Floats2
    gap: Floats1
    slip: Floats1
    measure: Floats1
    size: Floats1
    slot: Ints1
    offset: Floats1
    bound: Floats2
    work: Floats2

    @classmethod
    def allocate(cls, rows: int, entries_per_row: int, friction: bool) -> Rows:
        """Allocate zeroed arrays for so many rows; nothing tangential exists without friction."""
        entries, slip = rows * entries_per_row, rows if friction else 0
        gap, measure, size, offset = (np.zeros(rows) for _ in range(4))
        return cls(
            0, np.zeros(rows + 1, np.int32), np.zeros(entries, np.int32), np.zeros((entries, 2)),
            np.zeros((entries if friction else 0, 2)), gap, np.zeros(slip), measure, size, np.zeros(rows, np.int32),
            offset, np.zeros((3, slip)), np.zeros((4, rows)),
        )  # fmt: skip

    def to_csr(self, nodes: int) -> Any:
        """Return normal rows, then tangential rows if there is friction."""
        weights = (self.normal_weight, self.tangent_weight) if len(self.slip) else (self.normal_weight,)
        parts = [_sparse(self.start[: self.count + 1], self.node, weight, nodes) for weight in weights]
        return late("scipy.sparse").vstack(parts, "csr")


@dataclass
class FactoredRows(GapRows):
    """Frictionless gap constraints before their coupling is inverted, `count` of them in use.

    Constraint i is normal . (own + [T^-T B])_i: B has few entries per constraint, T couples neighbours. `Rows` hold
    the same as many weights.

    start    (k + 1,) int32
    node     (z,) int32 global nodes, weight (z,) [mm]: row i of B
    own      (k,) int32  slave node of weight one in addition to B; -1 if B contains it
    normal   (k, 2)      unit vectors
    gap, size, slot      as in `Rows`, (k,)
    above    (k,) [mm]   T[i - 1, i], 0 at the start of a chain
    below    (k,) [mm]   T[i, i - 1], 0 at the start of a chain
    inverse  (k,) [1/mm] inverse pivots of T, eliminated in this order
    left     (k,) [mm]   gaps after the solve; written by the enforcement for output writers
    """

    count: int
    start: Ints1
    node: Ints1
    weight: Floats1
    own: Ints1
    normal: Floats2
    gap: Floats1
    size: Floats1
    slot: Ints1
    above: Floats1
    below: Floats1
    inverse: Floats1
    left: Floats1

    @classmethod
    def allocate(cls, rows: int, entries: int) -> FactoredRows:
        """Allocate zeroed arrays for so many rows and entries."""
        own, slot = (np.zeros(rows, np.int32) for _ in range(2))
        gap, size, above, below, inverse, left = (np.zeros(rows) for _ in range(6))
        return cls(
            0, np.zeros(rows + 1, np.int32), np.zeros(entries, np.int32), np.zeros(entries), own, np.zeros((rows, 2)),
            gap, size, slot, above, below, inverse, left,
        )  # fmt: skip

    @property
    def factors(self) -> FactoredRows:
        """Return the rows themselves, as `FactoredGradients` contain theirs."""
        return self

    def to_csr(self, nodes: int) -> Any:
        """Return rows with T inverted."""
        start = self.start[: self.count + 1]
        along = [_sparse(start, self.node, self.weight[:, None] * axis, nodes) for axis in np.eye(2)]
        return _with_inverse(self, along, self.own[: self.count], nodes)


def _with_inverse(f: FactoredRows, along: list[Any], own: Any, nodes: int) -> Any:
    """Return normal . (own + [T^-T B]) for the x and y components of B, `along`, and global `own` nodes (k,)."""
    k, sparse = f.count, late("scipy.sparse")
    above, below, inverse = f.above[1:k], f.below[1:k], f.inverse[:k]
    coupling = np.zeros((3, k))  # the diagonals of T^T, from its factors
    coupling[0, 1:], coupling[1], coupling[2, :-1] = below, 1.0 / inverse, above
    coupling[1, 1:] += above * below * inverse[:-1]
    inverted = late("scipy.linalg").solve_banded((1, 1), coupling, np.eye(k)) if k else np.zeros((0, 0))
    inverted[np.abs(inverted) < ROUND_OFF * np.abs(inverted).max(initial=0.0)] = 0.0  # it decays along a chain
    found, row = sparse.csr_array((k, 2 * nodes)), np.flatnonzero(own >= 0)
    for c, columns in enumerate(along):
        own_node = sparse.csr_array((np.ones(len(row)), (row, 2 * own[row] + c)), (k, 2 * nodes))
        found += sparse.diags_array(f.normal[:k, c]) @ (own_node + sparse.csr_array(inverted) @ columns)
    return found


@dataclass
class FactoredGradients(GapRows):
    """Frictionless constraints whose rows are the derivatives of their gaps, before their coupling is inverted.

    The row of constraint i is normal . (own + [T^-T B])_i + spin d(angle); products with it are in
    `contactlab.api.compiled.gradient_products`. Local node numbers are indices into `nodes`.

    factors      the `FactoredRows` it contains; `node` and `own` are local, `weight` is empty, `gap` is d - d0, the
                 predicted motion less the allowed motion, and `left`, written by the enforcement, is `gap` after the
                 solve plus `offset`
    block        (z, 2, 2) [mm] row i of B: derivative of component c of the weighted separation by coordinate d
    nodes        (n,) int32 global nodes, the first used[0] in use
    angle_start  (k + 1,) int32, angle (y,) int32, lever (y, 2) [mm]: B by the angles of averaged normals
    ends, turn   (a, 2) int32, (a, 2) [1/mm]: an angle turns by turn . (motion of ends[1] - motion of ends[0]); the
                 first used[1] in use
    own_angle    (k,) int32 angle of the constraint's own normal, spin (k,) [mm] derivative of its gap by this angle
    offset       (k,) [mm] gap at the start of the step plus the allowed motion
    used         (2,) int32
    """

    factors: FactoredRows
    block: Floats3
    nodes: Ints1
    angle_start: Ints1
    angle: Ints1
    lever: Floats2
    ends: Ints2
    turn: Floats2
    own_angle: Ints1
    spin: Floats1
    offset: Floats1
    used: Ints1

    count, gap = property(attrgetter("factors.count")), property(attrgetter("factors.gap"))
    size, slot = property(attrgetter("factors.size")), property(attrgetter("factors.slot"))

    @classmethod
    def allocate(cls, rows: int, entries: int, nodes: int) -> FactoredGradients:
        """Allocate zeroed arrays for so many constraints, entries of both kinds, and nodes."""
        node, angle, own_angle, near = (np.zeros(n, np.int32) for n in (nodes, entries, rows, rows + 1))
        spin, offset = np.zeros(rows), np.zeros(rows)
        factors = replace(FactoredRows.allocate(rows, entries), weight=np.zeros(0))
        return cls(
            factors, np.zeros((entries, 2, 2)), node, near, angle, np.zeros((entries, 2)),
            np.zeros((nodes, 2), np.int32), np.zeros((nodes, 2)), own_angle, spin, offset, np.zeros(2, np.int32),
        )  # fmt: skip

    def to_csr(self, nodes: int) -> Any:
        """Return rows with T inverted and the turning of normals."""
        f, angles, sparse = self.factors, self.used[1], late("scipy.sparse")
        k, start, node, place = f.count, f.start[: f.count + 1], self.nodes[f.node], self.angle_start[: f.count + 1]
        turn = np.stack([-self.turn[:angles], self.turn[:angles]], axis=1).reshape(-1, 2)
        turning = _sparse(np.arange(0, 2 * angles + 1, 2), self.nodes[self.ends[:angles].ravel()], turn, nodes)
        lever, angle = self.lever[: place[-1]], self.angle[: place[-1]]
        levers = [sparse.csr_array((lever[:, c], angle, place), (k, angles)) for c in range(2)]
        along = [_sparse(start, node, self.block[:, c], nodes) + levers[c] @ turning for c in range(2)]
        own = np.where(f.own[:k] >= 0, self.nodes[f.own[:k]], -1)
        return _with_inverse(f, along, own, nodes) + sparse.diags_array(self.spin[:k]) @ turning[self.own_angle[:k]]


class Solve(NamedTuple):
    """Result of a contact solve: Gauss-Seidel iterations or other passes over all rows, scaled natural residual, number
    of rows without any compliance, and the largest correction of a node [mm]."""

    sweeps: int
    residual: float
    rigid_rows: int
    largest_correction: float


class Enforcement(ABC):  # noqa: B024 - its two kinds share no method
    """Finds contact forces from gap constraints. Subclasses derive from one of the classes below.

    exact   closed gaps are zero and sticking constraints do not slip; False for springs, which deform
    pressure_before_contact  True for a pressure curve that begins while the gap is still open
    length_scale  name of the field [mm] that gives the gap range of the pressure; "" if only overlaps matter
    time_scale    name of the field [s] by which the force depends on the rate of slip; "" if it does not
    forces  how they act: "frozen" (rows are weights and normals), "consistent" (rows are the derivatives of the
            gaps, weights and normals included, so that contact makes no energy) or "auto" (consistent in dynamics).
            A plugin component with this choice has a field of this name; it also accepts "published" and "conjugate"
    """

    exact: ClassVar[bool] = True
    pressure_before_contact: ClassVar[bool] = False
    length_scale: ClassVar[str] = ""
    time_scale: ClassVar[str] = ""
    forces = "frozen"


class ExplicitEnforcement(Enforcement):
    """Base of enforcements for explicit integrators, which correct predicted positions in the same step.

    factored   True: `solve` also takes rows before their coupling is inverted, `FactoredRows` and
               `FactoredGradients`. They come first if all constraints can be given so; None asks for `Rows`

    Rows of consistent forces are the derivatives of the gaps at the start of the step, and `Rows.gap` is the predicted
    motion less the allowed motion (docs/theory/contact-energy.md). Rows of frozen forces are weights and normals at
    the end of the step, and `Rows.gap` is the predicted gap.
    """

    factored: ClassVar[bool] = False

    @abstractmethod
    def solve(self, rows: Any, compliance: Floats, multipliers: Floats, force: Floats) -> Solve | None:
        """Fill `multipliers` and `force` so that the constraints hold at the corrected positions,
        predicted + compliance * force. Return None, with both unchanged, if rows that are not `Rows` cannot be solved.

        rows        `Rows`; any `GapRows` if `factored`
        compliance  (N, 2) [mm/N]  displacement per force within the step; 0 if motion is prescribed
        multipliers (1 or 2, slots) [N]  warm start in, nodal forces y out; slots without a row become 0
        force       (N, 2) [N]  contact forces on all nodes, G^T y; overwritten
        """

    def solve_factored(
        self, rows: FactoredRows, compliance: Floats, multipliers: Floats, force: Floats
    ) -> Solve | None:
        """Call `solve`. An enforcement with a method of this older name gets these rows there."""
        return self.solve(rows, compliance, multipliers, force)

    def solve_gradients(
        self, rows: FactoredGradients, compliance: Floats, multipliers: Floats, force: Floats
    ) -> Solve | None:
        """Call `solve`. An enforcement with a method of this older name gets these rows there."""
        if type(self).solve_factored is not ExplicitEnforcement.solve_factored:
            return None  # its `solve` takes `Rows` alone
        return self.solve(rows, compliance, multipliers, force)


@dataclass
class Conditions:
    """The gap constraints of all contacts at a trial state, one for each of k slots.

    r is 1, or 2 with friction: normal, then tangential.

    present    (k,) bool   True if the slot has a constraint; other slots have no force
    gap        (k,) [mm]   positive when open
    slip       (k,) [mm]   since the last accepted step; (0,) without friction
    force      (r, k) [N]  trial multipliers y
    anchor     (r, k) [N]  multipliers of the last augmentation, see `ImplicitEnforcement.augments`
    measure    (k,) [mm]   length of slave surface that belongs to the constraint
    size       (k,) [mm]   length of the slave segments there, to scale gaps
    bound      (3, k)      friction bound: coefficient, adhesion, cap; (3, 0) without friction
    stiffness  (k,) [N/mm] force per unit of gap, from the stiffness of the nodes on both surfaces; inf if
                           motion is prescribed on both sides
    """

    present: Any
    gap: Floats
    slip: Floats
    force: Floats
    anchor: Floats
    measure: Floats
    size: Floats
    bound: Floats
    stiffness: Floats


@dataclass
class Response:
    """The linearised equations of an enforcement for the forces of each constraint.

    Rows are the normal row and, with friction, the tangential row; the normal row is independent of the other.

        residual + by_force dy + by_gap d(gap or slip) = 0
        in the tangential row also: + cross_force dy_n + cross_gap d(gap)

    residual     (r, k) [N]     zero if the constraint holds
    by_force     (r, k) [-]     d(residual)/d(force of its own row)
    by_gap       (r, k) [N/mm]  d(residual)/d(gap), d(residual)/d(slip)
    cross_force  (k,) [-]       of the tangential row by the normal force; (0,) without friction
    cross_gap    (k,) [N/mm]    of the tangential row by the gap; (0,) without friction
    status       (k,) int8      contact state: 0 open, 1 stick, 2 slip (closed without friction counts as slip)
    """

    residual: Floats
    by_force: Floats
    by_gap: Floats
    cross_force: Floats
    cross_gap: Floats
    status: Any

    @classmethod
    def allocate(cls, rows: int, slots: int) -> Response:
        """Allocate zeroed arrays for so many rows and entries."""
        cross = slots if rows > 1 else 0
        residual, by_force, by_gap = (np.zeros((rows, slots)) for _ in range(3))
        return cls(residual, by_force, by_gap, np.zeros(cross), np.zeros(cross), np.zeros(slots, np.int8))


class ImplicitEnforcement(Enforcement):
    """Base of enforcements that find positions and contact forces together, by Newton's method.

    augments  True: after the iteration has converged the forces become the `anchor` and it continues, until
              closed gaps are as small as with exact multipliers
    """

    augments: ClassVar[bool] = False

    @property
    def stores(self) -> bool:
        """True if springs are so soft that they store impact energy; runs warn if they do not return it."""
        return False

    @abstractmethod
    def respond(self, conditions: Conditions, out: Response) -> None:
        """Fill `out`. Residuals are piecewise smooth; at a kink the derivative of any side will do."""
