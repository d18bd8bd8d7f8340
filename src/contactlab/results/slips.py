"""Tangential motion of contacts in the last step."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats
from contactlab.model.model import Model


def slips_of(model: Model, dt: float) -> Floats:
    """Slip (k,) [mm] of all multipliers: what the rows predicted, and what the forces of a step dt changed of it.

    Raises LookupError where the model's contact has no rows with slips.
    """
    rows = getattr(model.contact, "rows", None)
    if rows is None or not len(rows.slip):
        raise LookupError("slips are known to explicit runs with friction alone")
    out = np.zeros(model.state["multipliers"].shape[1])
    compliance, force = _compliance(model, dt), model.state["contact_force"]
    for k in range(rows.count):
        entries = slice(rows.start[k], rows.start[k + 1])
        node = rows.node[entries]
        pushed = (rows.tangent_weight[entries] * compliance[node] * force[node]).sum()
        out[rows.slot[k]] += rows.slip[k] + float(pushed)
    return out


def _compliance(model: Model, dt: float) -> Floats:
    """Displacement (N, 2) [mm/N] per contact force within a step; 0 where held."""
    out = np.repeat(np.divide(dt**2, model.mass, out=np.zeros_like(model.mass), where=model.mass > 0.0), 2)
    out[model.prescribed.dof] = 0.0
    return np.asarray(out.reshape(-1, 2))
