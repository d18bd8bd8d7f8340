"""The energy that leapfrog keeps, from the stored energy of laws: gain by contact, and unexplained gain."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.model.model import Model


class EnergyGain(NamedTuple):
    """Energies [mJ] at one instant: total, gained and unexplained.

    energy       kinetic and stored
    gained       excess over the start and the external work: made by contact, or
                 unexplained. Damping, friction and plastic flow take energy away: it is a lower bound
    unexplained  stored and dissipated beyond the work of the stresses; 0 if a law stores no energy
    """

    energy: float
    gained: float
    unexplained: float


def energy_gain(model: Model) -> EnergyGain:
    """Return the energy balance of the current state; evaluates all laws once.

    In a leapfrog kinetic energy and works belong to the velocity half a step back, and so must the stored energy: of a
    linear body 1/2 u_n K u_{n+1}, which is U(u_{n+1}) less half a step's work of its forces
    (docs/theory/explicit-scheme.md).
    The work of the stresses is exactly that then, for any stable step.
    """
    state = model.state
    stored, unexplained = stored_energy(model)
    energy = model.kinetic_energy() + stored
    if model.contact is not None:
        energy += model.contact.stored_since_start
    return EnergyGain(energy, energy - model.initial_energy - float(state["work"][1]), unexplained)


def stored_energy(model: Model) -> tuple[float, float]:
    """Return the energy [mJ] in the bodies, and the excess of it and of their dissipation over the stress work.

    A law without stored energy is assumed to have taken all of this work.
    """
    work = float(model.state["work"][0])
    stored = float(sum(forces.stored_energy() + forces.numerical_energy() for forces in model.forces))
    if np.isnan(stored):
        return work, 0.0
    stored -= model.lagging_work()
    return stored, stored + sum(forces.dissipated_energy() for forces in model.forces) - work
