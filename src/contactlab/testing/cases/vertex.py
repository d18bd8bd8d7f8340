"""Two squares that fall corner on corner."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats
from contactlab.scene.scene import load_scene
from contactlab.testing.cases.figures import Figure
from contactlab.testing.cases.watched import WatchedRun

END = 1e-4  # s
OFFSET = 0.3  # segments


def vertex_to_vertex(algorithm: str, full: bool) -> list[Figure]:
    """Aligned corners stay a mirror image of themselves; corners that miss mirror those that miss the other way."""
    aligned, left, right = (_fall(algorithm, full, offset) for offset in (0.0, -OFFSET, OFFSET))
    speeds = [fall.run.mean(fall.run.state["velocity"], "upper")[0] for fall in (left, right)]
    return [
        Figure("aligned: mirror symmetry, largest error [segments]", aligned.mirrored(aligned), most=1e-8),
        Figure("aligned: overlap [segments squared]", aligned.overlap, most=0.01),
        Figure("aligned: linear momentum, change", aligned.momentum, most=1e-12),
        Figure("offset: the two ways mirror each other, largest error [segments]", left.mirrored(right), most=1e-8),
        Figure("offset: sideways speeds over one another, plus one", abs(speeds[0] / speeds[1] + 1.0), most=1e-8),
        Figure("offset: overlap [segments squared]", max(left.overlap, right.overlap), most=0.01),
        Figure("offset: linear momentum, change", max(left.momentum, right.momentum), most=1e-12),
    ]


class _Fall:
    """A run to its end, and what was seen of it."""

    def __init__(self, run: WatchedRun, segment: float) -> None:
        self.run, self.segment, self.overlap = run, segment, 0.0
        start = run.momentum()
        run.until(END, self._look)
        scale = float(run.model.mass @ np.hypot(*run.state["velocity"].T))
        self.momentum = float(np.abs(run.momentum() - start).max()) / scale

    def _look(self) -> None:
        """Area between the upper side of the lower square and the lower side of the upper one."""
        at = self.run.model.position
        x = np.linspace(-2.0, 2.0, 4001) * self.segment
        pair = self.run.contact.pairs[0]
        upper, lower = (self._height(at[side.nodes], x) for side in (pair.slave, pair.master))
        area = np.maximum(lower - upper, 0.0).sum() * (x[1] - x[0])
        self.overlap = max(self.overlap, float(area) / self.segment**2)

    @staticmethod
    def _height(points: Floats, x: Floats) -> Floats:
        order = np.argsort(points[:, 0])
        return np.asarray(np.interp(x, points[order, 0], points[order, 1]))

    def mirrored(self, other: _Fall) -> float:
        """Largest difference to the mirror image of another fall."""
        first, second = self.run.model, other.run.model
        image = second.reference * [-1.0, 1.0]
        twin = [int(np.argmin(np.hypot(*(image - x).T))) for x in first.reference]
        difference = first.position - second.position[twin] * [-1.0, 1.0]
        return float(np.abs(difference).max()) / self.segment


def _fall(algorithm: str, full: bool, offset: float) -> _Fall:
    cells = 20 if full else 10
    segment = 10.0 / cells
    changes = {
        "contacts.0.algorithm": algorithm,
        "bodies.upper.mesh.cells": [cells, cells],
        "bodies.lower.mesh.cells": [cells, cells],
        # both move by half, so that one fall is the mirror image of the other
        "bodies.upper.shift": [0.5 * offset * segment, 0.05],
        "bodies.lower.shift": [-0.5 * offset * segment, 0.0],
    }
    return _Fall(WatchedRun(load_scene("vertex-to-vertex").with_(changes)), segment)
