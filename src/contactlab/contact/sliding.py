"""Friction data of a contact pair: the bound of its law, constant or by multiplier, and the start of the step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contactlab.api import ContactView, Floats, FrictionBound, FrictionLaw, Ints, Surface
from contactlab.api.surface import SurfacePositions
from contactlab.errors import WrongAnswer
from contactlab.parts.remembered import checked, remember

KEPT = ("coefficient", "adhesion", "cap", "pressure", "slip_rate")
"""First rows of the state of a law that varies."""
FOLLOWED = 1e-6
"""Largest change of bounds that follow slips, over the largest bound."""
DEPTH = 4
"""Number of rounds from which bounds that follow slips are extrapolated."""
TRIES = 60
"""Most iterations to find a rate of slip."""
EXACT = 1e-9
"""Tolerance of a computed slip, over the slip without friction."""


class Sliding:
    """The bound of a law of k multipliers, and the start of the step.

    bound       (3,) coefficient [-], adhesion [MPa], cap [-] of a constant law
    everywhere  the bound also holds at open nodes: every multiplier within the search distance needs a row
    before      (k, 2) normals at the start of the step
    began       positions of both surfaces at the start of the step [mm]
    """

    def __init__(self, law: FrictionLaw, multipliers: int, slave: Surface, at: SurfacePositions) -> None:
        self.law, self.varies = law, law.varies
        self.bound = np.zeros(3) if law.varies else np.array(law.bound())
        self.everywhere = self.bound[1] > 0.0 and not math.isfinite(self.bound[2])
        self.before = np.zeros((multipliers, 2))
        self.began = SurfacePositions(at.slave.copy(), at.master.copy())
        self._views: tuple[ContactView, ContactView] | None = None

    def of(self, slots: Ints | slice) -> Floats:
        """Return the bound (3, n) or (3, 1) of some multipliers in the present step."""
        return self.bound[:, None]

    def view(self, now: ContactView) -> ContactView:
        """Return the view `now` with the positions of the start of the step."""
        if self._views is None or self._views[0] is not now:
            self._views = now, now._replace(at=self.began)
        return self._views[1]


class VaryingSliding(Sliding):
    """The bound of a law that depends on the motion: `kept` (r, k) is a part of the state.

    Its rows are `KEPT`, two rows of positions and one of tractions if the law needs them, and its memory.

    at         positions of both surfaces, as the pair knows them
    tractions  returns tractions [MPa] by the stresses of this moment, for a law that needs them; None of points at
               corners
    """

    def __init__(self, law: FrictionLaw, multipliers: int, slave: Surface, at: SurfacePositions) -> None:
        super().__init__(law, multipliers, slave, at)
        self.slave, self.at, self.per_node = slave, at, multipliers // len(slave.nodes)
        self.kept = np.zeros((rows_of(law), multipliers))
        self.remembered: dict[str, Floats] = {}
        self.size: Floats = np.zeros(multipliers)
        self.time = self.dt = 0.0
        self.seen: tuple[Floats, Floats] | None = None
        self.past: list[tuple[Floats, Floats]] = []  # bounds found by rounds, and their change from the given bounds
        self.softness = 1.0
        self.fields: Mapping[str, Callable[[float], Any]] = {}
        self.tractions: Callable[[], Floats] | None = None

    def of(self, slots: Ints | slice) -> Floats:
        """Return the bound (3, n) of some multipliers in the present step."""
        return np.asarray(self.kept[:3, slots])

    def bind(self, kept: Floats) -> dict[str, Floats]:
        """Keep all in `kept`, a part of the state, from here on. Return the memory and tractions of the law in it."""
        self.kept = kept
        self.remembered = dict(zip(self.law.memory, self.kept[len(self.kept) - len(self.law.memory) :], strict=True))
        remember(self.law, "start", self.law.start(), self.remembered)
        segments, size = self.slave.segments, np.zeros(len(self.slave.nodes))
        length = np.linalg.norm(np.diff(self.at.slave[segments], axis=1)[:, 0], axis=1)
        np.add.at(size, segments, 0.5 * length[:, None])
        self.size = np.tile(size, self.per_node)
        self._take_positions()
        return self.remembered | ({"traction": self._traction} if "traction" in self.law.needs else {})

    @property
    def _traction(self) -> Floats:
        return np.asarray(self.kept[len(KEPT) + 2 * ("position" in self.law.needs)])

    def take_traction(self, *step: float) -> None:
        """Keep the traction at the end of a step; points at corners have no unique normal, and minus their pressure."""
        self._traction[:] = -self.kept[3] if self.tractions is None else self.tractions()

    def begin_step(self, time: float, dt: float) -> None:
        """Compute the bound at the start of a step of `dt` [s] that ends at `time`; repeated calls agree."""
        self.seen, self.softness = None, 1.0
        self.past.clear()
        if dt > 0.0:
            self.time, self.dt = time, dt
            self.kept[:3] = self._bounds(self.kept[4])

    def follow(self, cover: Floats, slip: Floats, give: Floats, force: Floats) -> float:
        """Update the bounds to the resulting slip. Return the change over the largest bound.

        slip (k,) [mm] of the step under `force` (2, k) [N] over `cover` (k,) [mm]; `give` (k,) [mm/N] is its change by
        a tangential force
        """
        free = np.where(force[0] > 0.0, slip - give * force[1], 0.0)

        def limits(bounds: Floats) -> Floats:
            return FrictionBound(*bounds).limits(force[0], cover)[0]

        now = limits(self.kept[:3])
        rate = self._rates(np.abs(free), give, lambda v: limits(self._bounds(np.copysign(v, free))))
        bounds = self._bounds(np.copysign(rate, free))
        change = np.abs(limits(bounds) - now)[force[0] > 0.0]
        self.kept[:2] = np.maximum(self._ahead(self.kept[:2].ravel(), bounds[:2].ravel()), 0.0).reshape(2, -1)
        self.kept[2] = bounds[2]
        return float(change.max(initial=0.0)) / max(float(now.max(initial=0.0)), 1e-300)

    def measured_give(self, slip: Floats, force: Floats, flexibility: Floats) -> Floats:
        """Return the change of slips by tangential forces (k,) [mm/N]: nodal `flexibility` (k,) times a body factor.

        The factor is the largest ratio of changes of slips (k,) [mm] and forces (k,) [N] in this step: bounds overshoot
        with too small a factor, and only take more rounds with too large a factor.
        """
        if self.seen is not None:
            moved, more = slip - self.seen[0], force - self.seen[1]
            alone = float(flexibility @ more**2)
            if alone > 0.0:
                self.softness = max(self.softness, float(moved @ more) / alone)
        self.seen = slip.copy(), force.copy()
        return self.softness * flexibility

    def _ahead(self, given: Floats, found: Floats) -> Floats:
        """Return Anderson's extrapolation of the last rounds, which changed given bounds to found bounds."""
        self.past = [*self.past[-DEPTH:], (found, found - given)]
        if len(self.past) < 3:
            return found
        places, left = (np.diff(np.array(values), axis=0).T for values in zip(*self.past, strict=True))
        weights = np.linalg.lstsq(left, self.past[-1][1], rcond=1e-10)[0]
        return np.asarray(found - places @ weights)

    def _rates(self, free: Floats, give: Floats, limits: Callable[[Floats], Floats]) -> Floats:
        """Return rates v >= 0 (k,) at which v dt + give * limit(v) is the slip `free` (k,) [mm] without force.

        Zero if the limit at rest holds it. Regula falsi with Illinois' weights, and bisection if it is slow.
        """
        low, high = np.zeros_like(free), free / self.dt
        below, above = give * limits(low) - free, give * limits(high)
        slides = below < 0.0
        rate, weights, side = np.where(slides, high, 0.0), np.stack([below, above]), np.zeros_like(free)
        for number in range(TRIES):
            span = weights[1] - weights[0]
            share = np.divide(-weights[0], span, out=np.full_like(span, 0.5), where=span > 0.0)
            rate = np.where(slides, low + (0.5 if number % 4 == 3 else share) * (high - low), 0.0)
            left = np.where(slides, rate * self.dt + give * limits(rate) - free, 0.0)
            if (np.abs(left) <= EXACT * free).all():
                break
            under = left < 0.0
            low, high = np.where(under, rate, low), np.where(under, high, rate)
            # an end that stays twice counts half, so that it is left behind
            lasting = np.where(side == np.where(under, 1.0, -1.0), 0.5, 1.0)
            weights = np.where(under, [left, lasting * weights[1]], [lasting * weights[0], left])
            side = np.where(under, 1.0, -1.0)
        return rate

    def accept(self, cover: Floats, slip: Floats, force: Floats, idle: bool) -> None:
        """Accept the step that was begun, with slips (k,) [mm] and normal forces (k,) [N] over `cover` (k,) [mm].

        idle  True of a pair that knows no positions, as nothing is near
        """
        pressed = (force > 0.0) & (cover > 0.0)
        self.kept[3] = np.divide(force, cover, out=np.zeros_like(force), where=pressed)
        self.kept[4] = np.where(pressed, slip / self.dt, 0.0)
        if not idle:
            self._take_positions()
        if self.law.memory:
            remember(self.law, "evolve", self.law.evolve(**self._needed(self.kept[4])), self.remembered)

    def _take_positions(self) -> None:
        if "position" in self.law.needs:
            self.kept[len(KEPT) : len(KEPT) + 2] = np.tile(self.at.slave.T, self.per_node)

    def _bounds(self, slip_rate: Floats) -> Floats:
        """Return coefficient, adhesion and cap (3, k) at these rates of slip."""
        found = self.law.bound(**self._needed(slip_rate))
        if not isinstance(found, tuple) or len(found) != 3:
            raise WrongAnswer(f"{type(self.law).__name__}: bound gave {type(found).__name__}, needed: FrictionBound")
        out = np.empty((3, self.kept.shape[1]))
        for row, (name, values) in enumerate(zip(KEPT, found, strict=False)):
            out[row] = checked(self.law, f"bound gave {name}", values, out.shape[1], least=0.0)
        return out

    def _needed(self, slip_rate: Floats) -> dict[str, Any]:
        given: dict[str, Any] = {
            "pressure": self.kept[3].copy(), "slip_rate": slip_rate.copy(), "dt": self.dt, "time": self.time,
            "position": self.kept[len(KEPT) : len(KEPT) + 2].T.copy(), "cell_size": self.size.copy(),
        }  # fmt: skip
        if "traction" in self.law.needs:
            given["traction"] = self._traction.copy()
        given |= {name: value(self.time) for name, value in self.fields.items()}
        needed = {name: given[name] for name in self.law.needs}
        return needed | {name: values.copy() for name, values in self.remembered.items()}


def rows_of(law: FrictionLaw) -> int:
    """Return the number of state rows of a law that varies."""
    return len(KEPT) + 2 * ("position" in law.needs) + ("traction" in law.needs) + len(law.memory)


def sliding_of(law: FrictionLaw | None, multipliers: int, slave: Surface, at: SurfacePositions) -> Sliding | None:
    """Return the friction data of a law for a pair with these sides; None without a law."""
    if law is None:
        return None
    return (VaryingSliding if law.varies else Sliding)(law, multipliers, slave, at)
