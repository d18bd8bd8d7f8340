"""Messages about why a run is stopped: the step, the place, and what to try."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from contactlab.errors import SimulationFailure
from contactlab.model.model import Model

SHOCK = 0.1  # of the speed of sound: strains of that size in one step


def stop(model: Model, what: str, hint: str, status: str = "diverged") -> NoReturn:
    """Raise SimulationFailure(status) with the step, `what` was found, and a `hint` what to try."""
    raise SimulationFailure(status, f"step {model.state.step}: {what}; {sudden_motion(model) or hint}")


def sudden_motion(model: Model) -> str:
    """Return advice against a displacement that jumps in the first explicit step; "" if there is none."""
    if not model.explicit or not len(model.prescribed.dof):
        return ""
    prescribed = model.prescribed
    jump = prescribed.scale * prescribed.values(0.0)[prescribed.ramp]
    worst = int(np.argmax(np.abs(jump)))
    sound = max(body.material.wave_speeds()[0] for body in model.bodies)
    travelled = sound * float(model.state["clock"][2])  # by a wave in a step
    if abs(jump[worst]) <= SHOCK * travelled:
        return ""
    node, component = divmod(int(prescribed.dof[worst]), 2)
    on = next(support.on for support in model.loading.supports if node in support.nodes)
    key = ("ux", "uy")[component]
    return (
        f"{on} is displaced by {jump[worst]:.4g} in the first step, in which a wave travels {travelled:.2g}: try a "
        f'ramp, {key} = {{ ramp = "parabola", to = {jump[worst]:.4g} }}'
    )


def node_name(model: Model, node: int) -> str:
    """A node of the model as its number within its body or rigid surface."""
    for body in model.bodies:
        if body.first <= node < body.first + body.count:
            return f"node {node - body.first} of body {body.name}"
    surface = next(s for s in model.loading.supports if node in s.nodes)
    return f"node {node - surface.nodes[0]} of {surface.on}"


def shorter_steps(explicit: bool, step: float | None) -> str:
    """Return advice that makes steps shorter; `step` [s] is the length that the scene fixes, if it does."""
    if step is not None:
        return "a smaller time.step"
    return "a smaller time.fraction" if explicit else "more integrator.steps"
