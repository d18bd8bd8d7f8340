"""Imbalance of the forces of supports and loads."""

from __future__ import annotations

import numpy as np

from contactlab.model.model import Model
from contactlab.results.strain_scale import force_of_strain

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
    largest = max(sizes, default=0.0)
    if largest <= (least := force_of_strain(model, NO_STRAIN)) or len(sizes) < 2:
        return float("nan"), max(largest, least)
    total = np.sum(reactions, axis=0) + applied.sum(axis=0)
    if model.contact is not None and any(pair.half for pair in model.contact.pairs):
        total += model.state["contact_force"].sum(axis=0)  # half passes balance as far as the meshes resolve
    return float(np.hypot(*total)), largest
