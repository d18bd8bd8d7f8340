# kind recorder cls Lines
import json
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Recorder, Recording


@dataclass(frozen=True)
class Lines(Recorder):
    """A line of JSON for every frame, and the scalars of all steps in one file.

    file  name
    """

    file: str = "lines.json"
    every_step: ClassVar[bool] = True

    def open(self, folder, layout):
        return Out(folder / self.file, layout)

    def disk_bytes(self, layout, steps, memory):
        return 20.0 * len(layout.steps) * steps


class Out(Recording):
    def __init__(self, path, layout):
        self.out = path.open("w")
        self.kept = []
        self.out.write(json.dumps({"steps": list(layout.steps)}) + "\n")

    def steps(self, block):
        self.kept.append(block.copy())

    def frame(self, frame):
        rows = sum(len(block) for block in self.kept)
        self.out.write(
            json.dumps(
                {"time": frame.time, "step": frame.step, "rows": rows, "most": float(np.abs(frame.displacement).max())}
            )
            + "\n"
        )
        self.out.flush()

    def close(self, summary):
        total = np.concatenate(self.kept).sum(axis=0).tolist() if self.kept else []
        self.out.write(json.dumps({"status": summary["status"], "sum": [x for x in total if np.isfinite(x)]}) + "\n")
        self.out.close()
