"""A normal law: the energy of surfaces, residuals of pressures for implicit integrators, exact friction under them."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from contactlab.api import Conditions, Floats, FrictionBound, ImplicitEnforcement, NormalLaw, Response
from contactlab.api.arrays import Flags
from contactlab.api.frame import OPEN, SLIP, STICK
from contactlab.contact.pair import ContactPair, initial_gaps
from contactlab.contact.pressure_memory import PressureMemory, named

POINTS, WEIGHTS = 0.5 * (np.polynomial.legendre.leggauss(4)[0] + 1.0), 0.5 * np.polynomial.legendre.leggauss(4)[1]
DOUBLED = 30  # doublings of a depth, until the law gives a force there


class PressureStore:
    """Energy of surfaces: length times the integral of the pressure over constraints, at their last positions.

    start      (k,) [mm] gaps at the start of a step in time, filled if `follows_steps`, as the response needs them
    stiffness  (k,) [MPa/mm] of the cells behind each slot
    memory     numbers in addition to the gap; None for a law of the gap alone
    beginning  [mJ] at the start of the run
    """

    def __init__(
        self,
        law: NormalLaw,
        pairs: tuple[ContactPair, ...],
        stiffness: Floats,
        reference: Floats,
        memory: PressureMemory | None = None,
    ) -> None:
        self.law, self.pairs, self.stiffness, self.memory = law, pairs, stiffness, memory
        self.start, self.follows_steps = np.full(len(stiffness), np.inf), False
        for pair in pairs:
            initial_gaps(pair, reference)
        self.beginning = 0.0
        if memory is None:  # else it begins when the needed fields exist
            self.begin()

    def begin(self) -> None:
        """Take the present energy as the initial energy."""
        self.beginning = self.energy()

    def energy(self) -> float:
        """Return the energy [mJ] now."""
        total = 0.0
        for pair in self.pairs:
            own = pair.own
            gaps = np.minimum(pair.gaps[:, 0], self.law.begins())
            stored = self.law.energy(gaps, self.stiffness[own], pair.full, **named(self.memory, own))
            total += pair.share * float(pair.cover @ stored)
        return total

    def since_start(self) -> float:
        """Return the energy [mJ] gained since the start."""
        return self.energy() - self.beginning

    def accept(self, c: Conditions) -> None:
        """Update the memory after an implicit step that ends at the present constraints."""
        if self.memory is not None:
            gap = np.where(c.present, c.gap, self.law.begins())
            self.memory.accept(gap, self.stiffness, c.size, c.slip if len(c.slip) else None)


class PressureResponse(ImplicitEnforcement):
    """Residuals y_n - length * pressure(gap), and |y_t| <= bound.

    stiffness  (k,) [MPa/mm] of the cells behind each slot
    memory     numbers in addition to the gap; None for a law of the gap alone
    found      (2, k) pressure and its derivative by the gap
    """

    exact: ClassVar[bool] = False

    def __init__(self, law: NormalLaw, stiffness: Floats, memory: PressureMemory | None = None) -> None:
        self.law, self.stiffness, self.memory = law, stiffness, memory
        self.found = np.zeros((2, len(stiffness)))
        self.first = law.begins()

    def respond(self, conditions: Conditions, out: Response) -> None:
        """See `contactlab.api.ImplicitEnforcement`."""
        c = conditions
        acts = self.press(c)
        out.residual[0] = c.force[0] - np.where(acts, c.measure * self.found[0], 0.0)
        out.by_force[0] = 1.0
        out.by_gap[0] = np.where(acts, -c.measure * self.found[1], 0.0)
        out.status[:] = np.where(acts, SLIP, OPEN)
        if len(out.residual) > 1:
            self.rub(c, out)

    def press(self, c: Conditions) -> Flags:
        """Fill `found` and return which constraints (k,) are closed.

        A surface that a correction opened by less than the displacement under its force stays closed, on the tangent of
        the law at this force, as with exact multipliers: stiff laws would open and close by linearisation errors.
        """
        self.answer(np.where(c.present, c.gap, self.first), c.size, self.found)
        closed: Flags = c.present & (self.found[0] > 0.0)
        stays = c.present & ~closed & (c.force[0] > 0.0)
        stays[stays] = c.force[0, stays] > c.stiffness[stays] * (c.gap[stays] - self.first)
        if stays.any():
            closed |= self._hold(c, stays)
        return closed

    def rub(self, c: Conditions, out: Response) -> None:
        """Fill the friction response: nodes in stick do not slip."""
        rub(c, out)

    def answer(self, gap: Floats, size: Floats, out: Floats) -> None:
        """Fill `out` (2, k) like `found` for gaps and sizes (k,) [mm]."""
        beside = named(self.memory, slice(None))
        self.law.pressure(np.minimum(gap, self.first), self.stiffness, size, out[0], out[1], **beside)

    def _hold(self, c: Conditions, stays: Flags) -> Flags:
        """Fill `found` of constraints that stay closed with tangents at their force; return which have one."""
        wish = np.divide(c.force[0], c.measure, out=np.zeros_like(c.measure), where=stays & (c.measure > 0.0))
        depth, there = np.divide(wish, self.stiffness), np.zeros_like(self.found)
        short = stays
        for _ in range(DOUBLED):
            gap = np.where(stays, np.minimum(c.gap, self.first) - depth, self.first)
            self.answer(gap, c.size, there)
            short = stays & (there[0] < wish)
            if not short.any():
                break
            depth[short] *= 2.0
        held: Flags = stays & ~short & (there[1] < 0.0)
        # a law that is not convex presses by no tangent at zero pressure
        there[0] = np.minimum(there[0] + there[1] * (c.gap - gap), 0.0)
        self.found[:, held] = there[:, held]
        return held


class MeanPressureResponse(PressureResponse):
    """Residuals of mean pressures over a step in time, whose work is the stored energy (Armero & Petocz 1998).

    Springs stiffer than the dynamic stiffness of their nodes over the step have pressures at its end: the
    mean would ring from step to step.

    start  (k,) [mm] gaps at the start of the step
    share  (k,) of the mean in the pressure
    """

    def __init__(self, law: NormalLaw, stiffness: Floats, start: Floats, memory: PressureMemory | None) -> None:
        super().__init__(law, stiffness, memory)
        self.start, self.share = start, np.zeros(len(stiffness))

    def press(self, c: Conditions) -> Flags:
        """See `PressureResponse`."""
        super().answer(np.where(c.present, c.gap, self.first), c.size, self.found)
        spring = -self.found[1] * c.measure
        ratio = np.divide(spring, c.stiffness, out=np.zeros_like(spring), where=c.present & np.isfinite(c.stiffness))
        self.share[:] = 1.0 / np.maximum(1.0, ratio) ** 2
        return super().press(c)

    def answer(self, gap: Floats, size: Floats, out: Floats) -> None:
        """Fill `out` (2, k) with shares of mean and end pressure, and their derivatives by `gap` (k,)."""
        last = np.zeros_like(out)
        super().answer(gap, size, last)
        self._mean(gap, size, last, out)
        out *= self.share
        out += (1.0 - self.share) * last

    def _mean(self, gap: Floats, size: Floats, last: Floats, out: Floats) -> None:
        """Fill `out` (2, k) with means over gaps from the start to `gap` (k,) [mm], and their derivatives by `gap`.

        last  (2, k) pressures at `gap` and their derivatives
        """
        beside, first = named(self.memory, slice(None)), self.first
        begin, end = np.minimum(self.start, first), np.minimum(gap, first)
        pressure, slope = np.zeros_like(gap), np.zeros_like(gap)
        out[:] = 0.0
        for share, weight in zip(POINTS, WEIGHTS, strict=True):
            self.law.pressure(begin + share * (end - begin), self.stiffness, size, pressure, slope, **beside)
            out += weight * np.stack([pressure, share * slope])
        # the part of the path beyond the gap at which the law begins
        crosses = (gap >= first) != (self.start >= first)
        if crosses.any():
            way = np.where(crosses, gap - self.start, 1.0)
            out[0] = np.where(crosses, (end - begin) / way * out[0], out[0])
            out[1] = np.where(crosses, (np.where(gap < first, last[0], 0.0) - out[0]) / way, out[1])


def rub(c: Conditions, out: Response) -> None:
    """Fill exact friction: nodes in stick do not slip, the others carry their bound."""
    stiffness = np.where(c.present, c.stiffness, 0.0)
    limit, growth = FrictionBound(*c.bound).limits(c.force[0], np.where(c.present, c.measure, 0.0))
    growth = np.where(c.force[0] > 0.0, growth, 0.0)
    trial = c.force[1] - stiffness * c.slip
    # a force at one end of its bound that would jump to the other sticks first: else Newton's method oscillates
    turns = (trial * c.force[1] < 0.0) & (limit > 0.0)
    sticks = (np.abs(trial) < limit) | turns
    sign = np.sign(trial)
    out.residual[1] = np.where(sticks, stiffness * c.slip, c.force[1] - sign * limit)
    out.by_force[1] = np.where(sticks, 0.0, 1.0)
    out.by_gap[1] = np.where(sticks, stiffness, 0.0)
    out.cross_force[:] = np.where(sticks, 0.0, -sign * growth)
    out.cross_gap[:] = 0.0
    out.status[:] = np.where(sticks, STICK, np.where(limit > 0.0, SLIP, out.status))
