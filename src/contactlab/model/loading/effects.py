"""Effects of a scene, bound to the arrays of a model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from contactlab.api import Effect, EffectView, Floats, Ints, Profile, RunWarning, State
from contactlab.errors import SceneError, Where, WrongAnswer, below
from contactlab.meshing.mesh import nodal_measure
from contactlab.model.bodies.body import Body
from contactlab.model.loading.edge_integrals import Edges, uniform
from contactlab.model.loading.edge_sets import edge_set, nodes_of
from contactlab.model.loading.load_profile import of_nodes
from contactlab.model.loading.node_profiles import tell_unresolved
from contactlab.model.loading.ramps import RampTime
from contactlab.parts.registry import Registry
from contactlab.parts.remembered import remember
from contactlab.scene.reading import refused_later
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
    ramps: RampTime,
) -> tuple[Callable[[float, Floats], None], ...]:
    """Return a call for each of the scene's effects; `masses` makes the nodal masses, optional in statics."""
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
        fields = _fields(effect, scene, ramps, reference, f"effects.{number}") if effect.needs else {}
        view = EffectView(reference, mass, displacement, velocity, names, nodes, shares, factors, fields)
        try:
            add = effect.bind(view)
        except ValueError as problem:
            raise refused_later(type(effect), "the effect is refused", str(problem), where) from problem
        if effect.memory:
            add = RememberingEffect(effect, add, state, f"effects.{number}")
        loads.append(add)
    return tuple(loads)


def _fields(effect: Effect, scene: Scene, ramps: RampTime, reference: Floats, key: str) -> dict[str, Any]:
    from contactlab.model.loading.scene_fields import SceneFields

    fields = SceneFields(scene, ramps)
    return {name: fields.at(name, reference, key) for name in effect.needs}


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


class RememberingEffect:
    """Adds forces that depend on memory and the time since; called like effects without memory.

    rows  memory (N,) of each node by name, in the state
    """

    def __init__(self, effect: Effect, add: Callable[..., Any], state: State, field: str) -> None:
        self.effect, self.add, self.state = effect, add, state
        self.rows = dict(zip(effect.memory, state[field], strict=True))
        self.seen = {name: row.view() for name, row in self.rows.items()}
        for row in self.seen.values():
            row.flags.writeable = False
        self.spare = np.zeros_like(state["displacement"])
        remember(effect, "start", effect.start(), self.rows)

    def __call__(self, time: float, force: Floats) -> None:
        """Add the forces (N, 2) [N] at `time` [s]."""
        self.add(time, force, time - self.state.time, self.seen)

    def accept(self, time: float, dt: float) -> None:
        """Update memory after an accepted step of `dt` [s] that ends at `time` [s], before the clock moves."""
        found = self.add(time, self.spare, dt, self.seen)
        if not isinstance(found, dict):
            kind = type(self.effect).__name__
            raise WrongAnswer(f"{kind}: the function of bind gave {type(found).__name__}, needed: a dict of memory")
        remember(self.effect, "the function of bind", {name: np.copy(row) for name, row in found.items()}, self.rows)


def shares_of(bodies: tuple[Body, ...], reference: Floats, names: Sequence[str], where: Where) -> tuple[Ints, Floats]:
    """Return nodes (k,) of bodies or of edge sets, and their share (k,) of the whole area or length.

    Areas come from the lumped mass, lengths from the integral of the node's trace function. A body or an edge
    named twice counts once. Raises SceneError for bodies together with edge sets.
    """
    measure = np.zeros(len(reference))
    whole = [body for body in bodies if body.name in names]
    for body in whole:
        measure[body.first : body.first + body.count] = nodal_measure(body.mesh, body.element)
    if not whole:
        found = [edge_set(bodies, name, where) for name in names]
        for body in bodies:
            own = [edges for other, edges in found if other is body]
            if own:
                sides = np.unique(np.concatenate(own), axis=0)
                along, points = Edges(body.element, sides, reference), uniform(len(sides))
                shape, _ = along.trace(points)
                length = points.weight * along.speed(points.edge, points.at)
                np.add.at(measure, sides[points.edge], length[:, None] * shape)
    elif other := [name for name in names if name not in {body.name for body in whole}]:
        edge_set(bodies, other[0], where)
        raise SceneError(
            "bodies and edge sets in one list", where=where, got=list(names),
            allowed="bodies, which share by area, or edge sets, which share by length", hint="write a table for each",
        )  # fmt: skip
    nodes = np.flatnonzero(measure).astype(np.int32)
    return nodes, measure[nodes] / measure.sum()
