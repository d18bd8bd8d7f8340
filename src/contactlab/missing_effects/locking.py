"""Elements that lock if the material is nearly incompressible."""

from __future__ import annotations

import numpy as np

from contactlab.api import RunWarning
from contactlab.missing_effects.missing_effect import Detectors, needed, per_cent
from contactlab.model.bodies.body import BodyForces
from contactlab.model.model import Model

EVEN = 1e-3  # of the plastic strain: cells whose points flow alike are strained evenly, which any element follows
FLOW = 0.01  # equivalent plastic strain, well beyond elastic strains: volume-preserving flow rules the deformation
PLASTIC = "equivalent_plastic_strain"


def locking_detectors(scene: object, model: Model) -> Detectors:
    """Detectors for bodies of elements that lock whose law yields: such flow keeps the volume."""
    del scene
    for forces in model.forces:
        if forces.body.element.locks and PLASTIC in forces.body.material.history_names:
            yield PlasticFlow(forces)


class PlasticFlow:
    """`worst`: largest equivalent plastic strain of any point of a cell that is not strained evenly."""

    def __init__(self, forces: BodyForces) -> None:
        self.forces, self.worst = forces, np.zeros(1)
        self.row = forces.body.material.history_names.index(PLASTIC)

    def update(self) -> None:
        """Keep the largest plastic strain of the last accepted step."""
        for block in self.forces.blocks:
            flow = block.history[self.row].reshape(self.forces.body.points, -1)
            largest = flow.max(axis=0)
            uneven = np.ptp(flow, axis=0) > EVEN * largest
            self.worst[0] = max(self.worst[0], float(largest[uneven].max(initial=0.0)))

    def warning(self) -> RunWarning | None:
        """Advise an element that does not lock, once plastic strain is large; None before."""
        strain = float(self.worst[0])
        if strain <= FLOW:
            return None
        body = self.forces.body
        key, other = f"bodies.{body.name}.element", body.element.beyond.get("freedom from locking")
        return needed(
            "locking", strain, FLOW, key,
            f"body {body.name}: the plastic strain, which keeps the volume, reaches {per_cent(strain)}, and its "
            "element locks if the volume hardly changes",
            f'write {key} = "{other}"' if other else f"use an element that does not lock at {key}",
        )  # fmt: skip
