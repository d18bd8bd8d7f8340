"""Friction data of a contact pair: the bound of its law, constant or by multiplier, and the start of the step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import ContactView, Floats, FrictionBound, FrictionLaw, Ints, State, Surface
from contactlab.api.arrays import Flags
from contactlab.api.surface import SurfacePositions
from contactlab.errors import WrongAnswer
from contactlab.meshing.turns import turns
from contactlab.parts.remembered import checked, remember

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair
    from contactlab.contact.traction_system import Tractions

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
HELD = 0.1  # flexibility along the surface over nodal flexibility: chains end with the normal of half a facet's turn
SAME = 1e-3  # segment lengths along the surface: both meshes begin at the same cut, up to round-off and strain
STILL = 1e-9  # segment lengths: supports that move both sides together


class Sliding:
    """The bound of a law of k multipliers, and the start of the step.

    bound       (3,) coefficient [-], adhesion [MPa], cap [-] of a constant law
    everywhere  the bound also holds at open nodes: every multiplier within the search distance needs a row
    before      (k, 2) normals at the start of the step
    began       positions of both surfaces at the start of the step [mm]
    """

    def __init__(self, law: FrictionLaw, multipliers: int, at: SurfacePositions) -> None:
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

    tractions  by the stresses of this moment, for a law that needs them; None of points at corners
    """

    def __init__(self, law: FrictionLaw, multipliers: int, at: SurfacePositions) -> None:
        super().__init__(law, multipliers, at)
        self.kept = np.zeros((rows_of(law), multipliers))
        self.remembered: dict[str, Floats] = {}
        self.size: Floats = np.zeros(multipliers)
        self.time = self.dt = 0.0
        self.seen: tuple[Floats, Floats] | None = None
        self.past: list[tuple[Floats, Floats]] = []  # bounds found by rounds, and their change from the given bounds
        self.softness = 1.0
        self.fields: Mapping[str, Callable[[float], Any]] = {}
        self.tractions: Tractions | None = None

    def of(self, slots: Ints | slice) -> Floats:
        """Return the bound (3, n) of some multipliers in the present step."""
        return np.asarray(self.kept[:3, slots])

    def bind(self, state: State, pair: ContactPair) -> None:
        """Keep its memory in the state from here on."""
        self.kept = state[f"friction.{pair.name}"]
        self.remembered = dict(zip(self.law.memory, self.kept[len(self.kept) - len(self.law.memory) :], strict=True))
        remember(self.law, "start", self.law.start(), self.remembered)
        pair.memory.update(self.remembered)
        if "traction" in self.law.needs:
            pair.memory["traction"] = self._traction
        segments, size = pair.slave.segments, np.zeros(len(pair.slave.nodes))
        length = np.linalg.norm(np.diff(pair.at.slave[segments], axis=1)[:, 0], axis=1)
        np.add.at(size, segments, 0.5 * length[:, None])
        self.size = np.tile(size, pair.method.rows_per_node)
        self._take_positions(pair)

    @property
    def _traction(self) -> Floats:
        return np.asarray(self.kept[len(KEPT) + 2 * ("position" in self.law.needs)])

    def take_traction(self, pair: ContactPair, *step: float) -> None:
        """Keep the traction at the end of a step; points at corners have no unique normal, and minus their pressure."""
        self._traction[:] = -self.kept[3] if self.tractions is None else self.tractions.values()[pair.own]

    def begin_step(self, pair: ContactPair, time: float, dt: float) -> None:
        """Compute the bound at the start of a step of `dt` [s] that ends at `time`; repeated calls agree."""
        self.seen, self.softness = None, 1.0
        self.past.clear()
        if dt > 0.0:
            self.time, self.dt = time, dt
            self.kept[:3] = self._bounds(self.kept[4])

    def follow(self, pair: ContactPair, slip: Floats, give: Floats, force: Floats) -> float:
        """Update the bounds to the resulting slip. Return the change over the largest bound.

        slip (k,) [mm] of the step under `force` (2, k) [N]; `give` (k,) [mm/N] is its change by a tangential force
        """
        free = np.where(force[0] > 0.0, slip - give * force[1], 0.0)

        def limits(bounds: Floats) -> Floats:
            return FrictionBound(*bounds).limits(force[0], pair.cover)[0]

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

    def accept(self, pair: ContactPair, slip: Floats, force: Floats) -> None:
        """Accept the step that was begun, with slips (k,) [mm] and normal forces (k,) [N]."""
        cover = pair.cover
        pressed = (force > 0.0) & (cover > 0.0)
        self.kept[3] = np.divide(force, cover, out=np.zeros_like(force), where=pressed)
        self.kept[4] = np.where(pressed, slip / self.dt, 0.0)
        if not pair.idle:  # it knows no positions if nothing is near
            self._take_positions(pair)
        if self.law.memory:
            remember(self.law, "evolve", self.law.evolve(**self._needed(self.kept[4])), self.remembered)

    def _take_positions(self, pair: ContactPair) -> None:
        if "position" in self.law.needs:
            self.kept[len(KEPT) : len(KEPT) + 2] = np.tile(pair.at.slave.T, pair.method.rows_per_node)

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


