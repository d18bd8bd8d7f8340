"""Scalars of every step, read in blocks when they are asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.results.checksums import Damage
from contactlab.results.damage import BROKEN, damage_told, whole_steps
from contactlab.results.stored_file import opened
from contactlab.results.stored_sequence import StoredSequence

STEPS_AT_ONCE = 65536


class StoredSteps(StoredSequence[Floats]):
    """Scalars of every step in blocks (b, columns), read when they are asked for; `salvage`: those that are whole."""

    def __init__(self, folder: Path, count: int, salvage: bool = False) -> None:
        self.folder, self.total, self.salvage = folder, count, salvage

    def __len__(self) -> int:
        return -(-self.total // STEPS_AT_ONCE)

    def read(self, number: int) -> Floats:
        """Block `number`. Raises RequestError where it is damaged."""
        begin = number * STEPS_AT_ONCE
        end = min(begin + STEPS_AT_ONCE, self.total)
        with opened(self.folder) as file:
            if self.salvage:
                return self._whole(file, begin, end)
            with damage_told(self.folder):
                block: Floats = file["contactlab/steps"][begin:end]
                good = whole_steps(file, begin, end)
                if not good.all():
                    raise Damage(f"{np.count_nonzero(~good)} of {self.total} steps are damaged")
                return block

    def _whole(self, file: Any, begin: int, end: int) -> Floats:
        try:
            block: Floats = np.asarray(file["contactlab/steps"][begin:end])
            return np.asarray(block[whole_steps(file, begin, end)])
        except BROKEN:
            return np.zeros((0, file["contactlab/steps"].shape[1]))
