"""The energy that leapfrog keeps, from what the laws store: what contact has made of it, and what nothing explains."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.model.model import Model


class EnergyGain(NamedTuple):
    """Energies [mJ] at one instant: what is there, and what nothing accounts for.

    energy       kinetic and stored
    gained       of it beyond that of the start and the work done from outside: what contact has made, and what
                 nothing explains. Damping, friction and plastic flow take energy away: it is the least that was made
    unexplained  stored and dissipated beyond the work of the stresses; 0 where a law stores no energy
    """

    energy: float
    gained: float
    unexplained: float


def energy_gain(model: Model) -> EnergyGain:
    """Energy balance of the current state; evaluates all laws once.

    In a leapfrog kinetic energy and works belong to the velocity half a step back, and so must what is stored: of a
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
    """Energy [mJ] in the bodies, and what of it and of their dissipation is beyond the work of the stresses.

    A law that stores no energy has taken all of that work, as far as is known.
    """
    work = float(model.state["work"][0])
    stored = float(sum(forces.stored_energy() + forces.numerical_energy() for forces in model.forces))
    if np.isnan(stored):
        return work, 0.0
    stored -= model.lagging_work()
    return stored, stored + sum(forces.dissipated_energy() for forces in model.forces) - work
