"""Two half passes: each side is the slave in a pass of its own, whose forces act on this side alone.

Sauer & De Lorenzis 2013. The contact's own pass is paired with a pass with exchanged sides. The tractions of both
agree as far as the meshes resolve them; nothing enforces it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from contactlab.api import (
    Conditions,
    ContactDerivatives,
    Floats,
    FrictionBound,
    Ints,
    NormalLaw,
    Response,
    Solve,
    State,
)
from contactlab.api.arrays import Flags
from contactlab.contact.explicit_system import slips
from contactlab.contact.implicit_pressure import ImplicitPressureSystem
from contactlab.contact.linearisation import PairLinearisation
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair
from contactlab.contact.pressure_response import PressureResponse, PressureStore, rub
from contactlab.contact.pressure_system import PressureContactSystem
from contactlab.kernels.contact.pair import tangential_work
from contactlab.kernels.contact.rub import start_slips

TRACE = 1e-150  # stands for zero in matrices: the solver needs symmetric patterns, and sums drop zeros
TOUCH = 1e-6  # segments: this small an overlap has the slope at first contact


class HalfPassLinearisation(PairLinearisation):
    """Forces of the slave's nodes alone, and their derivatives."""

    def __init__(self, pair: OperatorPair, nodes: int) -> None:
        super().__init__(pair, nodes)
        own = np.full((nodes, 2), TRACE)
        own[pair.slave.nodes] = 1.0
        self.own = own.ravel()
        self.given = np.zeros((2, nodes, 2))

    def linearise(self, chosen: Ints, y: Floats) -> ContactDerivatives:
        """Linearise as in a whole pass, without the forces on the master."""
        found = super().linearise(chosen, y)
        matrix = found.force.tocsr()
        acts = np.repeat(self.own, np.diff(matrix.indptr))
        force = csr_array((acts * matrix.data, matrix.indices, matrix.indptr), matrix.shape) + TRACE * found.force.T
        normal, gap = self._acting(found.normal, found.gap)
        tangent, slip = (None, None) if found.tangent is None else self._acting(found.tangent, found.slip)
        return ContactDerivatives(normal, tangent, gap, slip, force.tocsr())

    def _acting(self, along: Any, change: Any) -> tuple[Any, Any]:
        """Return directions (c, 2N) on the slave alone, and derivatives; both with the pattern of their sum."""
        along, change = along.tocsr(), change.tocsr()
        own = csr_array((self.own[along.indices] * along.data, along.indices, along.indptr), along.shape)
        return (own + TRACE * change).tocsr(), (change + TRACE * along).tocsr()

    def add_forces(self, multipliers: Floats, normal: Floats, tangential: Floats) -> None:
        """Add the nodal forces of the slave to (N, 2) each; the second is (0, 2) without friction."""
        own, given = self.pair.slave.nodes, self.given
        given[:] = 0.0
        super().add_forces(multipliers, given[0], given[1, : len(tangential)])
        normal[own] += given[0, own]
        if len(tangential):
            tangential[own] += given[1, own]


class HalfPassResponse(PressureResponse):
    """Residuals of pressures, and half-pass friction by springs with the stiffness of the law at first contact.

    Exact stick in both passes would leave the shear of both sides undetermined. Other pairs stick exactly.

    half  (k,) True if a slot belongs to a half pass
    """

    def __init__(self, law: NormalLaw, stiffness: Floats, passes: tuple[ContactPair, ...]) -> None:
        super().__init__(law, stiffness)
        self.half = np.concatenate([np.full(pair.slots, pair.half) for pair in passes])

    def rub(self, c: Conditions, out: Response) -> None:
        """Apply springs from the force at the start of the step, within the bound."""
        shear = c.measure * shear_stiffness(self.law, self.stiffness, c.size)
        softness = np.divide(1.0, shear, out=np.zeros_like(shear), where=self.half & c.present & (shear > 0.0))
        rub(replace(c, slip=c.slip + softness * (c.force[1] - c.anchor[1])), out)
        out.by_force[1] += out.by_gap[1] * softness


