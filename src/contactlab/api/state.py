"""Everything that changes in time, in one flat array."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from contactlab.api.arrays import Floats


class State:
    """Named views of one flat float64 buffer: a restart file contains exactly this buffer.

    The core gives every run these fields (N nodes, k multiplier slots of all contacts):

    clock           (3,)    time [s], number of steps taken, and length of the last one [s]; kept by the core
    displacement    (N, 2)  u at `time` [mm]
    velocity        (N, 2)  v at `time`, or earlier by an explicit integrator's `velocity_lag` [mm/s]; none in statics
    drift           (N, 2)  slow part of the velocity, exempt from damping in quasi-static runs [mm/s]; see
                            `Equations.damping`
    internal_force  (N, 2)  of the stresses at `time` [N]
    reaction        (N, 2)  forces of supports on prescribed degrees of freedom in the last step [N]
    work            (7,)    energy balance, see `WORK` [mJ]
    multipliers     (1 or 2, k)  nodal contact forces y, normal and (with friction) tangential [N]
    multipliers_before (k,)  normal multipliers one step earlier [N]
    contact_force   (N, 2)  contact forces on the nodes over the last step [N]
    release         (k,)    how far multipliers of statics came free in the last step, from 0 (merged) to 1
    release_pace    (2,)    what the present and the last step add to it
    history.BODY    history of each body whose law has any, all its blocks one after another
    memory.CONTACT  memory of a contact algorithm that declares any
    friction.CONTACT  (n, 2) friction of a potential at the end of the step, on the nodes of both sides [N]
                    or bound, pressure, rate and memory (r, k) of a friction law with needs
    pressure_law    (r, k) memory of a pressure law that declares any, and the rate of slip [mm/s] if it needs that

    effects.N       (r, nodes) memory of an effect that declares any, at each node

    step_error      (2,)    error of the last step over its tolerance, and of the step before, with a `StepControl`

    and an integrator may declare more. Fields that no part declares do not exist.
    """

    def __init__(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        sizes = {name: int(np.prod(shape)) for name, shape in shapes.items()}
        self.buffer: Floats = np.zeros(sum(sizes.values()))
        self.fields: dict[str, Floats] = {}
        start = 0
        for name, shape in shapes.items():
            self.fields[name] = self.buffer[start : start + sizes[name]].reshape(shape)
            start += sizes[name]

    def __getitem__(self, name: str) -> Floats:
        return self.fields[name]

    def __contains__(self, name: str) -> bool:
        return name in self.fields

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self.fields["clock"][0])

    @property
    def step(self) -> int:
        """Number of accepted steps so far."""
        return int(self.fields["clock"][1])

    @property
    def last_dt(self) -> float:
        """Length of the last accepted step [s]; 0 before the first."""
        return float(self.fields["clock"][2])

    def snapshot(self) -> Floats:
        """Return a copy of the whole state."""
        return self.buffer.copy()

    def restore(self, snapshot: Floats) -> None:
        """Restore a snapshot exactly; views stay valid."""
        self.buffer[:] = snapshot


WORK = ("internal", "external", "damping", "contact", "friction", "numerical", "slip")
"""Entries of the field `work`: work done so far [mJ] by stresses (stored or dissipated in the bodies),
by loads and supports, by damping (dissipated), by normal contact forces on the nodes, by friction
forces (negative when they dissipate), by forces that only stabilise the discretisation. The last entry is
the sum of -y_t d with the slip d of each step, which never falls: `friction` differs from its negative
by the work on the slip before a reversal (docs/theory/forward-increment.md)."""

CONTACT_WORK = ("closing", "step", "normals", "weights")
"""Parts of the entry `contact` of the energy balance: work of normal forces [mJ] on surfaces that approach or
separate, by the step itself, whose rows belong to other positions than it connects, by normals that turn, and by
weights that change as surfaces slide along each other (docs/theory/contact-energy.md)."""
