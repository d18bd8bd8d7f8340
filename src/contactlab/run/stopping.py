"""Why a run is stopped, in words: the step, the place, and what to try."""

from __future__ import annotations

from typing import NoReturn

from contactlab.errors import SimulationFailure
from contactlab.model.model import Model


def stop(model: Model, what: str, hint: str, status: str = "diverged") -> NoReturn:
    """Raise SimulationFailure(status) with the step, `what` was found, and a `hint` what to try."""
    raise SimulationFailure(status, f"step {model.state.step}: {what}; {hint}")


def node_name(model: Model, node: int) -> str:
    """A node of the model as its number within its body or rigid surface."""
    for body in model.bodies:
        if body.first <= node < body.first + body.count:
            return f"node {node - body.first} of body {body.name}"
    surface = next(s for s in model.loading.supports if node in s.nodes)
    return f"node {node - surface.nodes[0]} of {surface.on}"


def shorter_steps(explicit: bool, step: float | None) -> str:
    """What makes the steps of a run shorter, in words; `step` [s] is the length that its scene fixes, if it does."""
    if step is not None:
        return "a smaller time.step"
    return "a smaller time.fraction" if explicit else "more integrator.steps"