class HalfPassSystem(ImplicitPressureSystem):
    """Pairs with some half passes: both passes book friction, half each."""

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Return no directions for impulses: impulses on one side alone would change momentum."""
        none = csr_array((len(chosen), self.start.size))
        return none, none if self.friction else None


class HalfPassContactSystem(PressureContactSystem):
    """`PressureContactSystem` with rows of half passes that act on their slave alone, with friction by springs.

    made  rows of all passes; after a step `rows` counts the rows in reports
    """

    def __init__(self, pairs: tuple[ContactPair, ...], store: PressureStore, state: State, densities: Floats) -> None:
        super().__init__(pairs, store, state, densities)
        slots, nodes = self.multipliers.shape[1], len(state["displacement"])
        self.of_pass = np.repeat(np.arange(len(pairs)), [pair.slots for pair in pairs])
        self.half = np.array([pair.half for pair in pairs])[self.of_pass]
        self.share = np.array([pair.share for pair in pairs])[self.of_pass]
        self.acts = np.ones((len(pairs), nodes), np.bool_)
        for acts, pair in zip(self.acts, pairs, strict=True):
            if pair.half:
                acts[:] = False
                acts[pair.slave.nodes] = True
        if self.friction:
            sizes = np.concatenate([np.full(pair.slots, pair.size) for pair in pairs])
            found = shear_stiffness(store.law, store.stiffness, sizes)
            self.shear[:] = [float(found[pair.own].max()) if pair.half else 0.0 for pair in pairs]
        self.visible = sum(pair.slots for pair in self.pairs)
        self.made, self.rubbed = 0, np.zeros(slots)

    def _solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        if self.friction:
            self.rubbed[:] = self.multipliers[1]
        done = super()._solve(predicted, current, compliance, force)
        self.made = self.rows.count
        self._show()
        return done

    def _show(self) -> None:
        """Keep the rows of the contacts of the scene: rows of second passes are behind them."""
        self.rows.count = int(np.count_nonzero(self.rows.slot[: self.made] < self.visible))

    def _push(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> tuple[int, float]:
        rows, end = self.rows, int(self.rows.start[self.rows.count])
        slot = rows.slot[: rows.count]
        of_entry = np.repeat(np.arange(rows.count), np.diff(rows.start[: rows.count + 1]))
        left = ~self.acts[self.of_pass[slot[of_entry]], rows.node[:end]]
        rows.normal_weight[:end][left] = 0.0
        if not len(rows.slip):
            return super()._push(predicted, current, compliance, force)
        half = self.half[slot]
        shear = self._springs(current, half)
        tangent = rows.tangent_weight[:end].copy()
        kept = np.where(left[:, None], 0.0, tangent)
        np.add.at(force, rows.node[:end], kept * shear[of_entry, None])
        # rows without weights need no solution
        rows.tangent_weight[:end][half[of_entry]] = 0.0
        done = super()._push(predicted, current, compliance, force)
        self.multipliers[1, slot[half]] = shear[half]
        rows.tangent_weight[:end] = kept
        # slips belong to both sides
        unseen = ((tangent - kept) * (predicted - current + compliance * force)[rows.node[:end]]).sum(axis=1)
        seen = (kept * (predicted - current)[rows.node[:end]]).sum(axis=1)
        rows.slip[: rows.count][half] = np.bincount(of_entry, seen + unseen, rows.count)[half]
        return done

    def _springs(self, current: Floats, half: Flags) -> Floats:
        """Return tangential forces (count,) [N] of springs after the slip of the step; 0 in rows of other passes."""
        rows, count = self.rows, self.rows.count
        slot = rows.slot[:count]
        start_slips(count, rows, current - self.state.last_dt * self.velocity, current)
        stiffness = rows.measure[:count] * shear_stiffness(self.law, self.stiffness[slot], rows.size[:count])
        limit, _ = FrictionBound(*rows.bound[:, :count]).limits(self.multipliers[0, slot], rows.measure[:count])
        wish = self.rubbed[slot] - stiffness * rows.slip[:count]
        self.multipliers[1, slot[half]] = 0.0
        return np.where(half, np.clip(wish, -limit, limit), 0.0)

    def friction_work(self, mean_velocity: Floats, dt: float, compliance: Floats, force: Floats) -> tuple[float, float]:
        """Return work and dissipation of the tangential forces; see `contactlab.api.ContactEquations`."""
        if not self.friction:
            return 0.0, 0.0
        self.rows.count = self.made
        work, _ = tangential_work(self.made, self.rows, self.multipliers, mean_velocity, dt, compliance, force)
        slip, _ = slips(self.rows, len(self.share), compliance, force)
        self._show()
        return work, -float((self.share * self.multipliers[1]) @ slip)

    @property
    def stiffened(self) -> bool:
        """True if a slope of the last step is steeper than `rates` allowed for."""
        self.rows.count = self.made
        found = super().stiffened
        self._show()
        return found


def shear_stiffness(law: NormalLaw, stiffness: Floats, size: Floats) -> Floats:
    """Return shear per slip (k,) [MPa/mm]: the slope of the pressure per overlap at first contact."""
    depth = TOUCH * np.where(size > 0.0, size, 1.0)
    pressure, slope = np.zeros_like(depth), np.zeros_like(depth)
    law.pressure(np.minimum(-depth, law.begins()), stiffness, size, pressure, slope)
    return -slope
