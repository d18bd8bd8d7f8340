"""Contact forces that pressure and shear do not add up to: they lean, as gaps change from place to place.

Consistent forces act along the derivatives of the gaps. A mean gap over a segment that sees both sides of a sharp
corner of the master changes as the segment slides past the corner; its multiplier then pushes against the slide.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import RunWarning, Surface
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
        shares = np.array([[self._shares(side) for side in (pair.slave, pair.master)] for pair in self.pairs])
        self.signs = shares[:, 0] - shares[:, 1]  # (contacts, bodies): of the slave, and of the master the opposite
        self.known = ((shares == 0.0) | (shares == 1.0)).all(axis=(0, 1))  # bodies that no chain shares with others

    def update(self) -> None:
        """Compare what acts on each body with normal and tangential forces along the normals of its contacts."""
        state, position = self.model.state, self.model.position
        if not state["multipliers"][0].any():
            return
        told, largest = np.zeros((len(self.bodies), 2)), np.zeros(len(self.pairs))
        for number, pair in enumerate(self.pairs):
            seen = pair.snapshot(state, position)
            told += np.outer(self.signs[number], seen.resultant)
            largest[number] = seen.forces[0].max(initial=0.0)
        acting = np.array([state["contact_force"][own].sum(axis=0) for own in self.bodies])
        apart = np.where(self.known, np.hypot(*(acting - told).T), 0.0)
        self.worst[4] = max(self.worst[4], *np.hypot(*told.T), *np.hypot(*acting.T))
        if apart.max() > self.worst[0]:
            number = int(largest.argmax())
            pair = self.pairs[number]
            node = int(state["multipliers"][0, pair.own].argmax()) % len(pair.slave.nodes)
            self.worst[:4] = apart.max(), number, *position[pair.slave.nodes[node]]

    def _shares(self, side: Surface) -> list[float]:
        """Share of the nodes of a surface that each body has."""
        return [float(np.mean((own.start <= side.nodes) & (side.nodes < own.stop))) for own in self.bodies]

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