def sliding_of(law: FrictionLaw | None, multipliers: int, at: SurfacePositions) -> Sliding | None:
    """Return the friction data of a law for a pair; None without a law."""
    if law is None:
        return None
    return (VaryingSliding if law.varies else Sliding)(law, multipliers, at)


def varying(pairs: Sequence[ContactPair], state: State) -> list[tuple[ContactPair, VaryingSliding]]:
    """Return the pairs whose laws vary, bound to the state."""
    found = [(pair, pair.sliding) for pair in pairs if isinstance(pair.sliding, VaryingSliding)]
    for pair, sliding in found:
        sliding.bind(state, pair)
    return found


def taking_tractions(
    varying: Sequence[tuple[ContactPair, VaryingSliding]],
) -> tuple[Callable[[float, float], None], ...]:
    """Return functions, called with the end and the length [s] of each accepted step, that keep tractions of laws."""
    return tuple(partial(sliding.take_traction, pair) for pair, sliding in varying if "traction" in sliding.law.needs)


def held_together(pair: ContactPair, flexibility: Floats, start: Floats) -> Flags:
    """Return multipliers (k,) of slave nodes held by supports together with the master beneath, as in symmetry.

    They cannot slide on each other whatever friction does: a stick constraint would be redundant, and its force
    undetermined. Friction passes nothing there; the supports hold the nodes. Curves end with the tangent of a facet,
    which leans from the plane of symmetry's normal: motion along it counts only as far as supports resist it, since
    approaching curves do not slide there.

    flexibility  (N, 2) [mm/N] of single nodes, 0 if they are held
    start        (N, 2) [mm] positions at the start of the step: nodes that supports move relative to each other slide
    """
    out = np.zeros(pair.slots, np.bool_)
    slave, master = pair.slave.nodes, pair.master.nodes
    partly = np.flatnonzero((flexibility[slave] == 0.0).any(axis=1))
    others = np.flatnonzero((flexibility[master] == 0.0).any(axis=1))
    if not len(partly) or not len(others):
        return out
    slots = (partly + len(slave) * np.arange(pair.rows_per_node)[:, None]).ravel()
    node = np.tile(partly, pair.rows_per_node).astype(np.int32)
    normal, length = pair.normals[slots], pair.full[slots]
    tangent = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    across = pair.at.slave[node][:, None] - pair.at.master[others]
    nearest = np.asarray(others[(across**2).sum(axis=2).argmin(axis=1)], np.int32)
    apart = pair.at.slave[node] - pair.at.master[nearest]
    before = start[slave[node]] - start[master[nearest]]
    axes = (flexibility[slave[node]] == 0.0) & (flexibility[master[nearest]] == 0.0)
    turn = np.maximum(_turns_at(pair.slave, start, node), _turns_at(pair.master, start, nearest))
    leans = np.where(axes, 0.0, np.abs(tangent)).max(axis=1) <= np.sin(turn)
    along = np.where(axes | ~leans[:, None], tangent, 0.0)
    together = np.abs((apart * along).sum(axis=1)) < SAME * length
    still = np.abs(((apart - before) * along).sum(axis=1)) < STILL * length
    held = [
        (own * tangent**2).sum(axis=1) <= HELD * own.max(axis=1)
        for own in (flexibility[slave[node]], flexibility[master[nearest]])
    ]
    out[slots] = together & still & held[0] & held[1]
    return out


def _turns_at(side: Surface, positions: Floats, nodes: Ints) -> Floats:
    """Angle (n,) [rad] by which a side turns next to its ends; 0 of nodes (n,) within it."""
    inward = side.node_segments[nodes]
    beside = side.segments[inward.max(axis=1), np.argmax(inward >= 0, axis=1)]
    return np.where((inward < 0).any(axis=1), np.abs(turns(side, positions)[beside]), 0.0)
