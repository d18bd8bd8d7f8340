"""Read-only view of a run for watches: the state after a step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, Ints, Step
from contactlab.model.model import Model
from contactlab.results.slips import slips_of

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair


class ModelView:
    """Read-only view of a model between two steps. Implements `contactlab.api.StepView`."""

    def __init__(self, model: Model) -> None:
        self._model, self._state = model, model.state
        self.time, self.dt, self.step, self.sweeps, self.iterations = 0.0, 0.0, 0, 0, 0
        self.reference, self.position, self.mass = (_sealed(a) for a in (model.reference, model.position, model.mass))
        self._fields = {name: _sealed(values) for name, values in self._state.fields.items()}
        self._nodes = {body.name: slice(body.first, body.first + body.count) for body in model.bodies}
        self.bodies = tuple(self._nodes)
        self._pairs: tuple[ContactPair, ...] = tuple(model.contact.pairs) if model.contact is not None else ()
        self.contacts = len(self._pairs)
        self._lengths = [_median_segment(pair, model.reference) for pair in self._pairs]
        self._load = np.zeros_like(model.reference)
        self.time = model.state.time

    def took(self, step: Step, dt: float) -> None:
        """Take in an accepted step: its reactions, work and length."""
        self.time, self.dt, self.step = self._state.time, dt, self._state.step
        self.sweeps, self.iterations = step.sweeps, step.iterations

    def field(self, name: str) -> Floats:
        """A field of the state by name, read-only."""
        return self._fields[name]

    def nodes(self, body: str) -> slice:
        """Numbers of the nodes of a body."""
        return self._nodes[body]

    def slave(self, contact: int = 0) -> Ints:
        """Global numbers of the slave nodes."""
        return self._pairs[contact].slave.nodes

    def master(self, contact: int = 0) -> Ints:
        """Global numbers of the master nodes."""
        return self._pairs[contact].master.nodes

    def segment(self, contact: int = 0) -> float:
        """Length [mm] of the slave's segments."""
        return self._lengths[contact]

    def normal_forces(self, contact: int = 0) -> Floats:
        """Nodal normal forces [N] of a contact."""
        return self._fields["multipliers"][0, self._slots(contact)]

    def _slots(self, contact: int) -> slice:
        return self._pairs[contact].own

    def slips(self, contact: int = 0) -> Floats:
        """Tangential motion in this step: what the rows predicted, and what the forces changed of it."""
        return slips_of(self._model)[self._slots(contact)]

    def external_force(self) -> Floats:
        """Nodal forces (N, 2) [N] of loads and effects."""
        self._load[:] = 0.0
        self._model.external_force(self._state.time, self._load)
        return self._load

    def kinetic_energy(self) -> float:
        """Kinetic energy 1/2 v M v [mJ]."""
        return self._model.kinetic_energy()

    def stored_energy(self) -> float:
        """Strain energy [mJ] of all bodies, and what surfaces store."""
        contact = self._model.contact
        surfaces = contact.stored_since_start if contact is not None else 0.0
        return float(sum(forces.stored_energy() for forces in self._model.forces)) + surfaces


def _sealed(values: Floats) -> Floats:
    """Make a view that cannot be written to."""
    view = values.view()
    view.flags.writeable = False
    return view


def _median_segment(pair: ContactPair, reference: Floats) -> float:
    a, b = reference[pair.slave.nodes][pair.slave.segments.T]
    return float(np.median(np.hypot(*(b - a).T)))
