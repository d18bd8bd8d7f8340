"""Error of friction from the length of load steps, between surfaces that come into contact.

A load step requires of a node that sticks at its end that it has not slipped since its start, also if it was still open
there. The slip of the surfaces before they touched, delta, is then held by friction that has not acted yet. Nodes that
slide forget it, nodes that stick keep it for good. A node that slides in the step in which it touches, by less than
delta, would stick. Left out at the end, it would change forces by

    (K - F) du = N^T dy_n + T^T dy_t,    the rows of the enforcement with the slip ds - delta instead of ds

(F: derivative of the contact forces at fixed multipliers). One factorisation at the end of the run gives the change
(docs/statics.md#friction-and-the-length-of-load-steps).

Of surfaces that roll, nodes enter the contact in every step and leave it again: what the end has forgotten is known by
the share of the contact that a step exchanges.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import block_array, csc_array, diags_array
from scipy.sparse.linalg import splu

from contactlab.api import Floats, FrictionBound, Ints, Response, RunWarning, Step
from contactlab.api.arrays import Flags
from contactlab.api.frame import STICK
from contactlab.model.implicit_model import ImplicitModel
from contactlab.run.controlled_step import better_steps

HIGH = 0.05  # of the shear: what peak pressures and friction work are held to
SMALL = 0.01  # of the normal forces: shear below it is an error of none
SOLVED = 1e-6  # of the right-hand side
PASSAGE = 1.0 / 15.0  # of the contact in a step: forces and friction work of rollers are off by 5 % of half of them
ROLLED = 0.5  # of the contact: what must have been exchanged
GAP, CLOSED, SLID, HELD, WAS = range(5)
SUM, STEPS, LAST = range(3)


class FrictionError:
    """Follows the slips that friction holds although the surfaces were apart.

    pairs    those with friction
    numbers  (5, k) by multiplier: gap at the end of the last step [mm] (NaN: pressed, or out of reach), what the gap
             closed by and the surfaces slid in it while open [mm], the slip that friction holds in error [mm], delta
             of nodes that stick, delta less the slip of nodes that would, and whether it was pressed
    rolled   (3, pairs) what load steps exchanged of each contact in all, and in how many of them since they began to,
             so far and up to the last exchange
    """

    def __init__(self, model: ImplicitModel) -> None:
        assert model.contact is not None
        self.model, self.contact = model, model.contact
        self.numbers: Floats = np.zeros((5, len(self.contact.conditions.gap)))
        self.pairs = [linear.pair for linear in self.contact.linear if linear.pair.friction is not None]
        self.rolled: Floats = np.zeros((3, len(self.pairs)))
        self.contact.begin_step(model.position, model.state.time)
        self.contact.evaluate(model.position)
        self._take_gaps()

    @property
    def memory(self) -> dict[str, Floats]:
        """Arrays that change during the run, by name."""
        return {"friction_error": self.numbers, "rolled": self.rolled}

    def follow(self, step: Step, dt: float, jumped: bool) -> None:
        """Look at the conditions of an accepted step; one that `jumped` was made in short substeps."""
        c, n = self.contact.conditions, self.numbers
        pressed = c.present & (c.force[0] > 0.0)
        closing = n[GAP] - c.gap
        still_open = c.present & ~pressed & (n[GAP] > 0.0)
        touches = pressed & (n[GAP] > 0.0) & (not jumped)
        sticks = pressed & (self._response().status == STICK)
        n[HELD, ~sticks] = 0.0
        for number, pair in enumerate(self.pairs):
            if not (self.model.integrator.inertia or jumped):
                self._exchange(number, pressed[pair.own], bool(sticks[pair.own].any()))
            own = np.arange(pair.own.start, pair.own.stop)
            self._hold(own[touches[own]], own[(still_open & (closing > 0.0))[own]], closing, sticks)
        still_open &= not jumped
        n[CLOSED] = np.where(still_open, closing, 0.0)
        n[SLID] = np.where(still_open, c.slip, 0.0)
        n[WAS] = pressed
        self._take_gaps()

    def _exchange(self, number: int, pressed: Flags, sticks: bool) -> None:
        """Count what entered the contact of a pair and left it in the same step."""
        rolled, was = self.rolled[:, number], self.numbers[WAS, self.pairs[number].own] > 0.0
        exchanged = min(np.count_nonzero(pressed & ~was), np.count_nonzero(was & ~pressed))
        if sticks and (exchanged or rolled[STEPS]):
            rolled[STEPS] += 1.0
            if exchanged:
                rolled[SUM] += exchanged / np.count_nonzero(pressed)
                rolled[LAST] = rolled[STEPS]

    def _hold(self, touched: Ints, beside: Ints, closing: Floats, sticks: Flags) -> None:
        """Set the slips before contact: of each node as it slid and closed in the step before.

        Nodes that were out of reach then slide like the nearest in `beside`, which are still open. Two that are equally
        near count with their mean: around the first touch of a curve they slide to opposite sides.
        """
        c, n = self.contact.conditions, self.numbers
        closed, slid, slip = n[CLOSED, touched], n[SLID, touched], c.slip[touched]
        if len(beside):
            apart = np.abs(beside - touched[:, None])
            nearest = apart == apart.min(axis=1, keepdims=True)
            others = (nearest @ values[beside] / nearest.sum(axis=1) for values in (closing, c.slip))
            closed, slid = (
                np.where(n[CLOSED, touched] > 0.0, own, other)
                for own, other in zip((closed, slid), others, strict=True)
            )
        share = np.divide(n[GAP, touched], closed, out=np.zeros(len(touched)), where=closed > 0.0)
        before = np.minimum(share, 1.0) * slid
        all_before = (before * slip > 0.0) & (np.abs(before) > np.abs(slip))
        held = np.where(sticks[touched], before, np.where(all_before, before - slip, 0.0))
        # the forces with and without it are both within the bound, and this far apart at most
        most = 2.0 * self._limits(touched) / c.stiffness[touched]
        n[HELD, touched] = np.clip(held, -most, most)

    def _take_gaps(self) -> None:
        c = self.contact.conditions
        self.numbers[GAP] = np.where(c.present & (c.force[0] <= 0.0), c.gap, np.nan)

    def _limits(self, chosen: Ints) -> Floats:
        """Return the largest tangential forces [N] that the bounds of some multipliers allow."""
        c = self.contact.conditions
        return FrictionBound(*c.bound[:, chosen]).limits(c.force[0, chosen], c.measure[chosen])[0]

    def _response(self) -> Response:
        out = Response.allocate(*self.contact.conditions.force.shape)
        self.contact.enforcement.respond(self.contact.conditions, out)
        return out

    def warnings(self, key: str, now: float) -> Iterator[RunWarning]:
        """Warn of pairs whose shear is off; `key` of the scene says how many steps there are, or how long, `now`."""
        yield from self._rolling(key, now)
        if not self.numbers[HELD].any():
            return
        change, force = self._change(), self.contact.conditions.force
        for pair in self.pairs:
            normal, shear = (float(np.linalg.norm(row)) for row in force[:, pair.own])
            share = float(np.linalg.norm(change[pair.own])) / max(shear, SMALL * normal, 1e-300)
            if share > HIGH:
                better = better_steps(key, now, share / HIGH)
                yield RunWarning(
                    "friction-steps", share, HIGH, key,
                    f"{pair.name}: surfaces closed within load steps, and friction also acts on the slip before they "
                    f"touched, from the start of the step: the error of the shear is about "
                    f"{share:.1%} (limit {HIGH:.0%}); write {key} = {better}",
                )  # fmt: skip

    def _rolling(self, key: str, now: float) -> Iterator[RunWarning]:
        for pair, (total, _, steps) in zip(self.pairs, self.rolled.T, strict=True):
            if total > ROLLED and total / steps > PASSAGE:
                share = float(total / steps)
                yield RunWarning(
                    "friction-steps", share, PASSAGE, key,
                    f"{pair.name}: surfaces roll on each other, and a step exchanges {share:.0%} of the contact (limit "
                    f"{PASSAGE:.0%}): nodes that enter it count slips of the whole step, so tangential forces and the "
                    f"work of friction have errors of some per cent or more; write {key} = "
                    f"{better_steps(key, now, share / PASSAGE)}",
                )  # fmt: skip

    def _change(self) -> Floats:
        """Return the change of the tangential forces (k,) [N] if the slips before contact were left out."""
        model, contact = self.model, self.contact
        c, out = contact.conditions, self._response()
        pressed = np.flatnonzero(c.present & (c.force[0] > 0.0)).astype(np.int32)
        free: Flags = np.ones(model.reference.size, bool)
        free[model.prescribed.dof] = False
        stiffness = model.stiffness(model.state["clock"][2])
        model.add_load_stiffness(model.state.time, stiffness, 1.0, 0.0)
        change = contact.linearise(pressed)
        rows = change.normal, change.tangent, change.gap, change.slip
        normal, tangent, gap, slip = (part[:, free] for part in rows)
        matrix = (csc_array(stiffness) - change.force)[free][:, free]
        by_gap, by_force = out.by_gap[:, pressed], out.by_force[:, pressed]
        # rows of conditions in units of length, as gaps and slips are
        size = 1.0 / np.maximum(np.abs(by_gap), np.abs(by_force) * c.stiffness[pressed])
        of_gap, of_force = size * by_gap, size * by_force
        cross = size[1] * out.cross_gap[pressed], size[1] * out.cross_force[pressed]
        held = self.numbers[HELD, pressed]
        would_stick = (held != 0.0) & (out.status[pressed] != STICK)
        of_gap[1, would_stick], of_force[1, would_stick] = 1.0, 0.0
        for part in cross:
            part[would_stick] = 0.0
        blocks = [
            [matrix, -normal.T, -tangent.T],
            [diags_array(of_gap[0]) @ gap, diags_array(of_force[0]), None],
            [
                diags_array(of_gap[1]) @ slip + diags_array(cross[0]) @ gap,
                diags_array(cross[1]),
                diags_array(of_force[1]),
            ],
        ]
        right = np.concatenate([np.zeros(matrix.shape[0] + len(pressed)), of_gap[1] * held])
        found = np.zeros(len(c.gap))
        equations = csc_array(block_array(blocks))
        try:
            solved = splu(equations).solve(right)
        except RuntimeError:  # singular: bodies that nothing but friction holds, at the limit of what it can
            return found
        # two conditions of one node share its traction as they like where slaves end: singular but for round-off
        if np.linalg.norm(equations @ solved - right) <= SOLVED * np.linalg.norm(right):
            y, limit = c.force[1, pressed], self._limits(pressed)
            found[pressed] = np.clip(y + solved[-len(pressed) :], -limit, limit) - y
        return found
