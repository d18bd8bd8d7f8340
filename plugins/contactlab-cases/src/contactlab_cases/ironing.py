"""Shallow ironing: a stiff rounded block is pressed into a soft foundation and drawn along it.

Geometry, laws and path follow a benchmark for which six codes have published forces; there is no exact answer.
They spread over 24 % (vertical, end of press), 25 % (vertical, half-way) and a factor 1.8 (horizontal, half-way).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Answer, Case, Floats, Job, Measure, Record, Setup
from contactlab.api.case import reported, within
from contactlab_cases.circles import only
from contactlab_cases.statics import iterations

PRESS = 1.0
PUBLISHED = {"end of press": (267.9, 332.0), "vertical half-way": (337.4, 421.0), "horizontal half-way": (102.1, 188.8)}
"""Least and largest of Code_Aster, Hartmann, Fischer & Wriggers, Yastrebov, Poulios & Renard, solids4foam [N/mm]."""


@dataclass(frozen=True)
class Ironing(Case):
    """Foundation 12 x 4 under a block 1.2 wide with a rounded sole, 0.2 above it at the start.

    slide    way along the foundation [mm]; published values are half-way of 10
    refined  2 for the published mesh of 120 x 30 cells
    steps    load steps per millimetre of the slide
    """

    slide: float = 2.0
    refined: int = 1
    steps: int = 8
    mu: float = 0.3

    title: ClassVar[str] = "shallow ironing"
    source: ClassVar[str] = "Fischer & Wriggers 2006; Hartmann et al. 2009; Poulios & Renard 2015"
    family: ClassVar[str] = "large sliding"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"slide": (2.0, 5.0)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "large sliding", "large deformation"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: down in a unit of time, along in another."""
        law = {"use": "neo-hookean", "poisson": 0.32, "density": 1.0}
        level, slides = self.refined * setup.level, max(16, round(self.steps * self.slide))
        bodies = {
            "block": {
                "element": setup.element, "material": "hard", "shift": [0.8, 0.2],
                "mesh": {"use": "arc-block", "radius": 0.75, "half_width": 0.6, "top": 1.2, "cells": [7, 6]},
            },
            "foundation": {
                "element": setup.element, "material": "soft",
                "mesh": {"use": "rectangle", "x": [0.0, 12.0], "y": [-4.0, 0.0], "cells": [60, 15]},
            },
        }  # fmt: skip
        path = {
            "on": "block.top",
            "uy": {"ramp": "linear", "to": -PRESS, "duration": 1.0},
            "ux": {"ramp": "linear", "to": self.slide, "begin": 1.0, "duration": 1.0},
        }
        contact = {
            "slave": "block.arc", "master": "foundation.top", "algorithm": setup.algorithm, "swap": setup.swap,
            "friction": {"use": "coulomb", "mu": self.mu},
        }  # fmt: skip
        scene = {
            "name": "shallow-ironing", "level": level, "time": {"end": 2.0},
            "integrator": {"use": "newton", "steps": 2 * slides},
            "materials": {"soft": law | {"young": 689.6}, "hard": law | {"young": 6896.0}},
            "bodies": bodies, "contacts": [contact],
            "supports": [{"on": "foundation.bottom", "ux": 0.0, "uy": 0.0}, path],
        }  # fmt: skip
        return (Job("drawn", scene, work=30 * slides, frames=2 * slides),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The spread of six codes; a coarse mesh takes a tenth more."""
        slack = 0.1 if self.refined * setup.level < 2 else 0.0
        found = [within("end of press", *_wider("end of press", slack), "spread of six codes", "N/mm", answer=SIX)]
        if self.slide >= 5.0:
            found += [
                within(n, *_wider(n, slack), "spread of six codes", "N/mm", answer=SIX) for n in list(PUBLISHED)[1:]
            ]
            found.append(within("global friction ratio", 0.30, 0.53, "spread of six codes"))
        return [*found, reported("vertical at the end", "N/mm"), reported("saw of the force"), reported("iterations")]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Forces of the block on the foundation by the way of its top."""
        record = only(done)
        time = np.asarray(record.history["time"])
        fx, fy = (np.asarray(record.history[f"block.top.{axis}"]) for axis in ("fx", "fy"))
        sliding = time >= 1.0 - 1e-9
        along, down, side = (time[sliding] - 1.0) * self.slide, -fy[sliding], fx[sliding]
        found = {"end of press": float(np.interp(1.0, time, -fy)), "iterations": iterations(record)}
        if not record.finished:
            return found
        size = 0.2 / (self.refined * setup.level)
        found |= {"vertical at the end": float(down[-1]), "saw of the force": _saw(along, down, size)}
        if self.slide >= 5.0:
            vertical, horizontal = (float(np.interp(5.0, along, force)) for force in (down, side))
            found |= {"vertical half-way": vertical, "horizontal half-way": horizontal}
            found["global friction ratio"] = horizontal / vertical
        return found


SIX = Answer(300.0, "other-code", 0.12, "six codes, as collected by solids4foam")


def _wider(name: str, slack: float) -> tuple[float, float]:
    least, most = PUBLISHED[name]
    return (1.0 - slack) * least, (1.0 + slack) * most


def _saw(along: Floats, force: Floats, size: float) -> float:
    """Largest distance of the force from its mean over two segments, as a fraction of it, away from the ends."""
    even = np.linspace(along[0], along[-1], 4 * len(along))
    values = np.interp(even, along, force)
    window = max(3, round(2.0 * size / float(even[1] - even[0])))
    smooth = np.convolve(values, np.full(window, 1.0 / window), mode="same")
    inside = (even > along[0] + 2.0 * size) & (even < along[-1] - 2.0 * size)
    return float(np.abs(values - smooth)[inside].max() / np.abs(smooth[inside]).mean())
