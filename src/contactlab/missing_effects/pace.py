"""Runs that should be quasi-static and are not."""

from __future__ import annotations

import math

import numpy as np

from contactlab.api import RunWarning
from contactlab.missing_effects.missing_effect import Looks, needed, per_cent
from contactlab.model.model import Model

SHARE = 0.01  # of kinetic over internal energy
UNRESISTED = 0.5  # a body that meets a resistance stores more than half of its kinetic energy at any pace


def pace_looks(scene: object, model: Model) -> Looks:
    """Looks at runs with `end = "auto"` and inertia."""
    del scene
    if model.pace.end is None and model.integrator.inertia:
        yield KineticEnergy(model)


class KineticEnergy:
    """`worst`: largest kinetic energy in the second half of the ramp and after, and largest internal energy [mJ].

    In the first half of the ramp a body may still be on its way to the others.
    """

    def __init__(self, model: Model) -> None:
        self.model, self.worst = model, np.zeros(2)

    def look(self) -> None:
        """Kinetic energy, and the work of the stresses."""
        if self.model.state.time >= 0.5 * self.model.pace.ramp:
            self.worst[0] = max(self.worst[0], self.model.kinetic_energy())
        self.worst[1] = max(self.worst[1], abs(float(self.model.state["work"][0])))

    def warning(self) -> RunWarning | None:
        """A slower ramp: kinetic energy goes with the square of the speed."""
        kinetic, internal = (float(value) for value in self.worst)
        if kinetic <= SHARE * internal:
            return None
        share = kinetic / max(internal, 1e-300)
        if share > UNRESISTED:
            return needed(
                "slower-loading",
                share,
                SHARE,
                "time.ramp",
                "nothing resists the motion of a run that is meant to be quasi-static: kinetic energy reaches "
                f"{per_cent(share)} of the internal energy ({per_cent(SHARE)} at most)",
                "hold or join what moves by supports and contacts, or slow down: "
                f"write time.ramp = {10.0 * self.model.pace.ramp:.3g} or more",
            )
        slower = math.ceil(10.0 * math.sqrt(share / SHARE)) / 10.0
        return needed(
            "slower-loading",
            share,
            SHARE,
            "time.ramp",
            f"kinetic energy reaches {per_cent(share)} of the internal energy in a run that is meant to be "
            f"quasi-static ({per_cent(SHARE)} at most)",
            f"write time.ramp = {slower * self.model.pace.ramp:.3g} or more",
        )
