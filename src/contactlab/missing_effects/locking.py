"""Elements that lock where the material keeps its volume."""

from __future__ import annotations

import numpy as np

from contactlab.api import RunWarning
from contactlab.missing_effects.missing_effect import Detectors, Known, needed, per_cent
from contactlab.model.bodies.body import Body, BodyForces
from contactlab.model.model import Model

POISSON = 0.49
FLOW = 0.01  # equivalent plastic strain, well beyond elastic strains: volume-preserving flow rules the deformation
PLASTIC = "equivalent_plastic_strain"


def locking_detectors(scene: object, model: Model) -> Detectors:
    """Detectors for bodies of elements that lock: by the law's Poisson ratio, and by plastic flow."""
    del scene
    for forces in model.forces:
        body = forces.body
        if not body.element.locks:
            continue
        ratio = poisson(body)
        if ratio > POISSON:
            yield Known(_locks(body, ratio, POISSON, f"Poisson's ratio is {ratio:.4g}"))
        elif PLASTIC in body.material.history_names:
            yield PlasticFlow(forces)


def poisson(body: Body) -> float:
    """Poisson's ratio of the undeformed material, from its wave speeds: (c_s/c_p)^2 = (1 - 2 nu)/(2 - 2 nu)."""
    dilatational, shear = body.material.wave_speeds()
    ratio = (shear / dilatational) ** 2
    return (1.0 - 2.0 * ratio) / (2.0 - 2.0 * ratio)


class PlasticFlow:
    """`worst`: largest equivalent plastic strain of any point."""

    def __init__(self, forces: BodyForces) -> None:
        self.forces, self.worst = forces, np.zeros(1)
        self.row = forces.body.material.history_names.index(PLASTIC)

    def update(self) -> None:
        """Keep the largest plastic strain of the last accepted step."""
        strain = max(float(block.history[self.row].max()) for block in self.forces.blocks)
        self.worst[0] = max(self.worst[0], strain)

    def warning(self) -> RunWarning | None:
        """Advise an element that does not lock, once plastic strain is large; None before."""
        strain = float(self.worst[0])
        if strain <= FLOW:
            return None
        seen = f"the plastic strain, which keeps the volume, reaches {per_cent(strain)}"
        return _locks(self.forces.body, strain, FLOW, seen)


def _locks(body: Body, value: float, limit: float, seen: str) -> RunWarning:
    key = f"bodies.{body.name}.element"
    other = body.element.beyond.get("freedom from locking")
    return needed(
        "locking",
        value,
        limit,
        key,
        f"body {body.name}: {seen}, and its element is too stiff where the volume hardly changes",
        f'write {key} = "{other}"' if other else f"use an element that does not lock at {key}",
    )
