# kind reference cls Punch
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import ReferenceSolution, Scalar, Solution

SCENE = "cosine-loaded"


@dataclass(frozen=True)
class Punch(ReferenceSolution):
    """Even blocks of one width under a load 1 + share cos, by a series of its length: the even part carries all."""

    title: ClassVar[str] = "two blocks, load of a wave"
    origin: ClassVar[str] = "Fourier series: every wave decays as (1 + k h) exp(-k h) over a height h"

    def mismatch(self, scene):
        try:
            if scene.get("name") != SCENE:
                return f"the scene is {scene.get('name')!r}, the reference is for {SCENE!r}"
            if len(scene["loads"]) != 1:
                return "there is not one load"
            return "" if all(law["poisson"] == 0.0 for law in scene["materials"].values()) else "a body bulges"
        except (KeyError, TypeError, AttributeError, ValueError) as error:
            return f"no scene of two blocks: {error}"

    def solution(self, scene):
        load = scene["loads"][0]["pressure"]
        mean = float(load["to"] if isinstance(load, dict) else load)
        aside = scene["bodies"]["upper"].get("shift", (0.0, 0.0))[0]
        left, right = (place + aside for place in scene["bodies"]["upper"]["mesh"]["x"])
        bottom, top = scene["bodies"]["upper"]["mesh"]["y"]
        width = right - left
        x = np.linspace(left, right, 201)
        p = np.full(len(x), mean)
        for n in range(1, 40):
            k = 2.0 * math.pi * n / width
            h = top - bottom
            p += mean * 0.5**n * (1.0 + k * h) * math.exp(-k * h) * np.cos(k * (x - left))
        force = float(np.trapezoid(p, x))
        reaction = Scalar(force, 1e-3 * force, "vertical reaction")
        return Solution(x, p, 1e-3, "cut series", scalars={"reaction": reaction})

    def examples(self):
        body = {"element": "q1", "material": "m"}
        mesh = {"use": "rectangle", "x": [-1.0, 2.0]}
        return [
            {
                "name": SCENE,
                "integrator": "newton",
                "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
                "bodies": {
                    "upper": body | {"mesh": mesh | {"y": [0.0, 1.0], "cells": [4, 2]}},
                    "lower": body | {"mesh": mesh | {"y": [-1.0, 0.0], "cells": [6, 2]}},
                },
                "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p1"}],
                "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}],
                "loads": [{"on": "upper.top", "pressure": {"ramp": "linear", "to": 10.0}}],
            }
        ]
