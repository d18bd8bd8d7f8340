"""Contacts whose slave is the wrong side: much stiffer or coarser than the master, or with normals that lean."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Floats, Ints, Potential, RunWarning, Surface
from contactlab.meshing.curves import nearest_segments
from contactlab.missing_effects.missing_effect import Detectors, needed
from contactlab.model.bodies.body import Body
from contactlab.model.model import Model
from contactlab.scene.keys import Contact
from contactlab.scene.scene import Scene

STIFFER = 12.0  # ratio of shear moduli: steel on a polymer, not steel on aluminium
COARSER = 2.0  # ratio of segment lengths where the surfaces press
ROUGHER = 2.0  # ratio of the turns from segment to segment there, from which the other side knows the normal
LEAN = 0.01  # sine of the angle from that normal along friction, or to one side: at mu = 0.2 friction is off by 5 %
TO_AND_FRO = 0.14  # the same of forces that lean to and fro and hold nothing back: their normal part is off by 1 %


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
    """Detector of contacts whose other side should be the slave.

    worst  largest median ratio of slave to master segments where they press; the sum of the forces of all frames, and
           of forces times the squared sine of their lean against the smoother side, as they act and as they would
           act along the rougher side's normals; and the sums of forces times the sine of their lean: against the slave
           if both sides are as smooth (nodes that slid off convex vertices of the master, all to one side), and
           against the smoother side in the direction of friction
    """

    def __init__(self, pair: Any, spec: Contact, model: Model, stiffness: float) -> None:
        self.pair, self.spec, self.model, self.stiffness = pair, spec, model, stiffness
        self.worst = np.zeros(7)

    def update(self) -> None:
        """Take in segment lengths and normals at the slave nodes that are pressed now."""
        pair, position = self.pair, self.model.position
        multipliers = self.model.state["multipliers"][:, pair.own]
        # signs of the tangential forces, 0 without friction, which has no row then
        forces, shear = multipliers[0], np.sign(multipliers[1:].sum(axis=0))
        slots = np.flatnonzero(forces > 0.0)
        if not len(slots):
            return
        nodes = np.asarray(slots % len(pair.slave.nodes), np.int32)
        slave, master = position[pair.slave.nodes], position[pair.master.nodes]
        single, again = np.unique(nodes, return_inverse=True)
        at = slave[single]
        own, other = pair.slave.lengths(slave), pair.master.lengths(master)
        faced, share = nearest_segments(at, pair.master, position)
        ratio = own[nearest_segments(at, pair.slave, position)[0]] / other[faced]
        self.worst[0] = max(self.worst[0], float(np.median(ratio)))
        self._add_leans(forces[slots], shear[slots], pair.normals[slots], nodes, (faced[again], share[again]))

    def _add_leans(
        self, forces: Floats, shear: Floats, normals: Floats, nodes: Ints, feet: tuple[Ints, Floats]
    ) -> None:
        pair, position, (found, share) = self.pair, self.model.position, feet
        slave, master = position[pair.slave.nodes], position[pair.master.nodes]
        turns = _turns(slave, pair.slave)[nodes], _turns(master, pair.master)[pair.master.segments[found]].max(axis=1)
        rough = [float(forces @ turn) for turn in turns]
        own = -_nodal_normals(slave, pair.slave)[nodes]
        # curves of smooth surfaces turn alike on both sides, however coarse their segments are
        if max(rough) <= ROUGHER * min(rough) or pair.smooth:
            self.worst[5] += forces @ _cross(normals, own)
            self.worst[1] += forces.sum()
            return
        smooth_master, by_master = rough[0] > rough[1], getattr(pair.method, "points", None) == 0
        if smooth_master:
            right, wrong = _between(_nodal_normals(master, pair.master), pair.master.segments[found], share), own
        else:
            right, wrong = own, _segment_normals(master, pair.master)[found]
        lean, other_lean = (float(forces @ _cross(normal, right) ** 2) for normal in (normals, wrong))
        self.worst[1:5] += forces.sum(), lean, other_lean, other_lean if smooth_master == by_master else 0.0
        self.worst[6] += (forces * shear) @ _cross(normals, right)

    def warning(self) -> RunWarning | None:
        """Advise the other side as slave if forces lean, or if that side is softer or finer and no force would lean.

        Stiffness and coarseness count for methods that fail the patch test: on finished cells of the quick matrix these
        alarms are right for 6 of 6 such runs, and for none of 13 mortars, whose errors do not depend on the side.
        """
        coarseness, force = float(self.worst[0]), max(float(self.worst[1]), np.finfo(float).tiny)
        lean, other_lean, exchanged = (float(mean) for mean in np.sqrt(self.worst[2:5] / force))
        aside, dragged = (float(mean) for mean in np.abs(self.worst[5:]) / force)
        value, limit = (dragged, LEAN) if dragged > LEAN else (lean, TO_AND_FRO)
        # beyond `exchanged`: the exchanged contact does not get the advice to exchange back
        if value > limit and lean > exchanged:
            seen = f"normals of facets lean by {np.degrees(value):.2g} degrees against the smoother side"
            return self._swap(value, limit, f"{seen}, and forces with them", "its normals are more accurate")
        if aside > LEAN:
            seen = f"normals of facets lean by {np.degrees(aside):.2g} degrees to one side, and forces with them"
            why = "slave nodes lie next to vertices of the master, where it turns"
            return self._swap(aside, LEAN, seen, why, "; if forces lean there as well, round the vertices")
        if other_lean > LEAN or self.pair.method.passes_patch_test:
            return None
        better = "the softer and finer side carries the multipliers better"
        if self.stiffness > STIFFER:
            seen = f"the slave's material is {self.stiffness:.3g} times as stiff as the master's"
            return self._swap(self.stiffness, STIFFER, seen, better)
        if coarseness > COARSER:
            seen = f"where the surfaces press, the slave's segments are {coarseness:.3g} times as long as the master's"
            return self._swap(coarseness, COARSER, seen, better)
        return None

    def _swap(self, value: float, limit: float, seen: str, why: str, more: str = "") -> RunWarning:
        name, spec = self.pair.name, self.spec
        told = f"{spec.name or name}: {seen}; {why}"
        add = f"write {name}.swap = {'false' if spec.swap else 'true'}{more}"
        return needed("other-slave", value, limit, f"{name}.swap", told, add)


def _between(normals: Floats, ends: Ints, share: Floats) -> Floats:
    """Normals (n, 2) of a smooth surface between those at the `ends` (n, 2) of segments."""
    share = np.clip(share, 0.0, 1.0)[:, None]
    found = (1.0 - share) * normals[ends[:, 0]] + share * normals[ends[:, 1]]
    return np.asarray(found / np.hypot(*found.T)[:, None])


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
