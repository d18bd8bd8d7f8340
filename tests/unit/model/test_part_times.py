"""Where time goes: parts of a phase sum to it, a slow part is found, and asking changes nothing."""

from __future__ import annotations

from time import sleep
from typing import Any

import numpy as np
import pytest
from contactlab_solids.neo_hookean import NeoHookean

from contactlab.model.build import build
from contactlab.model.part_times import element_times
from contactlab.reports.run_details import part_label
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

LAW = {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-6}
PAUSE = 1e-3  # s, beside some microseconds of a law on a few cells


def thrown(integrator: str, **time: Any) -> Scene:
    """A block that falls on another, or is pressed on it."""
    body = {"element": "q1", "material": "m"}
    upper = {"mesh": {"use": "rectangle", "x": [0.3, 1.7], "y": [0.0, 1.0], "cells": [4, 2]}}
    lower = {"mesh": {"use": "rectangle", "x": [0.0, 3.0], "y": [-1.0, 0.0], "cells": [7, 2]}}
    return Scene.from_data(
        {
            "integrator": integrator,
            "materials": {"m": LAW},
            "bodies": {"upper": body | upper, "lower": body | lower},
            "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p1"}],
            "supports": [
                {"on": "lower.bottom", "ux": 0.0, "uy": 0.0},
                {"on": "upper.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.01}},
            ],
            **({"time": time} if time else {}),
        }
    )


@pytest.mark.parametrize(
    ("integrator", "time", "of_contact", "of_elements"),
    [
        ("central-difference", {"end": 2e-4, "step": 4e-6}, {"search", "integration", "solution"}, {"law", "element"}),
        ("newton", {}, {"search", "integration"}, {"law", "element", "stiffness"}),
    ],
)
def test_parts_sum_to_their_phase(
    integrator: str, time: dict[str, float], of_contact: set[str], of_elements: set[str]
) -> None:
    cost = simulate(thrown(integrator, **time)).summary["cost"]
    assert set(cost["parts"]["contact"]) == of_contact
    assert set(cost["parts"]["elements"]) == of_elements
    for phase, parts in cost["parts"].items():
        seconds = [value for times in parts.values() for value in times.values()]
        assert min(seconds) > 0.0
        # round-off of sums
        assert sum(seconds) == pytest.approx(cost["phases"][phase], rel=1e-9)
    assert next(iter(cost["parts"]["elements"]["law"])).startswith("neo-hookean (contactlab-solids")
    assert next(iter(cost["parts"]["contact"]["integration"])).startswith("mortar-p1 (contactlab-mortar")


def test_a_slow_law_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    fast = NeoHookean.stress

    def slow(self: NeoHookean, *arrays: Any) -> None:
        sleep(PAUSE)
        fast(self, *arrays)

    monkeypatch.setattr(NeoHookean, "stress", slow)
    cost = simulate(thrown("central-difference", end=4e-5, step=4e-6)).summary["cost"]
    (law,), (element,) = (cost["parts"]["elements"][what].values() for what in ("law", "element"))
    assert law > 5.0 * element
    # two bodies, ten steps
    assert law > 20 * PAUSE


def test_asking_changes_nothing() -> None:
    scene = thrown("central-difference", end=2e-4, step=4e-6)
    model = build(scene, scene.registry)
    advance = model.bound_integrator().step
    for _ in range(5):
        advance(4e-6)
    arrays = [model.state.buffer, model.position]
    arrays += [array for forces in model.forces for b in forces.blocks for array in (b.gradient, b.stress, b.history)]
    before = [array.copy() for array in arrays]
    assert element_times(model)
    for array, was in zip(arrays, before, strict=True):
        np.testing.assert_array_equal(array, was)


def test_parts_of_others_are_shown_with_their_package() -> None:
    assert part_label("rubber (gauss-contact 0.1.0)") == ": rubber (gauss-contact 0.1.0)"
    assert part_label("q1 (contactlab-quads 0.1.0)") == ": q1"
    assert part_label("contactlab") == ""
