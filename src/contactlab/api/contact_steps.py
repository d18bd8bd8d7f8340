"""The contact record of every step: one number per slave node and quantity."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api.frame import ContactLayout

__all__ = ["NO_SEGMENT", "contact_record"]

NO_SEGMENT = 65535
"""`segment` of a node that faces no master segment."""


def contact_record(contact: ContactLayout) -> np.dtype[Any]:
    """Return the type of a row of the contact record, for m slave nodes in the order of `ContactLayout.slave_nodes`.

    step, time  number of the step and the time at its end [s]
    gap         (m,) [mm] at the end of the step, NaN without overlap
    pressure    (m,) the multiplier Lambda [MPa], as in `ContactCurve`
    state       (m,) 0 open, 1 stick, 2 slip
    segment     (m,) number of the master segment with most of the weight in the node's constraint, counted along
                `ContactLayout.master_segments`; `NO_SEGMENT` without one or if its number exceeds this value
    shear       (m,) [MPa], only with friction
    slip        (m,) tangential motion in this step [mm], only with friction

    In single precision this is 19 bytes per node and step with friction and 11 without.
    """
    m, own = len(contact.slave_nodes), "gap pressure shear slip" if contact.friction else "gap pressure"
    fields: list[Any] = [("step", "i8"), ("time", "f8")]
    fields += [(name, "f4", (m,)) for name in own.split()]
    return np.dtype([*fields, ("state", "u1", (m,)), ("segment", "u2", (m,))])
