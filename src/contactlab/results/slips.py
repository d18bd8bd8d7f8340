"""Tangential motion of contacts in the last step."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from contactlab.api import Floats
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.contact.explicit_system import ContactSystem


def slips_of(model: Model) -> Floats:
    """Slip (k,) [mm] of all multipliers: what the rows predicted, and what the forces of the step changed of it.

    Raises LookupError where the model's contact has no rows with slips.
    """
    rows = getattr(model.contact, "rows", None)
    if rows is None or not len(rows.slip):
        raise LookupError("slips are known to explicit runs with friction alone")
    contact = cast("ContactSystem", model.contact)
    out = np.zeros(model.state["multipliers"].shape[1])
    compliance, force = contact.compliance, model.state["contact_force"]
    for k in range(rows.count):
        entries = slice(rows.start[k], rows.start[k + 1])
        node = rows.node[entries]
        pushed = (rows.tangent_weight[entries] * compliance[node] * force[node]).sum()
        out[rows.slot[k]] += rows.slip[k] + float(pushed)
    return out
