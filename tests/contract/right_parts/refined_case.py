# kind case cls Refined
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import Case, Job
from contactlab.api.case import error, within


@dataclass(frozen=True)
class Refined(Case):
    """Two unlike layers pressed by a displacement, on one mesh and on one twice as fine.

    stiff  modulus of the lower layer over that of the upper one [-]
    """

    stiff: float = 3.0
    title: ClassVar[str] = "unlike layers, two meshes"
    source: ClassVar[str] = "bars in series"
    family: ClassVar[str] = "patch"
    axes: ClassVar[dict] = {"stiff": (3.0, 1.0, 10.0)}
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2")

    def plan(self, setup, done):
        if "coarse" not in done:
            return [self._job("coarse", setup, 1)]
        return [] if "fine" in done else [self._job("fine", setup, 2)]

    def _job(self, name, setup, factor):
        n = 3 * setup.level * factor

        def block(y, cells, law):
            mesh = {"use": "rectangle", "x": [0.0, 2.0], "y": y, "cells": [cells, max(1, cells // 2)]}
            return {"element": setup.element, "material": law, "mesh": mesh}

        scene = {
            "integrator": setup.integrator,
            "materials": {
                "soft": {"use": "linear-elastic", "young": 100.0, "poisson": 0.0, "density": 1e-9},
                "hard": {"use": "linear-elastic", "young": 100.0 * self.stiff, "poisson": 0.0, "density": 1e-9},
            },
            "bodies": {"upper": block([0.0, 1.0], n, "soft"), "lower": block([-1.0, 0.0], n + 2, "hard")},
            "contacts": [
                {"slave": "upper.bottom", "master": "lower.top", "algorithm": setup.algorithm, "swap": setup.swap}
            ],
            "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.top", "uy": -0.01, "ux": 0.0}],
        }
        return Job(name, scene)

    def measures(self, setup):
        why = "bars in series: the pressure is even"
        return [error("force", 1e-3, why), within("ratio of the meshes", 0.999, 1.001, why)]

    def evaluate(self, setup, done):
        exact = 0.01 / (1.0 / 100.0 + 1.0 / (100.0 * self.stiff)) * 2.0
        force = {name: float(record.reaction("lower.bottom")[1]) for name, record in done.items() if record.finished}
        found = {}
        if "coarse" in force:
            found["force"] = force["coarse"] / exact - 1.0
        if len(force) == 2:
            found["ratio of the meshes"] = force["fine"] / force["coarse"]
        return found
