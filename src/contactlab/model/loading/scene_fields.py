"""Further inputs of laws besides strains and slips: places, times, sizes, and fields of the scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, get_args

import numpy as np

from contactlab.api import Floats, FrictionLaw, Ints, Material, NormalLaw
from contactlab.api.friction import FrictionNeed
from contactlab.api.material import MaterialNeed
from contactlab.api.normal_law import NormalNeed
from contactlab.errors import SceneError
from contactlab.kernels.size import jacobian_determinants
from contactlab.model.bodies.body import Body, BodyForces
from contactlab.model.loading.load_profile import of_nodes
from contactlab.model.loading.ramps import RampTime, course_of
from contactlab.scene.scene import Scene

InTime = Callable[[float], Floats | float]
"""Values at some points at a time [s]."""


_NEEDS = {FrictionLaw: FrictionNeed, NormalLaw: NormalNeed, Material: MaterialNeed}


def fields_needed(part: Any) -> list[str]:
    """Return names in the `needs` of a law, material or effect (class or instance) that are fields of the scene."""
    kind = part if isinstance(part, type) else type(part)
    known = get_args(next((needs for base, needs in _NEEDS.items() if issubclass(kind, base)), None))
    return [name for name in part.needs if name not in known]


class SceneFields:
    """The fields of a scene, and the inputs that laws need of them."""

    def __init__(self, scene: Scene, ramps: RampTime) -> None:
        self.scene, self.ramps = scene, ramps

    def at(self, name: str, points: Floats, key: str) -> InTime:
        """Return values (k,) in time of a field at undeformed points (k, 2) [mm], needed by the component at `key`."""
        scene, fields = self.scene, self.scene.fields
        if name not in fields:
            raise SceneError(
                "this part needs a field that the scene does not have", where=scene.where(key), got=name,
                allowed=", ".join(fields) or "none",
                hint=f"write [fields.{name}] with a value",
            )  # fmt: skip
        spec, registry = fields[name], scene.registry
        course = course_of(spec.value, registry, scene.where(f"fields.{name}.value"))
        ramp, factors = course.bind(self.ramps), np.full(len(points), course.to)
        if spec.profile is not None:
            profile = of_nodes(spec.profile, registry, scene.where(f"fields.{name}.profile"))
            factors *= profile.values(profile.at(points))
        return lambda time: ramp(time) * factors

    def filling(self, forces: BodyForces, reference: Floats) -> Callable[[float], None]:
        """Return a function of time [s] that fills the rows of history which a body's law needs."""
        law, key = forces.body.material, f"materials.{self.scene.bodies[forces.body.name].material}"
        rows: list[tuple[Floats, InTime]] = []
        for block in forces.blocks:
            points, sizes = _places(forces.body, block.connectivity, reference)
            steady = {"x": points[:, 0], "y": points[:, 1], "cell_size": sizes}
            for history in (block.history, block.new_history):
                for name, row in zip(law.history_names, history, strict=True):
                    if name in law.history_names[: law.own_history()]:
                        continue
                    if name in steady:
                        row[:] = steady[name]
                    else:
                        rows.append((row, float if name == "time" else self.at(name, points, key)))

        def fill(time: float) -> None:
            for row, value in rows:
                row[:] = value(time)

        return fill

    def give(self, keeper: Any, points: Floats, key: str) -> None:
        """Pass the fields that a law needs, at points (k, 2) [mm], to the keeper of its numbers."""
        keeper.fields = {name: self.at(name, points, key) for name in fields_needed(keeper.law)}


def _places(body: Body, connectivity: Ints, reference: Floats) -> tuple[Floats, Floats]:
    """Return undeformed places (P, 2) [mm] of the points of a block, and the root (P,) of the area of their cells."""
    rule = body.element.quadrature()
    value = body.element.shape(rule.points).value
    determinants = np.empty((len(rule.points), connectivity.shape[1]))
    jacobian_determinants(reference, connectivity, body.shape_gradients(rule.points), determinants)
    points = np.einsum("qa,abi->qbi", value, reference[connectivity]).reshape(-1, 2)
    return points, np.tile(np.sqrt(rule.weights @ determinants), len(rule.points))
