"""Which part gave what is no number: the last steps are repeated with every answer looked at."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats
from contactlab.errors import WrongAnswer

if TYPE_CHECKING:
    from contactlab.model.model import Model
    from contactlab.run.run import Run

MOST = 52  # steps that are repeated: from one look at the model to the next, and what a fault takes to be seen


class KeptState:
    """A copy of the state of an explicit run, from which its steps come out again to the last bit."""

    def __init__(self) -> None:
        self.fields: dict[str, Floats] = {}
        self.near: list[tuple[Floats, Floats] | None] = []

    def take(self, model: Model) -> None:
        """Copy the present state; into the same arrays every time."""
        for name, field in model.state.fields.items():
            if name in self.fields:
                np.copyto(self.fields[name], field)
            else:
                self.fields[name] = field.copy()
        pairs = model.contact.pairs if model.contact is not None else ()
        self.near = [None if pair.near is None else (pair.near.slave, pair.near.master) for pair in pairs]

    def bring_back(self, model: Model) -> None:
        """Bring back the state, positions and near lists as they were."""
        for name, field in self.fields.items():
            np.copyto(model.state[name], field)
        np.add(model.reference, model.state["displacement"], out=model.position)
        for pair, near in zip(model.contact.pairs if model.contact is not None else (), self.near, strict=True):
            if near is not None:
                pair.find_near(*near)


def wrong_answer(run: Run) -> str:
    """Step, part and method of the first answer that is not finite since the state that was kept; empty if none is.

    The run is over: its state afterwards is that of the step at fault, or as it was.
    """
    if not run.kept.fields:
        return ""
    from contactlab.model.examination import Examined

    model = run.model
    run.kept.bring_back(model)
    step = model.state.step
    advance = model.bound_integrator(Examined(model)).step
    for number in range(step + 1, step + MOST + 1):
        try:
            advance(run.schedule.dt)
        except WrongAnswer as found:
            return f"step {number}: {found}"
        except Exception:
            return ""  # no part's answer is to blame: what stopped the run in the first place is told
    return ""
