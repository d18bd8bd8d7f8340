"""Contacts: which parts and surfaces they join, what they need of each other, and their state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contactlab.api import (
    ContactAlgorithm,
    Enforcement,
    ExplicitEnforcement,
    Floats,
    FrictionLaw,
    Integrator,
    Ints,
    State,
    Surface,
)
from contactlab.errors import PartError, SceneError, below
from contactlab.mesh import surface_from_edges
from contactlab.model.body import Body
from contactlab.model.contact_system import ContactSystem
from contactlab.model.edge_sets import edge_set
from contactlab.model.surface_pair import SurfacePair


@dataclass(frozen=True)
class ContactPlan:
    """One contact before any array exists. `name` is "contacts.0"; `label` what the scene calls it."""

    name: str
    label: str
    algorithm: ContactAlgorithm
    slave: Surface
    master: Surface
    friction: FrictionLaw | None
    enforcement: Enforcement
    where: Any

    @property
    def slots(self) -> int:
        """Multipliers of the contact."""
        return self.algorithm.rows_per_node * len(self.slave.nodes)


def plan_contacts(
    scene: Any, registry: Any, bodies: tuple[Body, ...], integrator: Integrator
) -> tuple[ContactPlan, ...]:
    """Every contact of the scene with its parts made and checked."""
    return tuple(
        _plan(number, spec, scene.where(f"contacts.{number}"), registry, bodies, integrator)
        for number, spec in enumerate(scene.contacts)
    )


def _plan(
    number: int, spec: Any, where: Any, registry: Any, bodies: tuple[Body, ...], integrator: Integrator
) -> ContactPlan:
    slave_key, master_key = ("master", "slave") if spec.swap else ("slave", "master")
    _, slave = edge_set(bodies, getattr(spec, slave_key), below(where, slave_key))
    _, master = edge_set(bodies, getattr(spec, master_key), below(where, master_key))
    enforcement_spec = spec.enforcement or integrator.default_enforcement
    enforcement = registry.make("enforcement", enforcement_spec, below(where, "enforcement"))
    if not isinstance(enforcement, integrator.needs):
        raise PartError(
            f"the integrator cannot work with this enforcement: it needs one of kind {integrator.needs.__name__}",
            where=below(where, "enforcement"),
            got=enforcement_spec,
            allowed=f'"{integrator.default_enforcement}" (what is used when nothing is written)',
        )
    friction = registry.make("friction", spec.friction, below(where, "friction")) if spec.friction else None
    return ContactPlan(
        f"contacts.{number}",
        spec.name or f"contacts.{number}",
        registry.make("contact", spec.algorithm, below(where, "algorithm")),
        _surface(slave, below(where, slave_key)),
        _surface(master, below(where, master_key)),
        friction,
        enforcement,
        where,
    )


def _surface(edges: Ints, where: Any) -> Surface:
    try:
        return surface_from_edges(edges)
    except ValueError as problem:
        raise SceneError(f"not a contact surface: {problem}", where=where) from problem


def contact_shapes(plans: tuple[ContactPlan, ...], nodes: int) -> Mapping[str, tuple[int, ...]]:
    """State fields of the contacts; nothing tangential without friction."""
    if not plans:
        return {}
    rows = 2 if any(plan.friction is not None for plan in plans) else 1
    shapes: dict[str, tuple[int, ...]] = {"multipliers": (rows, sum(plan.slots for plan in plans))}
    shapes |= {"multipliers_before": shapes["multipliers"][1:], "contact_force": (nodes, 2)}
    for plan in plans:
        if plan.algorithm.memory_size:
            shapes[f"memory.{plan.name}"] = (plan.algorithm.memory_size, len(plan.slave.nodes))
    return shapes


def build_contact(
    plans: tuple[ContactPlan, ...], reference: Floats, fixed_dof: Ints, state: State
) -> Any:
    """The contact system that the enforcement works with, None where the scene declares no contact."""
    if not plans:
        return None
    enforcements = {plan.enforcement for plan in plans}
    if len(enforcements) > 1:
        raise SceneError(
            "all contacts of a scene share one enforcement",
            where=plans[-1].where,
            got=", ".join(sorted(type(e).__name__ for e in enforcements)),
            hint="write the same enforcement for every contact",
        )
    held = np.zeros(2 * len(reference), np.bool_)
    held[fixed_dof] = True
    immobile = held.reshape(-1, 2).all(axis=1)
    pairs, first = [], 0
    for plan in plans:
        pairs.append(
            SurfacePair(
                plan.name, plan.algorithm, plan.slave, plan.master, reference, first, plan.friction,
                immobile[plan.slave.nodes],
            )
        )  # fmt: skip
        first += plan.slots
    if isinstance(plans[0].enforcement, ExplicitEnforcement):
        return ContactSystem(tuple(pairs), plans[0].enforcement, state)
    from contactlab.model.implicit_contact import ImplicitContactSystem

    return ImplicitContactSystem(tuple(pairs), plans[0].enforcement, state)
