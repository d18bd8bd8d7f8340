"""Bodies and their masses, built from the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Element, Floats, Material, Mesh, MeshSource
from contactlab.meshing.checks import check_mesh
from contactlab.meshing.mesh import moved, nodal_measure
from contactlab.meshing.slits import Pairs, check_closed
from contactlab.model.bodies.body import Body
from contactlab.model.bodies.checked_parts import refuse_writing_to_inputs, refuse_wrong_speeds, refuse_wrong_tables
from contactlab.model.loading.edge_sets import with_parts
from contactlab.scene.checks import split_target
from contactlab.scene.reading import refused_later

if TYPE_CHECKING:
    from contactlab.errors import Where
    from contactlab.model.loading.rigid import RigidSurface
    from contactlab.parts.registry import Registry
    from contactlab.scene.keys import Body as BodySpec
    from contactlab.scene.scene import Scene


def build_bodies(scene: Scene, registry: Registry) -> tuple[Body, ...]:
    """Build all bodies in global node numbers, in scene order."""
    materials = {
        name: registry.make("material", spec, scene.where(f"materials.{name}"))
        for name, spec in scene.materials.items()
    }
    for name, material in materials.items():
        refuse_wrong_speeds(material, scene.where(f"materials.{name}"))
        refuse_writing_to_inputs(material)
    joined = _joined_sets(scene)
    bodies: list[Body] = []
    first = 0
    for name, spec in scene.bodies.items():
        body = _body(scene, registry, name, spec, materials[spec.material], first, joined.get(name, ()))
        bodies.append(body)
        first += body.count
    return tuple(bodies)


def _body(
    scene: Scene, registry: Registry, name: str, spec: BodySpec, material: Material, first: int, joined: Pairs
) -> Body:
    element: Element = registry.make("element", spec.element, scene.where(f"bodies.{name}.element"))
    refuse_wrong_tables(element)
    where = scene.where(f"bodies.{name}.mesh")
    source: MeshSource = registry.make("mesh", spec.mesh, where)
    mesh = moved(_meshed(source, element, scene.level, where), spec.rotate, spec.shift)
    mesh = with_parts(mesh, spec.sets, scene.where(f"bodies.{name}.sets"))
    check_mesh(mesh, element, where)
    check_closed(mesh, element, joined, where)
    return Body(name, element, material, mesh, first, len(mesh.nodes), (mesh.cells + first).astype(np.int32))


def _joined_sets(scene: Scene) -> dict[str, list[tuple[list[str], list[str]]]]:
    """Return edge sets of one body that are slave and master of one contact, by body."""
    joined: dict[str, list[tuple[list[str], list[str]]]] = {}
    for contact in scene.contacts:
        slave, master = ([split_target(target) for target in side] for side in contact.targets)
        for body in dict.fromkeys(name for name, _ in slave if name in dict(master)):
            own = tuple([edges for name, edges in side if name == body] for side in (slave, master))
            joined.setdefault(body, []).append((own[0], own[1]))
    return joined


def _meshed(source: MeshSource, element: Element, level: int, where: Where) -> Mesh:
    try:
        return source.mesh(element, level)
    except ValueError as problem:
        raise refused_later(type(source), "no mesh can be made", str(problem), where) from problem


def masses_of(bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...]) -> Floats:
    """Return lumped masses (N,) [t], zero for nodes of rigid surfaces."""
    own = [body.material.density * nodal_measure(body.mesh, body.element) for body in bodies]
    return np.concatenate([*own, *(np.zeros(surface.count) for surface in rigid)])
