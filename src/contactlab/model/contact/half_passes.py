"""Contacts whose sides each press by a pass of their own: which can, and their forces in explicit steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import Enforcement, Floats, FrictionBound, FrictionLaw, NormalLaw, Solve, State
from contactlab.api.arrays import Flags
from contactlab.contact.explicit_system import slips
from contactlab.contact.half_passes import shear_stiffness
from contactlab.contact.pair import ContactPair
from contactlab.contact.pressure_response import PressureStore
from contactlab.errors import PartError, SceneError, below
from contactlab.kernels.contact.rows import tangential_work
from contactlab.kernels.contact.rub import start_slips
from contactlab.model.contact.pressure_system import PressureContactSystem
from contactlab.parts.registry import split_spec

if TYPE_CHECKING:
    from contactlab.errors import Where

LAWS = "linear-pressure, exponential-pressure, tabular-pressure"


def refuse_half_passes(
    spec: Any, enforcement: Enforcement, friction: FrictionLaw | None, rigid: str, where: Where
) -> None:
    """Raise PartError or SceneError for a contact that two half passes cannot be made of.

    rigid  the name of a side that is rigid, or nothing
    """
    if not isinstance(enforcement, NormalLaw) or enforcement.named():
        use = split_spec("enforcement", spec.enforcement, where)[0] if spec.enforcement else "the integrator's own"
        raise PartError(
            "two half passes press by a law of the gap: multipliers of both sides, or springs of single nodes, would "
            "hold the same gap twice and leave the force on either side undetermined",
            where=below(where, "enforcement"), got=use, allowed=LAWS, hint='write enforcement = "linear-pressure"',
        )  # fmt: skip
    if rigid:
        raise SceneError(
            "two half passes need two sides that deform: a rigid surface has no cells behind it that would press",
            where=below(where, "algorithm"), got=f"passes = 2, with {rigid}", allowed="passes = 1 with a rigid side",
        )  # fmt: skip
    if friction is not None and friction.varies:
        raise PartError(
            "this friction law follows the motion, and friction of half passes is that of springs with constant bounds",
            where=below(where, "friction"), got=spec.friction, allowed="a law without needs and memory, as coulomb",
            hint="take passes = 1, or a mortar, for this law",
        )  # fmt: skip


class HalfPassContactSystem(PressureContactSystem):
    """As `PressureContactSystem`; rows of half passes act on their slave alone, with friction by springs.

    made  rows of all passes; after a step `rows` counts those that reports show
    """

    def __init__(
        self, pairs: tuple[ContactPair, ...], store: PressureStore, state: State, densities: list[float]
    ) -> None:
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
        """Leave the rows of the contacts of the scene: those of second passes are behind them."""
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
        # nothing is left to find of rows that have no weights
        rows.tangent_weight[:end][half[of_entry]] = 0.0
        done = super()._push(predicted, current, compliance, force)
        self.multipliers[1, slot[half]] = shear[half]
        rows.tangent_weight[:end] = kept
        # slips are those of both sides
        unseen = ((tangent - kept) * (predicted - current + compliance * force)[rows.node[:end]]).sum(axis=1)
        seen = (kept * (predicted - current)[rows.node[:end]]).sum(axis=1)
        rows.slip[: rows.count][half] = np.bincount(of_entry, seen + unseen, rows.count)[half]
        return done

    def _springs(self, current: Floats, half: Flags) -> Floats:
        """Tangential forces (count,) [N] of springs after the slip that led here; 0 in rows that are no half passes."""
        rows, count = self.rows, self.rows.count
        slot = rows.slot[:count]
        start_slips(count, rows.packed.address, current - self.state.last_dt * self.velocity, current)
        stiffness = rows.measure[:count] * shear_stiffness(self.law, self.stiffness[slot], rows.size[:count])
        limit, _ = FrictionBound(*rows.bound[:, :count]).limits(self.multipliers[0, slot], rows.measure[:count])
        wish = self.rubbed[slot] - stiffness * rows.slip[:count]
        self.multipliers[1, slot[half]] = 0.0
        return np.where(half, np.clip(wish, -limit, limit), 0.0)

    def friction_work(self, mean_velocity: Floats, dt: float, compliance: Floats, force: Floats) -> tuple[float, float]:
        """Work and dissipation of the tangential forces; see `contactlab.api.ContactEquations`."""
        if not self.friction:
            return 0.0, 0.0
        self.rows.count = self.made
        address = self.rows.packed.address
        work, _ = tangential_work(self.made, address, self.multipliers, mean_velocity, dt, compliance, force)
        slip, _ = slips(self.rows, len(self.share), compliance, force)
        self._show()
        return work, -float((self.share * self.multipliers[1]) @ slip)

    @property
    def stiffened(self) -> bool:
        """Whether a slope of the last step is steeper than `rates` allowed for."""
        self.rows.count = self.made
        found = super().stiffened
        self._show()
        return found
