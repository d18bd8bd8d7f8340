"""Contact forces that pressure and shear do not add up to: they lean, as gaps change from place to place.

Consistent forces act along the derivatives of the gaps. A mean gap over a segment that sees both sides of a sharp
corner of the master changes as the segment slides past the corner; its multiplier then pushes against the slide.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import Floats, RunWarning
from contactlab.missing_effects.missing_effect import Detectors, needed, per_cent
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.scene.scene import Scene

APART = 0.1  # of the largest contact force on a body: curved and rough contacts that are right stay below a fifth of it


def leaning_detectors(scene: Scene, model: Model) -> Detectors:
    """A detector for runs whose contact forces act along derivatives of gaps, but for those of half passes."""
    contact = model.contact
    if contact is not None and getattr(contact, "consistent", False) and not any(p.half for p in contact.pairs):
        yield LeaningForces(model)


class LeaningForces:
    """`worst`: largest difference [N] of forces on a body, number of its contact, x, y there, and largest force [N]."""

    def __init__(self, model: Model) -> None:
        self.model, self.pairs, self.worst = model, model.contact.pairs, np.zeros(5)  # type: ignore[union-attr]
        self.bodies = [slice(body.first, body.first + body.count) for body in model.bodies]

    def update(self) -> None:
        """Compare what acts on each body with normal and tangential forces along the normals of its contacts."""
        state, position = self.model.state, self.model.position
        if not state["multipliers"][0].any():
            return
        told, largest = np.zeros((len(self.bodies), 2)), np.zeros(len(self.pairs))
        for number, pair in enumerate(self.pairs):
            seen = pair.snapshot(state, position)
            normal, tangential = seen.forces
            across = np.stack([seen.normals[:, 1], -seen.normals[:, 0]], axis=1)
            resultant, largest[number] = normal @ seen.normals + tangential @ across, normal.max(initial=0.0)
            told += self._shares(pair, resultant)
        acting = np.array([state["contact_force"][own].sum(axis=0) for own in self.bodies])
        apart = np.hypot(*(acting - told).T)
        self.worst[4] = max(self.worst[4], *np.hypot(*told.T), *np.hypot(*acting.T))
        if apart.max() > self.worst[0]:
            number = int(largest.argmax())
            pair = self.pairs[number]
            node = int(state["multipliers"][0, pair.own].argmax()) % len(pair.slave.nodes)
            self.worst[:4] = apart.max(), number, *position[pair.slave.nodes[node]]

    def _shares(self, pair: Any, resultant: Floats) -> Floats:
        """Forces (bodies, 2) of a contact on each body: of its slave, and of its master the opposite."""
        inside = [[own.start <= side.nodes[0] < own.stop for own in self.bodies] for side in (pair.slave, pair.master)]
        return np.asarray(np.subtract(*np.array(inside, float))[:, None] * resultant)

    def warning(self) -> RunWarning | None:
        """Advise the side with the corner as slave, or points; None while forces and tractions agree."""
        apart, number, x, y, largest = self.worst
        share = float(apart / max(largest, np.finfo(float).tiny))
        if share <= APART:
            return None
        name = self.pairs[int(number)].name
        return needed(
            "leaning-forces", share, APART, f"{name}.swap",
            f"{name}: contact forces differ by {per_cent(share)} of the largest from what pressure and shear add up "
            "to: mean gaps change as segments slide past a corner, which holds them up",
            f"make the side with the corner near ({x:.4g}, {y:.4g}) the slave ({name}.swap), round it, or take "
            "node-on-segment",
        )  # fmt: skip
