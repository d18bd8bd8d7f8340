"""All looks at one run, and what they found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contactlab.api import Floats
from contactlab.missing_effects.locking import locking_looks
from contactlab.missing_effects.missing_effect import Need
from contactlab.missing_effects.overlap import overlap_looks
from contactlab.missing_effects.pace import pace_looks
from contactlab.missing_effects.sides import side_looks
from contactlab.missing_effects.strain import strain_looks
from contactlab.model.model import Model

LOOKS = (strain_looks, locking_looks, pace_looks, side_looks, overlap_looks)


class Watch:
    """Looks at a run's stored frames for effects that its scene would need. `look` changes nothing in the model."""

    def __init__(self, scene: Any, model: Model) -> None:
        self.looks = [look for looks in LOOKS for look in looks(scene, model)]
        self.told: set[tuple[str, ...]] = set()

    def look(self) -> list[Need]:
        """Look at the present state; needs that were not seen before."""
        for look in self.looks:
            look.look()
        new = [need for need in self.needs() if need[:2] not in self.told]
        self.told |= {need[:2] for need in new}
        return new

    def needs(self) -> list[Need]:
        """Everything that is missing by what was seen so far, each thing once."""
        found = [look.need() for look in self.looks]
        return list({need[:2]: need for need in found if need is not None}.values())

    def warnings(self) -> list[dict[str, str]]:
        """The same for `summary.json`."""
        return [need._asdict() for need in self.needs()]

    def memory(self) -> dict[str, Floats]:
        """Everything that changes while the run goes on."""
        return {"needs": np.concatenate([np.zeros(0), *(look.worst for look in self.looks)])}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Back to where `memory` was taken; what was told then is not told again."""
        start = 0
        for look in self.looks:
            look.worst[:] = memory["needs"][start : start + len(look.worst)]
            start += len(look.worst)
        self.told = {need[:2] for need in self.needs()}
