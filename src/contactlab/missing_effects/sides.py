"""Contacts whose slave is the wrong side: much stiffer or much coarser than the master."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import Floats, Ints, RunWarning, Surface
from contactlab.missing_effects.missing_effect import Detectors, Known, needed
from contactlab.model.bodies.body import Body
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.scene.keys import Contact
    from contactlab.scene.scene import Scene

STIFFER = 12.0  # ratio of shear moduli: steel on a polymer, not steel on aluminium
COARSER = 2.0  # ratio of segment lengths where the surfaces press


def side_detectors(scene: Scene, model: Model) -> Detectors:
    """Detectors for every contact: of moduli, found now, and of segments where and when they press."""
    for pair, spec in zip(model.contact.pairs if model.contact is not None else (), scene.contacts, strict=True):
        slave = _bodies_of(pair.slave.nodes, model.bodies)
        master = _bodies_of(pair.master.nodes, model.bodies)
        if not master:  # a rigid surface is never too soft or too coarse
            continue
        ratio = max(body.shear_modulus for body in slave) / min(body.shear_modulus for body in master)
        if ratio > STIFFER:
            seen = f"the slave's material is {ratio:.3g} times as stiff as the master's"
            yield Known(_swap(pair.name, spec, ratio, STIFFER, seen))
        yield CoarseSlave(pair, spec, model)


def _bodies_of(nodes: Ints, bodies: tuple[Body, ...]) -> list[Body]:
    return [b for b in bodies if np.any((nodes >= b.first) & (nodes < b.first + b.count))]


class CoarseSlave:
    """`worst`: largest median ratio of slave to master segments where they press."""

    def __init__(self, pair: Any, spec: Contact, model: Model) -> None:
        self.pair, self.spec, self.model, self.worst = pair, spec, model, np.zeros(1)

    def update(self) -> None:
        """Lengths of the segments at pressed slave nodes and of the master's nearest to each."""
        pair, position = self.pair, self.model.position
        forces = self.model.state["multipliers"][0, pair.first_slot : pair.first_slot + pair.slots]
        pressed = np.flatnonzero(forces.reshape(pair.rows_per_node, -1).max(axis=0) > 0.0)
        if not len(pressed):
            return
        at = position[pair.slave.nodes[pressed]]
        own = _nearest_lengths(at, position, pair.slave)
        other = _nearest_lengths(at, position, pair.master)
        self.worst[0] = max(self.worst[0], float(np.median(own / other)))

    def warning(self) -> RunWarning | None:
        """Advise the other side as slave where that side is finer or softer; None where not."""
        ratio = float(self.worst[0])
        if ratio <= COARSER:
            return None
        return _swap(
            self.pair.name,
            self.spec,
            ratio,
            COARSER,
            f"where the surfaces press, the slave's segments are {ratio:.3g} times as long as the master's",
        )


def _nearest_lengths(points: Floats, position: Floats, surface: Surface) -> Floats:
    """Length of the segment of a surface whose middle is nearest to each point."""
    begin, end = (position[surface.nodes[surface.segments[:, k]]] for k in range(2))
    middle, length = 0.5 * (begin + end), np.hypot(*(end - begin).T)
    square = ((points[:, None] - middle[None]) ** 2).sum(axis=2)
    return np.asarray(length[square.argmin(axis=1)])


def _swap(name: str, spec: Any, value: float, limit: float, seen: str) -> RunWarning:
    return needed(
        "other-slave",
        value,
        limit,
        f"{name}.swap",
        f"{spec.name or name}: {seen}; the softer and finer side carries the multipliers better",
        f"write {name}.swap = {'false' if spec.swap else 'true'}",
    )
