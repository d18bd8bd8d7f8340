"""All data that a model carries from one step to the next, for a restart that is exact to the last bit.

The state comes first: memory of plugin components must live there. The rest is kept by the core in addition to
the state: stresses and gradients of the last update (they cannot be computed again without
stepping the history twice), the positions of the near lists, and the references of
the stable step.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from contactlab.api import Floats
from contactlab.model.model import ExplicitModel, Model


def model_memory(model: Model) -> dict[str, Floats]:
    """Return the arrays by name; shapes are constant.

    These are the model's own, except gradients and stresses that blocks share: these are recomputed, so that a
    stored memory shows the stress at every point.
    """
    memory = {f"state.{name}": field for name, field in model.state.fields.items()}
    if model.increment is not None:
        memory["increment"] = model.increment
    for forces in model.forces:
        for number, block in enumerate(forces.current()):
            gradient, stress = block.gradient, block.stress
            memory[f"stress.{forces.body.name}.{number}"] = stress.copy() if forces.shares_stress else stress
            memory[f"gradient.{forces.body.name}.{number}"] = gradient.copy() if forces.shares_gradient else gradient
    for limit in model.step_limits:
        memory[f"frequency.{limit.body.name}"] = limit.frequency
        memory[f"cell_size.{limit.body.name}"] = limit.before
    for pair in model.contact.passes if model.contact is not None else ():
        if pair.near is not None:
            memory |= {f"near.{pair.name}.slave": pair.near.slave, f"near.{pair.name}.master": pair.near.master}
    return memory


def restore_model(model: Model, memory: Mapping[str, Floats]) -> None:
    """Restore the model to the time of `model_memory`. The shapes must belong to this model."""
    for name, array in model_memory(model).items():
        if not name.startswith("near."):
            array[...] = memory[name]
    np.add(model.reference, model.state["displacement"], out=model.position)
    if isinstance(model, ExplicitModel):
        model.moved_back()
    for forces in model.forces:
        forces.trial_history[:] = forces.history  # as they are after an accepted step
    for pair in model.contact.passes if model.contact is not None else ():
        if pair.near is not None:
            pair.find_near(memory[f"near.{pair.name}.slave"], memory[f"near.{pair.name}.master"])
    model.make_constraints()
