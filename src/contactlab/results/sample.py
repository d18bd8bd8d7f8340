"""A model looked at: reactions, energies and contacts at one instant."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from contactlab.api import Floats
from contactlab.model.model import Model
from contactlab.results.energies import energies

if TYPE_CHECKING:
    from contactlab.results.contact_report import ContactReport


@dataclass(frozen=True)
class Sample:
    """Data of `history.csv` and of the contact curves at an instant; no fields.

    prescribed: mean displacement of each support [mm]; reactions: force (2,) [N] of each support on
    its body; contacts by "contacts.0"; sweeps: mean per step since the last sample; share: of the loading (statics) or
    of time that is done, 0 to 1; step_error: of the step that ended here over its tolerance, if steps follow it
    """

    number: int
    step: int
    time: float
    prescribed: dict[str, Floats]
    reactions: dict[str, Floats]
    energies: dict[str, float]
    contacts: dict[str, ContactReport]
    sweeps: float
    share: float
    step_error: float | None = None

    def scalars(self) -> dict[str, float]:
        """The scalars of this instant: one row of `history.csv`."""
        row: dict[str, float] = {"step": self.step, "time": self.time}
        for on, value in self.prescribed.items():
            row |= {f"{on}.ux": float(value[0]), f"{on}.uy": float(value[1])}
        for on, force in self.reactions.items():
            row |= {f"{on}.fx": float(force[0]), f"{on}.fy": float(force[1])}
        row |= {f"energy.{name}": value for name, value in self.energies.items()}
        for name, contact in self.contacts.items():
            row |= {
                f"{name}.fx": float(contact.resultant[0]),
                f"{name}.fy": float(contact.resultant[1]),
                f"{name}.max_pressure": float(contact.curve.pressure.max(initial=0.0)),
                f"{name}.max_penetration": contact.max_penetration,
                f"{name}.active": contact.active,
                f"{name}.sticking": contact.sticking,
            }
        row |= {"step_error": self.step_error} if self.step_error is not None else {}
        return row | {"sweeps": self.sweeps, "share": self.share}


def take_sample(model: Model, number: int, sweeps: float, share: float = math.nan) -> Sample:
    """The sample of the model's present state, which does not change by it."""
    state, displacement = model.state, model.state["displacement"]
    return Sample(
        number=number,
        step=state.step,
        time=state.time,
        prescribed={s.on: displacement[s.nodes].mean(axis=0) for s in model.loading.supports},
        reactions=model.reactions(),
        energies=energies(model),
        contacts=_contacts(model),
        sweeps=sweeps,
        share=share,
        step_error=float(state["step_error"][0]) if "step_error" in state else None,
    )


def _contacts(model: Model) -> dict[str, ContactReport]:
    if model.contact is None:
        return {}
    from contactlab.results.contact_report import report_contact

    pairs, state = model.contact.pairs, model.state
    return {pair.name: report_contact(pair, state, model.reference, model.position) for pair in pairs}
