"""Force and energy of a strain in a scene of given size and stiffness: below the round-off strain they are zero."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.implicit.trial import ROUND_OFF
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair


def force_of_strain(model: Model, strain: float) -> float:
    """Force [N] of a strain over the size of the scene, in its stiffest body."""
    extent, modulus = _scale(model)
    return strain * extent * modulus


def round_off_of_reactions(model: Model) -> float:
    """Force [N] by which positions, numbers of 16 digits, leave reactions of the stiffest body uncertain."""
    return ROUND_OFF * float(np.abs(model.position).max()) * _scale(model)[1]


def contact_force_of_strain(model: Model, pair: ContactPair, strain: float) -> float:
    """Force [N] of a strain over the size of the scene, in the softer body of a contact."""
    nodes = np.concatenate([pair.slave.nodes, pair.master.nodes])
    joined = [body for body in model.bodies if np.any((nodes >= body.first) & (nodes < body.first + body.count))]
    return strain * _scale(model)[0] * min(body.dilatational_modulus for body in joined)


def energy_of_strain(model: Model, strain: float) -> float:
    """Energy [mJ] of the same strain."""
    extent, modulus = _scale(model)
    return (strain * extent) ** 2 * modulus


def _scale(model: Model) -> tuple[float, float]:
    """Size of the scene [mm] and largest modulus [MPa]."""
    extent = float(np.ptp(model.reference, axis=0).max())
    return extent, max(body.dilatational_modulus for body in model.bodies)
