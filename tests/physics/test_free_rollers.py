"""Rollers that nothing holds but the friction of what presses them: statics finds them in as few iterations as blocks.

While all surfaces of a roller slide nothing holds it from spinning. A correction of such a state spun it by a third of
its size, and most of these load steps were cut, took hundreds of iterations, or ended with a roller that leaned aside.
"""

from __future__ import annotations

from typing import Any

import pytest
from tiers import some

from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

STEPS = 5
FEW = 5  # iterations of a load step: three of Newton's, two more where nodes come to contact; more in the first one
FIRST = 10
DEPTH, FORCE = 0.1, 18.0  # mm, N: about the same


def rolled(algorithm: str, exchanged: tuple[int, ...], loaded: bool = False, rollers: int = 1) -> Results:
    """Rollers between two plates, which are pressed together by DEPTH or FORCE."""

    def plate(low: float) -> dict[str, Any]:
        mesh = {"use": "rectangle", "x": [-3.0, 3.0], "y": [low, low + 1.0], "cells": [30, 6]}
        return {"element": "q1", "material": "m", "mesh": mesh}

    disc = {"use": "disc", "radius": 0.9 if rollers > 1 else 1.0, "cells": [10, 5]}
    places, size = ([-1.5, 1.5] if rollers > 1 else [0.0]), disc["radius"]
    bodies = {f"roll{k}": {"element": "q1", "material": "m", "mesh": disc, "shift": [x, size]}
              for k, x in enumerate(places)}  # fmt: skip
    sides = [pair for name in bodies for pair in ((f"{name}.bottom", "low.top"), (f"{name}.top", "high.bottom"))]
    sides = [pair[::-1] if number % 2 in exchanged else pair for number, pair in enumerate(sides)]
    press = {"on": "high.top", "ux": 0.0} | ({} if loaded else {"uy": {"ramp": "linear", "to": -DEPTH * rollers}})
    load = [{"on": "high.top", "ty": {"ramp": "linear", "to": -FORCE / 6.0}}] if loaded else []
    return simulate(Scene.from_data({
        "integrator": {"use": "newton", "steps": STEPS},
        "materials": {"m": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {"low": plate(-1.0), "high": plate(2.0 * size), **bodies},
        "contacts": [{"slave": slave, "master": master, "algorithm": algorithm,
                      "friction": {"use": "coulomb", "mu": 0.1}} for slave, master in sides],
        "supports": [{"on": "low.bottom", "ux": 0.0, "uy": 0.0}, press],
        "loads": load,
        "record": {"recorders": []},
    }))  # fmt: skip


SLAVES = [(), (0,), (1,), (0, 1)]
"""Which contacts have the plate as slave: none, that below, that above, both."""
ALGORITHMS = ["mortar-p0", "mortar-p1", "mortar-dual", "gauss-point"]
EACH = [(algorithm, exchanged) for algorithm in ALGORITHMS for exchanged in SLAVES]


@pytest.mark.parametrize(("algorithm", "exchanged"), some(EACH, [("mortar-p1", (0,)), ("gauss-point", (0, 1))]))
def test_a_roller_between_plates_takes_few_iterations(algorithm: str, exchanged: tuple[int, ...]) -> None:
    """No load step is cut, and nothing leans: forces along the plates, which symmetry forbids, are round-off."""
    results = rolled(algorithm, exchanged)
    assert results.status == "finished"
    assert results.summary["steps"] == STEPS
    assert results.summary["iterations"] <= FIRST + FEW * STEPS
    along, across = results.summary["reactions"]["low.bottom"]
    assert abs(along) < 1e-6 * across


@pytest.mark.parametrize("algorithm", some(ALGORITHMS[:3], ["mortar-p1"]))
def test_exchanged_contacts_above_are_those_below_turned_over(algorithm: str) -> None:
    """Of the same scene upside down: forces agree to the tolerance of the iteration."""
    below, above = (rolled(algorithm, (number,)).summary["reactions"]["low.bottom"][1] for number in (0, 1))
    assert below == pytest.approx(above, rel=1e-6)


@pytest.mark.parametrize(("loaded", "rollers"), some([(True, 1), (True, 2), (False, 2)], [(True, 2)]))
@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_so_do_rollers_that_a_load_presses_and_two_beside_each_other(
    algorithm: str, loaded: bool, rollers: int
) -> None:
    results = rolled(algorithm, (), loaded, rollers)
    assert results.status == "finished"
    assert results.summary["steps"] == STEPS
    assert results.summary["iterations"] <= FIRST + FEW * STEPS
    if loaded:  # balance of forces
        assert results.summary["reactions"]["low.bottom"][1] == pytest.approx(FORCE, rel=1e-6)
