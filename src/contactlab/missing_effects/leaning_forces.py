"""Contact forces that pressure and shear do not add up to: they lean, as gaps change from place to place.

Consistent forces act along the derivatives of the gaps. A mean gap over a segment that sees both sides of a vertex of
the master changes as the segment slides past; its multiplier then pushes against the slide. Sharp corners hold their
own conditions (`contactlab.contact.corners`).
"""

from __future__ import annotations

import numpy as np

from contactlab.api import RunWarning, Surface
from contactlab.missing_effects.missing_effect import Detectors, needed, per_cent
from contactlab.model.model import Model
from contactlab.scene.scene import Scene

APART = 0.1  # of the largest contact force on a body: curved and rough contacts that are right stay below a fifth of it


def leaning_detectors(scene: Scene, model: Model) -> Detectors:
    """Detector for runs whose contact forces act along derivatives of gaps, except in half passes."""
    contact = model.contact
    if contact is not None and getattr(contact, "consistent", False) and not any(p.half for p in contact.pairs):
        yield LeaningForces(model)


class LeaningForces:
    """`worst`: largest difference [N] of forces on a body, number of its contact, x, y there, and largest force [N]."""

    def __init__(self, model: Model) -> None:
        self.model, self.pairs, self.worst = model, model.contact.pairs, np.zeros(5)  # type: ignore[union-attr]
        self.bodies = [slice(body.first, body.first + body.count) for body in model.bodies]
        shares = np.array([[self._shares(side) for side in (pair.slave, pair.master)] for pair in self.pairs])
        self.rigid = [not of_master.any() for of_master in shares[:, 1]]  # never slaves
        self.signs = shares[:, 0] - shares[:, 1]  # (contacts, bodies): of the slave, and of the master the opposite
        self.known = ((shares == 0.0) | (shares == 1.0)).all(axis=(0, 1))  # bodies that no chain shares with others

    def update(self) -> None:
        """Compare what acts on each body with normal and tangential forces along the normals of its contacts."""
        state, position = self.model.state, self.model.position
        if not state["multipliers"][0].any():
            return
        told, largest, total = np.zeros((len(self.bodies), 2)), np.zeros(len(self.pairs)), np.zeros(len(self.pairs))
        for number, pair in enumerate(self.pairs):
            seen = pair.snapshot(state, position)
            told += np.outer(self.signs[number], seen.resultant)
            largest[number], total[number] = seen.forces[0].max(initial=0.0), seen.forces[0].sum()
        acting = np.array([state["contact_force"][own].sum(axis=0) for own in self.bodies])
        apart = np.where(self.known, np.hypot(*(acting - told).T), 0.0)
        # a body that is squeezed between two walls, or a ring all around, has forces that add up to nothing
        self.worst[4] = max(self.worst[4], *total, *np.hypot(*acting.T))
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
        name, corner = self.pairs[int(number)].name, f"the corner near ({x:.4g}, {y:.4g})"
        key, mend = f"{name}.swap", f"make the side with {corner} the slave ({name}.swap), round it"
        if self.rigid[int(number)]:
            key, mend = f"{name}.algorithm", f"round {corner}"
        return needed(
            "leaning-forces", share, APART, key,
            f"{name}: contact forces differ by {per_cent(share)} of the largest from the integrals of pressure and "
            "shear: mean gaps change as segments slide past a corner, which resists sliding",
            f"{mend}, or take node-on-segment",
        )  # fmt: skip
