"""The energy ledger of a run (docs/theory/explicit-scheme.md)."""

from __future__ import annotations

import numpy as np

from contactlab.api.state import CONTACT_WORK
from contactlab.model.model import Model

ALONG_THE_WAY = ("internal", "external", "damping", "contact", "friction", "numerical", "slip", "error")


def energies(model: Model) -> dict[str, float]:
    """Energies and works [mJ] since the start of the run, by name.

    kinetic   with velocities half a step back (explicit)
    stored    strain energy of the material models; NaN if any of them has none
    plastic   dissipated by the material models, from their history
    internal  work of the stresses, by the energy balance: stored + plastic up to O(dt^2)
    numerical by the energy balance, and stored in modes that only an element's stabilisation resists; the latter's
              work is booked with the work of the stresses and subtracted from `internal` here
    external, damping, contact, friction: as in `contactlab.api.WORK`
    contact.PART: parts of `contact`, see `contactlab.api.state.CONTACT_WORK`, if the scene requests them
    error     error of the energy balance over its largest energy

    Works along a path that was not followed are NaN: if a step skips it, only both ends are known.
    """
    work = model.state["work"]
    kinetic = model.kinetic_energy() if "velocity" in model.state else 0.0
    start = model.initial_energy
    stored = float(sum(forces.stored_energy() for forces in model.forces))
    plastic = sum(forces.dissipated_energy() for forces in model.forces)
    stabilising = sum(forces.numerical_energy() for forces in model.forces)
    total = kinetic + work[0] + work[2] + work[5] - work[1] - work[3] - work[4] - start
    scale = max(abs(kinetic) + abs(work[0]) + abs(work[1]), abs(start), 1e-300)
    found = {
        "kinetic": kinetic,
        "stored": stored,
        "plastic": plastic,
        "internal": float(work[0]) - stabilising,
        "external": float(work[1]),
        "damping": float(work[2]),
        "contact": float(work[3]),
        "friction": float(work[4]),
        "numerical": float(work[5]) + stabilising,
        "slip": float(work[6]),
        "error": float(np.abs(total) / scale),
    }
    if model.split is not None:
        found |= {f"contact.{part}": float(work) for part, work in zip(CONTACT_WORK, model.split.work, strict=True)}
    return found if model.way_followed else found | dict.fromkeys(ALONG_THE_WAY, np.nan)
