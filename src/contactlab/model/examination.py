"""Search for the source of NaN: every plugin component gets finite numbers, or is not to blame.

`examine_*` check the arrays of a step, in the order of their computation, and raise WrongAnswer with component
and method. `Examined` is a model that does so at every call, for steps that are repeated to find the source.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Floats
from contactlab.contact.examination import finite, refuse
from contactlab.errors import SimulationFailure, WrongAnswer
from contactlab.kernels.checks import smallest_jacobian
from contactlab.model.bodies.body import Block, BodyForces
from contactlab.model.model import ExplicitModel, Model

# --- bodies -----------------------------------------------------------------------------------------


def examine_bodies(model: Model) -> None:
    """Check element and material of every body at the last update; at folded points no law needs a stress."""
    if not finite(model.state["displacement"]):
        return
    folded = False
    for forces in model.forces:
        begin = 0
        for block in forces.current():
            folded |= _examine_block(forces, block, begin)
            begin += block.connectivity.shape[1]
    force = model.state["internal_force"]
    if not folded and not finite(force):
        body = next(f.body for f in model.forces if not finite(force[f.body.first : f.body.first + f.body.count]))
        refuse(body.element, "its forces", "a nodal force", f" in body {body.name}")


def _examine_block(forces: BodyForces, block: Block, begin: int) -> bool:
    """Return whether a point is folded over; raise WrongAnswer for others."""
    body, g = forces.body, block.gradient
    whole = np.ones(g.shape[1], np.bool_)
    if body.material.kinematics == "finite":
        whole = ~(g[0] * g[3] - g[1] * g[2] <= 0.0)
    for part, method, what, values in (
        (body.element, "its kernels", "a displacement gradient", block.gradient),
        (body.material, "stress", "a stress", block.stress),
        (body.material, "stress", "a history", block.new_history),
    ):
        if finite(values):
            continue
        for cell in np.flatnonzero(whole & ~np.isfinite(values).all(axis=0)) % block.connectivity.shape[1]:
            if not _turned_over(forces, block, int(cell)):
                refuse(part, method, what, f" in cell {begin + cell} of body {body.name}")
            whole[cell :: block.connectivity.shape[1]] = False
    return not bool(whole.all())


def _turned_over(forces: BodyForces, block: Block, cell: int) -> bool:
    """Return whether a cell's map has no area somewhere: an averaged gradient (F-bar) has no value there."""
    element = forces.body.element
    derivatives = np.ascontiguousarray(element.shape(element.quadrature().points).gradient)
    return not smallest_jacobian(forces.geometry, block.connectivity[:, cell : cell + 1], derivatives)[0] > 0.0


def examine_effects(model: Model, time: float) -> None:
    """Check effects one by one, in the present state."""
    if not all(finite(model.state[name]) for name in ("displacement", "velocity") if name in model.state):
        return
    for number, effect in enumerate(model.loading.effects):
        own = np.zeros_like(model.reference)
        effect(time, own)
        if not finite(own):
            raise WrongAnswer(f"effects.{number} gave a force that is not finite, from finite numbers")


# --- a step with all checks on ----------------------------------------------------------------------


class Examined:
    """A model whose components are checked after every call; everything else belongs to the model."""

    def __init__(self, model: Model) -> None:
        self._model, self.contact = model, None
        if model.contact is not None:
            from contactlab.contact.examined import ExaminedContact

            assert isinstance(model, ExplicitModel)  # only explicit steps are repeated
            self.contact = ExaminedContact(model.contact, model.integrator)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._model, name)

    def external_force(self, time: float, out: Floats) -> bool:
        """Evaluate the loads one by one, and name the first load with a result that is not finite."""
        loaded = self._model.external_force(time, out)
        if loaded and not finite(out):
            examine_effects(self._model, time)
        return loaded

    def internal_force(self, dt: float) -> None:
        """Check bodies, after the integrator's use of their forces."""
        self.refuse_state()
        self._model.internal_force(dt)
        examine_bodies(self._model)
        if not finite(self._model.state["internal_force"]):
            raise SimulationFailure("diverged", "a cell is folded over")  # its consequences are no plugin's fault

    def refuse_state(self) -> None:
        """Raise WrongAnswer if the integrator made values that are not finite from finite forces."""
        for name in ("displacement", "velocity"):
            if name in self._model.state and not finite(self._model.state[name]):
                refuse(self._model.integrator, "its step", f"a {name}")
