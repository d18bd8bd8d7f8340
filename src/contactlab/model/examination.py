"""Who gave something that is no number: every part is given finite numbers, or is not to blame.

`examine_*` look at the arrays that a step left, in the order in which they come about, and raise WrongAnswer with part
and method. `Examined` is a model that does so at every crossing, for steps that are repeated to find out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from contactlab.api import Floats, GapConditions, Pieces, Solve
from contactlab.errors import SimulationFailure, WrongAnswer
from contactlab.kernels.checks import smallest_jacobian
from contactlab.model.bodies.body import Block, BodyForces

if TYPE_CHECKING:
    from contactlab.model.contact.explicit_system import ContactSystem
    from contactlab.model.contact.pair import ContactPair
    from contactlab.model.model import Model


def finite(*arrays: Floats) -> bool:
    """Whether all numbers are; sums of them tell, without an array of answers."""
    return all(bool(np.isfinite(array.sum())) or bool(np.isfinite(array).all()) for array in arrays)


def _refuse(part: Any, method: str, what: str, place: str = "") -> None:
    raise WrongAnswer(f"{type(part).__name__}: {method} gave {what} that is not finite{place}, from finite numbers")


# --- bodies -----------------------------------------------------------------------------------------


def examine_bodies(model: Model) -> None:
    """Element and material of every body at the last update; of folded cells no law has to know a stress."""
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
        _refuse(body.element, "its forces", "a nodal force", f" in body {body.name}")


def _examine_block(forces: BodyForces, block: Block, begin: int) -> bool:
    """Whether a point is folded over; raises WrongAnswer for others."""
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
                _refuse(part, method, what, f" in cell {begin + cell} of body {body.name}")
            whole[cell :: block.connectivity.shape[1]] = False
    return not bool(whole.all())


def _turned_over(forces: BodyForces, block: Block, cell: int) -> bool:
    """Whether a cell's map from its nodes has no area somewhere: an averaged gradient (F-bar) has no value there."""
    element = forces.body.element
    derivatives = np.ascontiguousarray(element.shape(element.quadrature().points).gradient)
    return not smallest_jacobian(forces.geometry, block.connectivity[:, cell : cell + 1], derivatives)[0] > 0.0


def examine_effects(model: Model, time: float) -> None:
    """Effects one by one, in the present state."""
    if not all(finite(model.state[name]) for name in ("displacement", "velocity") if name in model.state):
        return
    for number, effect in enumerate(model.loading.effects):
        own = np.zeros_like(model.reference)
        effect(time, own)
        if not finite(own):
            raise WrongAnswer(f"effects.{number} gave a force that is not finite, from finite numbers")


# --- contact ----------------------------------------------------------------------------------------


def examine_contact(contact: Any) -> None:
    """The algorithm of every pair at its last update, then the enforcement; None where there is no contact."""
    for pair in contact.pairs if contact is not None else ():
        examine_pair(pair)


def examine_pair(pair: ContactPair) -> None:
    """Raise WrongAnswer where what a contact algorithm gave last is no number."""
    pieces, found = getattr(pair, "pieces", None), getattr(pair, "found", None)
    if pieces is not None:
        _examine_pieces(pair, pieces, getattr(pair, "count", 0))
    elif found is not None:
        _examine_conditions(pair, found)


def _examine_pieces(pair: ContactPair, pieces: Pieces, count: int) -> None:
    covered = pieces.T[:count].sum()
    others = pieces.D[:count].sum() + pieces.M[:count].sum() + pieces.normal.sum()
    if (covered > 0.0 or not count) and np.isfinite(covered + others):
        return
    if not finite(*pair.at):
        return
    for name in ("D", "M", "T"):
        if not finite(getattr(pieces, name)[:count]):
            _refuse(pair.method, "pieces", f"an entry of {name}", f" in {pair.name}")
    if not finite(pieces.normal[pieces.multiplier[:count].ravel()]):
        _refuse(pair.method, "pieces", "a normal", f" in {pair.name}")
    if count and not covered > 0.0:
        raise WrongAnswer(
            f"{type(pair.method).__name__}: pieces gave {count} pieces in {pair.name} whose T sums up to "
            f"{covered:g}, needed: integrals over the covered length"
        )


def _examine_conditions(pair: ContactPair, found: GapConditions) -> None:
    for name in ("gap", "normal_weight", "tangent_weight", "measure"):
        if not finite(getattr(found, name)) and finite(*pair.at):
            _refuse(pair.method, "conditions", f"an entry of {name}", f" in {pair.name}")


# --- a step with all checks on ----------------------------------------------------------------------


class Examined:
    """A model whose parts are looked at whenever they have answered; everything else is the model's own."""

    def __init__(self, model: Model) -> None:
        self._model = model
        contact = cast("ContactSystem | None", model.contact)  # only explicit steps are repeated
        self.contact = None if contact is None else _ExaminedContact(model, contact)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._model, name)

    def external_force(self, time: float, out: Floats) -> bool:
        """Evaluate the loads one by one, and name the one whose answer is no number."""
        loaded = self._model.external_force(time, out)
        if loaded and not finite(out):
            examine_effects(self._model, time)
        return loaded

    def internal_force(self, dt: float) -> None:
        """Bodies, after what the integrator made of the forces on them."""
        self.refuse_state()
        self._model.internal_force(dt)
        examine_bodies(self._model)
        if not finite(self._model.state["internal_force"]):
            raise SimulationFailure("diverged", "a cell is folded over")  # what follows from it is no part's fault

    def refuse_state(self) -> None:
        """Raise WrongAnswer where the integrator made something else of finite forces."""
        for name in ("displacement", "velocity"):
            if name in self._model.state and not finite(self._model.state[name]):
                _refuse(self._model.integrator, "its step", f"a {name}")


class _ExaminedContact:
    def __init__(self, model: Model, contact: ContactSystem) -> None:
        self._model, self._contact = model, contact

    def __getattr__(self, name: str) -> Any:
        return getattr(self._contact, name)

    def solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        """Examine what the algorithms give, then solve as the enforcement does."""
        if not finite(predicted):
            _refuse(self._model.integrator, "its step", "a predicted position")
        done = self._contact.solve(predicted, current, compliance, force)
        examine_contact(self._contact)
        if not finite(force, self._contact.multipliers):
            _refuse(self._contact.enforcement, "solve", "a force")
        return done
