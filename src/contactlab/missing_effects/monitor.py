"""All detectors of missing effects of one run, and what they found."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from contactlab.api import Floats, Step
from contactlab.missing_effects.bending import bending_detectors
from contactlab.missing_effects.early_contact import EarlyContact, early_detectors
from contactlab.missing_effects.leaning_forces import leaning_detectors
from contactlab.missing_effects.locking import locking_detectors
from contactlab.missing_effects.missing_effect import Detector
from contactlab.missing_effects.overlap import overlap_detectors
from contactlab.missing_effects.quasi_static import quasi_static_detectors, work_detectors
from contactlab.missing_effects.sides import side_detectors
from contactlab.missing_effects.strain import strain_detectors
from contactlab.model.model import Model
from contactlab.scene.scene import Scene

DETECTORS = (
    strain_detectors, locking_detectors, quasi_static_detectors, leaning_detectors, overlap_detectors,
)  # fmt: skip
# their energies and forces are small in early frames, and shares of them mean nothing there
AT_THE_END = (bending_detectors, work_detectors, side_detectors, early_detectors)
KEY = "looks"  # in checkpoints: files keep their names


class EffectMonitor:
    """Examines a run's stored frames for effects that its scene would need; adds them to the model's warnings."""

    def __init__(self, scene: Scene, model: Model) -> None:
        self.warnings = model.warnings
        self.early, self.late = (
            [detector for found in kinds for detector in found(scene, model)] for kinds in (DETECTORS, AT_THE_END)
        )
        self.detectors = [*self.early, *self.late]

    @property
    def every_step(self) -> tuple[Callable[[Step, float], None], ...]:
        """Callbacks after each accepted step: of detectors that frames are not enough for."""
        return tuple(detector.follow for detector in self.detectors if isinstance(detector, EarlyContact))

    def examine_frame(self) -> None:
        """Let every detector take in the present state, and add warnings of the state so far."""
        for detector in self.detectors:
            detector.update()
        self._add(self.early)

    def judge(self) -> None:
        """Add warnings of the whole run, at its end."""
        self._add(self.late)

    def _add(self, detectors: list[Detector]) -> None:
        self.warnings.add(*filter(None, (detector.warning() for detector in detectors)))

    def saved(self) -> dict[str, Floats]:
        """Everything that changes during the run."""
        return {KEY: np.concatenate([np.zeros(0), *(detector.worst for detector in self.detectors)])}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Go back to where `memory` was saved."""
        start = 0
        for detector in self.detectors:
            detector.worst[:] = memory[KEY][start : start + len(detector.worst)]
            start += len(detector.worst)
