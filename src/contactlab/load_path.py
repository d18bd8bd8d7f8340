"""How far the loading of a static run has come, so that load steps can be of equal size."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats
from contactlab.model.model import Model

SAMPLES = 1024
LEAST = 1e-3  # of the whole path that time itself counts, so that a hold is passed in few steps


class LoadPath:
    """Fraction of the loading (0 to 1) as a function of time, and back.

    Between two times the loading advances by the largest change of any prescribed displacement, over the range
    of that displacement, or of any load, over the largest one. Inertia plays no part in statics: what counts
    for the accuracy of a step is how much is loaded in it, not how long it takes.
    """

    def __init__(self, model: Model, end: float) -> None:
        self.times: Floats = np.linspace(0.0, end, SAMPLES + 1)
        change = np.full(SAMPLES, LEAST / SAMPLES)
        np.maximum(change, _motion(model, self.times), out=change)
        np.maximum(change, _loads(model, self.times), out=change)
        self.fractions: Floats = np.concatenate([[0.0], np.cumsum(change)])
        self.fractions /= self.fractions[-1]

    def fraction(self, time: float) -> float:
        """How much of the loading is done at a time [s]."""
        return float(np.interp(time, self.times, self.fractions))

    def time(self, fraction: float) -> float:
        """When that much of the loading is done [s]."""
        return float(np.interp(fraction, self.fractions, self.times))


class EvenPath:
    """Time itself, for runs in which it matters."""

    def __init__(self, end: float) -> None:
        self.end = end

    def fraction(self, time: float) -> float:
        """Fraction of the end."""
        return time / self.end

    def time(self, fraction: float) -> float:
        """And back [s]."""
        return fraction * self.end


def _motion(model: Model, times: Floats) -> Floats:
    """Largest relative change of a prescribed displacement in each interval."""
    values = np.array([model.prescribed.values(float(time)).copy() for time in times])
    span = np.ptp(values, axis=0)
    moving = span > 1e-12 * max(float(np.abs(values).max(initial=0.0)), 1e-300)
    if not moving.any():
        return np.zeros(len(times) - 1)
    return np.asarray(np.abs(np.diff(values[:, moving], axis=0) / span[moving]).max(axis=1))


def _loads(model: Model, times: Floats) -> Floats:
    """Largest change of a nodal load over the largest load, at the undeformed positions."""
    out = np.zeros_like(model.reference)
    if not model.external_force(0.0, out):
        return np.zeros(len(times) - 1)
    before, changes, largest = out.copy(), [], float(np.abs(out).max())
    for time in times[1:]:
        model.external_force(float(time), out)
        changes.append(float(np.abs(out - before).max()))
        largest = max(largest, float(np.abs(out).max()))
        before[:] = out
    return np.array(changes) / largest if largest > 0.0 else np.zeros(len(times) - 1)
