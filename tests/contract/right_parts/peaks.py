# kind watch cls Peaks
from dataclasses import dataclass

import numpy as np

from contactlab.api import Watch


@dataclass(frozen=True)
class Peaks(Watch):
    """Largest speed, impulse of the contact force, and the number of steps in contact.

    contact  number of the contact
    """

    contact: int = 0

    def begin(self, view):
        return {"speed": np.zeros(1), "impulse": np.zeros(1), "steps": np.zeros(1)}

    def step(self, view, memory):
        v = view.field("velocity")
        memory["speed"][0] = max(memory["speed"][0], np.hypot(v[:, 0], v[:, 1]).max())
        force = view.normal_forces(self.contact).sum()
        memory["impulse"] += force * view.dt
        memory["steps"] += float(force > 0.0)
