"""Bodies and their masses, built from the scene; elements and materials are checked before kernels use them."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Element, Floats, Material, Mesh, MeshSource
from contactlab.api.formulas import formulas_of
from contactlab.errors import SceneError, Where, WrongAnswer
from contactlab.meshing.checks import check_mesh
from contactlab.meshing.mesh import moved, nodal_measure
from contactlab.meshing.slits import Pairs, check_closed
from contactlab.model.bodies.body import Body, RigidSurface
from contactlab.model.loading.edge_sets import with_parts
from contactlab.parts.registry import Registry
from contactlab.scene.checks import split_target
from contactlab.scene.keys import Body as BodySpec
from contactlab.scene.reading import refused_later
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


def refuse_wrong_tables(element: Element) -> None:
    """Raise WrongAnswer if a table of the element has the wrong form."""
    nodes, sides = np.shape(element.nodes), {len(edge) for edge in element.edges}
    if len(nodes) != 2 or nodes[1] != 2 or len(sides) != 1 or len(element.edges) != 4:
        _refuse(element, "nodes, edges", f"{nodes} and {len(element.edges)} sides", "nodes (a, 2), and 4 sides alike")
    rule, a, b = element.quadrature(), nodes[0], sides.pop()
    points, weights = np.shape(rule.points), np.shape(rule.weights)
    if len(points) != 2 or points[1] != 2 or weights != points[:1]:
        _refuse(element, "quadrature", f"points {points}, weights {weights}", "points (q, 2), weights (q,)")
    value, gradient = element.shape(rule.points)
    got, needed = (np.shape(value), np.shape(gradient)), ((points[0], a), (points[0], a, 2))
    if got != needed:
        _refuse(element, "shape", f"{got[0]} and {got[1]}", f"{needed[0]} and {needed[1]} for {points[0]} points")
    trace = [np.shape(table) for table in element.edge_shape(np.array([-0.5, 0.0, 0.5]))]
    if trace != [(3, b), (3, b)]:
        _refuse(element, "edge_shape", " and ".join(map(str, trace)), f"{(3, b)} twice for 3 points")


def refuse_wrong_speeds(material: Material, where: Where) -> None:
    """Raise WrongAnswer if a law does not give two speeds that can set a step, SceneError if these overflow."""
    speeds: Any = material.wave_speeds()
    if np.shape(speeds) == (2,) and max(speeds) == np.inf:
        raise SceneError(
            "waves in this material have no speed that is a number",
            where=where,
            got=f"{speeds[0]:.3g} and {speeds[1]:.3g} mm/s",
            allowed="a stiffness and a density whose quotient is a number",
        )
    if np.shape(speeds) != (2,) or not all(np.isfinite(speeds)) or not speeds[0] > speeds[1] >= 0.0:
        _refuse(material, "wave_speeds", str(speeds), "a dilatational and a smaller shear speed, finite")


def refuse_writing_to_inputs(material: Material) -> None:
    """Raise WrongAnswer if a law writes to its gradient or history arguments.

    Runs pass their own arrays: the stress would silently belong to another deformation. Laws
    by formulas cannot write.
    """
    if "stress" in formulas_of(type(material)):
        return
    rest = np.array([1.0, 0.0, 0.0, 1.0]) if material.kinematics == "finite" else np.zeros(4)
    gradient = rest[:, None] + 1e-6 * np.array([[1.0, -2.0], [3.0, 1.0], [-1.0, 2.0], [2.0, 1.0]])
    history = np.zeros((material.history_size, 2))
    before = gradient.copy()
    material.stress(gradient, history, 0.0, np.zeros((4, 2)), np.zeros_like(history))
    if not np.array_equal(gradient, before) or history.any():
        what = "history" if history.any() else "gradient"
        _refuse(material, "stress", f"other values to `{what}`, which it may only read", "a copy to work on")


def _refuse(part: object, method: str, got: str, needed: str) -> None:
    raise WrongAnswer(f"{type(part).__name__}: {method} gave {got}, needed: {needed}")
