"""All looks at one run, and what they found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats
from contactlab.missing_effects.locking import locking_looks
from contactlab.missing_effects.overlap import overlap_looks
from contactlab.missing_effects.pace import pace_looks
from contactlab.missing_effects.sides import side_looks
from contactlab.missing_effects.strain import strain_looks
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.scene.scene import Scene

LOOKS = (strain_looks, locking_looks, pace_looks, side_looks, overlap_looks)


class Watch:
    """Looks at a run's stored frames for effects that its scene would need; adds them to the model's warnings."""

    def __init__(self, scene: Scene, model: Model) -> None:
        self.warnings = model.warnings
        self.looks = [look for looks in LOOKS for look in looks(scene, model)]

    def look(self) -> None:
        """Let every detector look at the present state, and add what it warns of."""
        for look in self.looks:
            look.look()
            warning = look.warning()
            if warning is not None:
                self.warnings.add(warning)

    def memory(self) -> dict[str, Floats]:
        """Everything that changes while the run goes on."""
        return {"looks": np.concatenate([np.zeros(0), *(look.worst for look in self.looks)])}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Back to where `memory` was taken."""
        start = 0
        for look in self.looks:
            look.worst[:] = memory["looks"][start : start + len(look.worst)]
            start += len(look.worst)
