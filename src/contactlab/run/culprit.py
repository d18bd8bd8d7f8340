"""Which part gave what is no number: the last steps are repeated with every answer looked at."""

from __future__ import annotations

from typing import TYPE_CHECKING

from contactlab.errors import WrongAnswer

if TYPE_CHECKING:
    from contactlab.run.run import Run

MOST = 52  # steps that are repeated: from one look at the model to the next, and what a fault takes to be seen


def wrong_answer(run: Run) -> str:
    """Step, part and method of the first answer that is not finite since the state that was kept; empty if none is.

    The run is over: its state afterwards is that of the step at fault, or as it was.
    """
    kept = run.kept.newest
    if kept is None:
        return ""
    from contactlab.model.examination import Examined

    model = run.model
    kept.bring_back(model)
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
