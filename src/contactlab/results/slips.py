"""Tangential motion of contacts in the last step."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from contactlab.api import Floats
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.contact.explicit_system import ContactSystem


def slips_of(model: Model) -> Floats:
    """Slip (k,) [mm] of all multipliers: prediction of the rows, plus the change by the forces of the step.

    Raises LookupError if the model's contact has no rows with slips.
    """
    rows = getattr(model.contact, "rows", None)
    if rows is None or not len(rows.slip):
        raise LookupError("slips exist only in explicit runs with friction")
    from contactlab.contact.explicit_system import slips

    contact = cast("ContactSystem", model.contact)
    return slips(rows, model.state["multipliers"].shape[1], contact.compliance, model.state["contact_force"])[0]
