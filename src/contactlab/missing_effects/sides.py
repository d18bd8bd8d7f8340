"""Contacts whose slave is the wrong side: much stiffer or coarser than the master, or with normals that lean."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import Floats, Ints, Potential, RunWarning, Surface
from contactlab.api.arrays import Flags
from contactlab.api.frame import SLIP
from contactlab.missing_effects.missing_effect import Detectors, needed
from contactlab.model.bodies.body import Body
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.scene.keys import Contact
    from contactlab.scene.scene import Scene

STIFFER = 12.0  # ratio of shear moduli: steel on a polymer, not steel on aluminium
COARSER = 2.0  # ratio of segment lengths where the surfaces press
FIT = 0.05  # of a segment: like meshes with nodes on nodes pass any pressure
ROUGHER = 2.0  # ratio of the turns from segment to segment there, from which the other side knows the normal
LEAN = 0.01  # of the normal forces: what forces that lean add along the surface, all to one side
FRICTION = 0.05  # the same over the friction forces, of nodes that slip: what friction work is held to
TO_AND_FRO = 0.14  # sine of the lean, root of the mean square: the normal part of forces is off by 1 %


def side_detectors(scene: Scene, model: Model) -> Detectors:
    """A detector for every contact whose master is a body: a rigid surface is never too soft, too coarse or a slave.

    Potentials and two half passes press both sides alike, with normals of their own: exchange mends nothing.
    """
    ends = np.array([body.first + body.count for body in model.bodies])
    for pair, spec in zip(model.contact.pairs if model.contact is not None else (), scene.contacts, strict=True):
        if isinstance(pair.method, Potential) or pair.half:
            continue
        slave = _bodies_of(pair.slave.nodes, model.bodies, ends)
        master = _bodies_of(pair.master.nodes, model.bodies, ends)
        if master:
            ratio = max(body.shear_modulus for body in slave) / min(body.shear_modulus for body in master)
            yield WrongSide(pair, spec, model, ratio)


def _bodies_of(nodes: Ints, bodies: tuple[Body, ...], ends: Ints) -> list[Body]:
    found = np.unique(np.searchsorted(ends, nodes, side="right"))
    return [bodies[number] for number in found if number < len(bodies)]  # behind them are nodes of rigid surfaces


class WrongSide:
    """Whether the other side should be the slave.

    worst  largest median ratio of slave to master segments where they press, and of the distances from slave nodes to
           master nodes over slave segments; sums over nodes and frames: of normal forces F, of friction forces |T|, of
           F times the squared sine of the lean against the smoother side's normals, as forces act and as the rougher
           side's normals would have them act, and of F times the sine where nodes slip, to one side and along T. If
           both sides turn alike, the slave's own normals stand for both

    Forces that lean to and fro along a surface add nothing, and nodes that stick take the force that holds them,
    whichever its parts are.
    """

    def __init__(self, pair: Any, spec: Contact, model: Model, stiffness: float) -> None:
        self.pair, self.spec, self.model, self.stiffness = pair, spec, model, stiffness
        self.worst = np.zeros(8)

    def update(self) -> None:
        """Take in segment lengths and normals at the slave nodes that are pressed now."""
        from contactlab.contact.near_list import segment_lengths  # of contacts alone

        pair, position = self.pair, self.model.position
        forces = np.zeros((2, pair.own.stop - pair.own.start))  # normal ones, and with friction tangential ones
        known = self.model.state["multipliers"][:, pair.own]
        forces[: len(known)] = known
        slots = np.flatnonzero(forces[0] > 0.0)
        if not len(slots):
            return
        nodes = np.asarray(slots % len(pair.slave.nodes), np.int32)
        slave, master = position[pair.slave.nodes], position[pair.master.nodes]
        at = slave[np.unique(nodes)]
        own, other = segment_lengths(slave, pair.slave), segment_lengths(master, pair.master)
        long = own[_nearest(at, slave, pair.slave)]
        ratio = long / other[_nearest(at, master, pair.master)]
        apart = np.sqrt(((at[:, None] - master[None]) ** 2).sum(axis=2).min(axis=1))
        np.maximum(self.worst[:2], (np.median(ratio), np.median(apart / long)), out=self.worst[:2])
        found = _nearest(slave[nodes], master, pair.master)
        self._add_leans(forces[:, slots], pair.normals[slots], nodes, found, slave, master)

    def _add_leans(
        self, forces: Floats, normals: Floats, nodes: Ints, found: Ints, slave: Floats, master: Floats
    ) -> None:
        pair, (force, friction) = self.pair, forces
        turns = _turns(slave, pair.slave)[nodes], _turns(master, pair.master)[pair.master.segments[found]].max(axis=1)
        rough = [float(force @ turn) for turn in turns]
        own = -_nodal_normals(slave, pair.slave)[nodes]
        right, squares = own, [0.0, 0.0]
        # curves of smooth surfaces turn alike on both sides, however coarse their segments are
        if max(rough) > ROUGHER * min(rough) and pair.smooth is None:
            other = _segment_normals(master, pair.master)[found]
            right, wrong = (other, own) if rough[0] > rough[1] else (own, other)
            squares = [float(force @ _cross(one, right) ** 2) for one in (normals, wrong)]
        aside = np.where(self._slips(nodes), force * _cross(normals, right), 0.0)
        self.worst[2:] += force.sum(), np.abs(friction).sum(), *squares, aside.sum(), np.sign(friction) @ aside

    def _slips(self, nodes: Ints) -> Flags:
        """Whether pressed nodes slip; all do without friction."""
        from contactlab.results.contact_nodes import friction_bound, states_of

        seen = self.pair.snapshot(self.model.state, self.model.position)
        return np.asarray(states_of(self.pair, seen, friction_bound(self.pair, seen))[nodes] == SLIP)

    def warning(self) -> RunWarning | None:
        """Advise the other side as slave if forces lean, or if that side is softer or finer and no force would lean.

        Stiffness and coarseness count for methods that fail the patch test: on finished cells of the quick matrix these
        alarms are right for 6 of 6 such runs, and for none of 13 mortars, whose errors do not depend on the side.
        """
        coarseness, misfit, force, friction, *squares, aside, along = (float(number) for number in self.worst)
        tiny = np.finfo(float).tiny
        lean, other_lean = np.sqrt(np.array(squares) / max(force, tiny))
        side, drag = abs(aside) / max(force, tiny), abs(along) / max(friction, tiny)
        better = "the other side's normals are better known there"
        if side > LEAN:
            seen = f"normals of facets lean by {np.degrees(side):.2g} degrees to one side, and forces with them"
            return self._swap(side, LEAN, seen, better)
        if drag > FRICTION:
            seen = f"normals of facets lean along the slip, which changes friction by {drag:.1%}"
            return self._swap(drag, FRICTION, seen, better)
        if lean > TO_AND_FRO:
            seen = f"normals of facets lean to and fro by {np.degrees(lean):.2g} degrees, and forces with them"
            return self._swap(float(lean), TO_AND_FRO, seen, better)
        fits = misfit < FIT and coarseness < 1.0 + FIT
        if not force or fits or other_lean > LEAN or self.pair.method.passes_patch_test:
            return None
        better = "the softer and finer side carries the multipliers better"
        if self.stiffness > STIFFER:
            seen = f"the slave's material is {self.stiffness:.3g} times as stiff as the master's"
            return self._swap(self.stiffness, STIFFER, seen, better)
        if coarseness > COARSER:
            seen = f"where the surfaces press, the slave's segments are {coarseness:.3g} times as long as the master's"
            return self._swap(coarseness, COARSER, seen, better)
        return None

    def _swap(self, value: float, limit: float, seen: str, why: str) -> RunWarning:
        name, spec = self.pair.name, self.spec
        told = f"{spec.name or name}: {seen}; {why}"
        add = f"write {name}.swap = {'false' if spec.swap else 'true'}"
        return needed("other-slave", value, limit, f"{name}.swap", told, add)


def _nearest(points: Floats, position: Floats, surface: Surface) -> Ints:
    """The segment of a surface whose middle is nearest to each point."""
    middle = position[surface.segments].mean(axis=1)
    square = ((points[:, None] - middle[None]) ** 2).sum(axis=2)
    return np.asarray(square.argmin(axis=1))


def _segment_normals(position: Floats, surface: Surface) -> Floats:
    edge = np.diff(position[surface.segments], axis=1)[:, 0]
    return np.asarray(np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.hypot(*edge.T)[:, None])


def _nodal_normals(position: Floats, surface: Surface) -> Floats:
    """Averages (m, 2) of the outward normals of the segments that meet at each node, by their lengths."""
    before, after = surface.node_segments.T
    first = np.where(before >= 0, surface.segments[before, 0], np.arange(len(position)))
    last = np.where(after >= 0, surface.segments[after, 1], np.arange(len(position)))
    along = position[last] - position[first]
    return np.asarray(np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None])


def _turns(position: Floats, surface: Surface) -> Floats:
    """Sine (m,) of the angle by which a surface turns at each node; 1 at ends."""
    normal, (before, after) = _segment_normals(position, surface), surface.node_segments.T
    turn = np.abs(_cross(normal[before], normal[after]))
    return np.where((before < 0) | (after < 0), 1.0, turn)


def _cross(first: Floats, second: Floats) -> Floats:
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
