"""Imbalance of the forces of supports and loads."""

from __future__ import annotations

import numpy as np

from contactlab.model.model import Model
from contactlab.results.strain_scale import force_of_strain, round_off_of_reactions

NO_STRAIN = 1e-12  # round-off of positions over the size of a scene, with some digits to spare


def reaction_mismatch(model: Model, least: float = 0.0) -> float:
    """|sum of all support reactions and loads| over the largest of them: zero in statics; NaN without two of them.

    Also NaN if none exceeds the force from round-off of positions: a body that moves freely is at rest.
    A load counts by the sum of its nodal forces' magnitudes, so that one that balances itself has a size, too. A
    largest below `least` [N] counts as that.
    """
    total, largest = reaction_sum(model)
    return total / max(largest, least)


def reaction_sum(model: Model) -> tuple[float, float]:
    """|sum of all support reactions and loads| [N], NaN if they need not balance, and the largest of them."""
    reactions = list(model.reactions().values())
    sizes = [float(np.hypot(*force)) for force in reactions]
    applied = np.zeros_like(model.reference)
    if model.external_force(model.state.time, applied):
        sizes.append(float(np.hypot(*applied.T).sum()))
    largest, least = max(sizes, default=0.0), force_of_strain(model, NO_STRAIN)
    if not model.integrator.inertia:
        # loads and contact forces say that soft bodies are loaded, where reactions of stiff ones may be round-off
        moduli = [body.dilatational_modulus for body in model.bodies]
        least *= min(moduli) / max(moduli)
        contact = model.state["contact_force"] if model.contact is not None else 0.0 * applied
        if not max(np.hypot(*applied.T).sum(), np.hypot(*contact.T).sum()) > least:
            least = max(least, round_off_of_reactions(model))
    if largest <= least or len(sizes) < 2:
        return float("nan"), max(largest, least)
    total = np.sum(reactions, axis=0) + applied.sum(axis=0)
    if model.contact is not None and any(pair.half for pair in model.contact.pairs):
        total += model.state["contact_force"].sum(axis=0)  # half passes balance as far as the meshes resolve
    return float(np.hypot(*total)), largest
