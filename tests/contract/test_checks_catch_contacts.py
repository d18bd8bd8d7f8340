"""Every check of contact algorithms catches a planted defect, and a right one in plain NumPy passes all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0
from contactlab_segments.node_on_segment import NodeOnSegment

from contactlab.api import (
    Candidates,
    ContactView,
    Floats,
    GapAlgorithm,
    GapConditions,
    PieceDerivatives,
    Pieces,
    Surface,
    SurfacePositions,
)
from contactlab.testing import Expected, NotApplicable, contact, contact_derivatives, contact_inputs, run_check
from contactlab.testing.assertions import Check


@dataclass(frozen=True)
class Rods(GapAlgorithm):
    """Slave nodes against the nearest master segment, written as simply as a third party would; one flaw or none."""

    flaw: str = ""
    passes_patch_test: ClassVar[bool] = False

    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        slave, at = view.slave, view.at
        found = [self._condition(i, view) for i in range(len(slave.nodes))]
        rows = [row for row in found if row is not None]
        k = len(rows)
        normal = np.array([np.outer(w, n) for _, w, n, _, _ in rows]).reshape(3 * k, 2)
        along = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
        if self.flaw == "tangent turned round":
            along = -along
        if self.flaw == "single precision":
            normal = normal.astype(np.float32)
        if self.flaw == "columns side by side":
            normal = np.asfortranarray(normal)
        return GapConditions(
            start=3 * np.arange(k + 1, dtype=np.int32),
            node=np.array([nodes for nodes, *_ in rows], np.int32).reshape(-1),
            normal_weight=normal,
            tangent_weight=along if tangent or self.flaw == "tangents made unasked" else np.zeros((0, 2)),
            gap=np.array([gap for *_, gap, _ in rows], float) + (0.001 if self.flaw == "gap with an offset" else 0.0),
            measure=self._measures(slave, at)[[i for *_, i in rows]],
            owner=np.array([i for *_, i in rows], np.int32),
        )

    def _condition(self, i: int, view: ContactView):  # type: ignore[no-untyped-def]
        slave, master, at, near, reach, _ = view
        best = None
        for m in self._candidates(i, slave, master, near):
            a, b = at.master[master.segments[m]]
            tangent = (b - a) / np.hypot(*(b - a))
            normal = np.array([tangent[1], -tangent[0]])
            share = (at.slave[i] - a) @ (b - a) / ((b - a) @ (b - a))
            gap = (at.slave[i] - a) @ normal
            if not -1e-9 <= share <= 1 + 1e-9 or not self._faces(i, slave, at, normal):
                continue
            if abs(gap) < (np.inf if self.flaw == "reach ignored" else reach) and (
                best is None or abs(gap) < abs(best[3])
            ):
                nodes = [slave.nodes[i], *master.nodes[master.segments[m]]]
                best = (nodes, np.array([1.0, share - 1.0, -share]), normal, gap, i)
        return None if best is None else self._flawed(best, at)

    def _candidates(self, i: int, slave: Surface, master: Surface, near: Candidates) -> set[int]:
        if self.flaw == "reach ignored":
            return set(range(len(master.segments)))
        segments = [s for s in slave.node_segments[i] if s >= 0]
        return {int(m) for s in segments for m in near.master[near.start[s] : near.start[s + 1]]}

    def _faces(self, i: int, slave: Surface, at: SurfacePositions, normal: Floats) -> bool:
        if self.flaw == "back sides touch too":
            return True
        ends = at.slave[slave.segments[[s for s in slave.node_segments[i] if s >= 0]]]
        along = (ends[:, 1] - ends[:, 0]).sum(axis=0)
        return bool(normal @ [along[1], -along[0]] < 0.0)

    def _flawed(self, best: Any, at: SurfacePositions) -> Any:
        nodes, weights, normal, gap, i = best
        if self.flaw == "normal never turns":
            normal = np.array([0.0, 1.0])
            gap = weights @ np.concatenate([at.slave, at.master[::-1]])[nodes] @ normal
        if self.flaw == "normal into the slave":
            normal, gap = -normal, -gap
        if self.flaw == "normal of length 1.1":
            normal, gap = 1.1 * normal, 1.1 * gap
        if self.flaw == "master pushed too little":
            weights = weights * [1.0, 0.99, 0.99]
        if self.flaw == "shares exchanged":
            weights = weights[[0, 2, 1]]
            gap = gap if abs(gap) > 0.0 else 0.0
        return nodes, weights, normal, gap, i

    def _measures(self, slave: Surface, at: SurfacePositions) -> Floats:
        edge = at.slave[slave.segments[:, 1]] - at.slave[slave.segments[:, 0]]
        length = np.hypot(edge[:, 0], edge[:, 1])
        share = 1.0 if self.flaw == "whole segments as measure" else 0.5
        return np.array([share * sum(length[s] for s in pair if s >= 0) for pair in slave.node_segments])


@pytest.mark.parametrize("check", contact.CHECKS)
def test_a_right_algorithm_passes(check: Check) -> None:
    try:
        check(Rods())
    except Expected:
        assert check is contact.patch_test
    except NotApplicable:
        declined = {
            contact.pieces_keep_their_bounds,
            contact.multipliers_are_biorthogonal,
            contact.patch_test_on_quadratic_edges,
            contact_inputs.pieces_are_filled,
            contact_inputs.a_notch_is_held_by_both_sides,
            contact_derivatives.derivatives_are_right,
        }
        assert check in declined


MORTAR, NODES = MortarP0(), NodeOnSegment()
"""Their kernels are there: classes derived from theirs would have kernels of their own, to be compiled."""


@dataclass(frozen=True)
class Flawed(MortarP0):
    """Mortar contact with one named flaw."""

    flaw: str = ""
    calls: ClassVar[list[int]] = [0]
    seen: ClassVar[dict[Any, Floats]] = {}
    last: ClassVar[list[float]] = [0.0]

    def capacity(self, slave: Surface, near: Candidates) -> int:
        return 1 if self.flaw == "capacity for one piece" else super().capacity(slave, near)

    def pieces(self, view: ContactView, out: Pieces) -> int:
        count = MORTAR.pieces(view, out)
        if self.flaw == "middle nodes left out" and out.M.shape[1] == 3:
            out.M[:, :2] += 0.5 * out.M[:, 2:]
            out.M[:, 2] = 0.0
        if self.flaw == "counts its calls":
            self.calls[0] += 1
            out.M[:count] *= 1.0 + 1e-14 * self.calls[0]
        if self.flaw == "positions written":
            view.at.slave[0] += 1e-3
        if self.flaw == "adds to what was there":
            out.D[:count] += np.nan_to_num(out.D[count : 2 * count], nan=1e-9)
        if self.flaw == "knows its array again":
            again = self.seen.setdefault((id(view.at.slave), count), out.M[:count].copy())
            out.M[:count] = again
        if self.flaw == "remembers the last step":
            self.last[0], before = float(view.at.slave[0, 0]), self.last[0]
            out.M[:count] *= 1.0 + 1e-9 * before
        if self.flaw == "moment":
            out.M[:count] = out.M[:count, ::-1]
        return 0 if self.flaw == "never finds anything" else count

    def normals(self, view: ContactView, pieces: Pieces, count: int, out: Floats) -> None:
        if self.flaw == "one normal for both times":
            out[:] = pieces.normal
        else:
            super().normals(view, pieces, count, out)

    def derivatives(self, view: ContactView, pieces: Pieces, count: int, out: PieceDerivatives) -> bool:
        if self.flaw == "no derivatives at all":
            out.count = out.normal_count = 0
            return True
        return MORTAR.derivatives(view, pieces, count, out)


class Single(NodeOnSegment):
    """Says that a node carries two conditions, and gives it one."""

    def pieces(self, view: ContactView, out: Pieces) -> int:
        count = NODES.pieces(view, out)
        m, first = len(view.slave.nodes), out.multiplier[:count, 0].copy()
        for array in (out.slave, out.multiplier, out.master, out.D, out.M, out.T):
            array[: (first < m).sum()] = array[:count][first < m]
        return int((first < m).sum())


class FarSighted(Rods):
    """Looks as far as candidates are listed."""

    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        return super().conditions(view._replace(reach=np.inf), tangent=tangent)


class Modest(Flawed):
    """Passes the patch test and says that it does not."""

    passes_patch_test: ClassVar[bool] = False


class Boastful(NodeOnSegment):
    """Fails the patch test and says that it passes."""

    passes_patch_test: ClassVar[bool] = True

    def pieces(self, view: ContactView, out: Pieces) -> int:
        return NODES.pieces(view, out)


class Orthogonal(Flawed):
    """Says that its multipliers are not coupled."""

    biorthogonal: ClassVar[bool] = True


WRONG: list[tuple[Check, Any]] = [
    (contact.some_conditions, Flawed(flaw="never finds anything")),
    (contact.forces_cancel, Rods("master pushed too little")),
    (contact.moments_cancel_on_a_flat, Flawed(flaw="moment")),
    (contact.weights_belong_to_the_gap, Rods("gap with an offset")),
    (contact.weights_are_the_derivative, Rods("shares exchanged")),
    (contact.gap_is_positive_when_open, Rods("normal into the slave")),
    (contact.normals_point_to_the_slave, Rods("normal into the slave")),
    (contact.normals_point_to_the_slave, Rods("normal of length 1.1")),
    (contact.tangents_run_along_the_slave, Rods("tangent turned round")),
    (contact.tangents_run_along_the_slave, Rods("tangents made unasked")),
    (contact.measures_sum_to_the_cover, Rods("whole segments as measure")),
    (contact.multipliers_are_biorthogonal, Orthogonal()),
    (contact.patch_test, Boastful()),
    (contact.patch_test_on_quadratic_edges, Flawed(flaw="middle nodes left out")),
    (contact.nothing_when_apart, Rods("reach ignored")),
    (contact.only_facing_surfaces, Rods("back sides touch too")),
    (contact.rigid_motion_leaves_gaps, Rods("normal never turns")),
    (contact.slip_is_objective, Flawed(flaw="one normal for both times")),
    (contact.pieces_keep_their_bounds, Flawed(flaw="capacity for one piece")),
    (contact.same_answer_twice, Flawed(flaw="counts its calls")),
    (contact_inputs.inputs_are_only_read, Flawed(flaw="positions written")),
    (contact_inputs.pieces_are_filled, Flawed(flaw="adds to what was there")),
    (contact_inputs.arrays_are_of_their_types, Rods("single precision")),
    (contact_inputs.arrays_are_of_their_types, Rods("columns side by side")),
    (contact_inputs.positions_change_in_place, Flawed(flaw="knows its array again")),
    (contact_inputs.memory_is_all_it_remembers, Flawed(flaw="remembers the last step")),
    (contact_inputs.reach_is_kept, FarSighted()),
    (contact_inputs.a_notch_is_held_by_both_sides, Single()),
    (contact_derivatives.derivatives_are_right, Flawed(flaw="no derivatives at all")),
    (contact_derivatives.derivatives_are_right, Rods("tangent turned round")),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
def test_wrong_algorithms_are_caught(caught: Any, check: Check, part: Any) -> None:
    caught(check, part)


def test_a_fact_that_is_not_declared_is_told() -> None:
    outcome = run_check(contact.patch_test, Modest())
    assert outcome.status == "passed"
    assert "declare passes_patch_test" in outcome.reason


def test_what_was_never_promised_is_expected() -> None:
    outcome = run_check(contact.patch_test, NodeOnSegment())
    assert outcome.status == "expected"
    assert "passes_patch_test is False" in outcome.reason


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} == set(contact.CHECKS)
