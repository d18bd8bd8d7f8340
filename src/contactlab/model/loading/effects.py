"""Effects of a scene, bound to the arrays of a model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Effect, EffectView, Floats, Ints, Profile, RunWarning, State
from contactlab.errors import below
from contactlab.model.bodies.body import Body
from contactlab.model.loading.edge_sets import nodes_of
from contactlab.model.loading.load_profile import of_nodes
from contactlab.model.loading.node_profiles import tell_unresolved
from contactlab.model.loading.node_shares import shares_of
from contactlab.scene.reading import refused_later

if TYPE_CHECKING:
    from contactlab.errors import Where
    from contactlab.model.loading.loads import Load
    from contactlab.parts.registry import Registry
    from contactlab.scene.scene import Scene


def build_effects(
    made: Sequence[Effect],
    scene: Scene,
    registry: Registry,
    bodies: tuple[Body, ...],
    reference: Floats,
    masses: Callable[[], Floats],
    state: State,
    told: list[RunWarning],
) -> tuple[Load, ...]:
    """One call for each of the scene's effects; `masses` makes the nodal masses, which statics may do without."""
    mass = masses() if "velocity" in state or any(effect.needs_mass for effect in made) else np.zeros(0)
    displacement = state["displacement"]
    velocity = state["velocity"] if "velocity" in state else np.zeros_like(displacement)
    reference, mass, displacement, velocity = map(_read_only, (reference, mass, displacement, velocity))
    names = tuple(body.name for body in bodies)
    loads = []
    for number, effect in enumerate(made):
        where = scene.where(f"effects.{number}")
        nodes = partial(nodes_of, bodies, where=below(where, "on"))
        shares = partial(shares_of, bodies, reference, where=below(where, "on"))
        factors = partial(_factors, bodies, reference, registry, below(where, "profile"), told)
        view = EffectView(reference, mass, displacement, velocity, names, nodes, shares, factors)
        try:
            add = effect.bind(view)
        except ValueError as problem:
            raise refused_later(type(effect), "the effect is refused", str(problem), where) from problem
        if effect.memory:
            from contactlab.model.loading.remembering_effect import RememberingEffect

            add = RememberingEffect(effect, add, state, f"effects.{number}")
        loads.append(add)
    return tuple(loads)


def _factors(
    bodies: tuple[Body, ...],
    reference: Floats,
    registry: Registry,
    where: Where,
    told: list[RunWarning],
    profile: Profile,
    nodes: Ints,
) -> Floats:
    varying = of_nodes(profile, registry, where)
    at = varying.at(reference)
    tell_unresolved(varying, bodies, nodes, at, where, told)
    return varying.values(at[nodes])


def _read_only(array: Floats) -> Floats:
    view = array.view()
    view.flags.writeable = False
    return view
