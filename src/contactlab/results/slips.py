"""Tangential motion of contacts in the last step."""

from __future__ import annotations

from contactlab.api import Floats
from contactlab.model.model import ExplicitModel, Model


def slips_of(model: Model) -> Floats:
    """Slip (k,) [mm] of all multipliers; LookupError if the steps of the model have no slips."""
    if not isinstance(model, ExplicitModel) or model.contact is None or not model.contact.friction:
        raise LookupError("slips exist only in explicit runs with friction")
    return model.contact.slips()
