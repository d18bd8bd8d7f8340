"""A viscoelastic law of a stranger in runs: a bar that is strained and held relaxes as its closed form does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contactlab
from contactlab.parts.registry import Registry

LAW = Path(__file__).parents[1] / "contract" / "right_parts" / "viscoelastic.py"
HOOK = """

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts():
    return [Part("material", "visco", "MODULE:Visco", "of a stranger")]
"""
YOUNG, POISSON, SHARE, TAU, STRAIN, END = 1000.0, 0.3, 1.5, 2e-4, -1e-3, 1e-3


@pytest.mark.parametrize(("integrator", "within"), [("newton", 1e-9), ("central-difference", 3e-3)])
def test_a_bar_that_is_held_relaxes(integrator: str, within: float, tmp_path: Path) -> None:
    """Between smooth walls, strained in the first half: (lambda + 2 G) e and 2 share G e' with the branch's memory.

    Steps integrate a ramp exactly. The explicit bar rings by the time of a wave, 0.7 us, over that of the ramp.
    """
    file = tmp_path / f"visco_with_{integrator.replace('-', '_')}.py"
    file.write_text(LAW.read_text(encoding="utf-8") + HOOK.replace("MODULE", file.stem), encoding="utf-8")
    mesh = {"use": "rectangle", "x": [0.0, 0.5], "y": [0.0, 1.0], "cells": [1, 4]}
    sides = {"left": {"ux": 0.0}, "right": {"ux": 0.0}, "bottom": {"uy": 0.0}}
    ramp = {"ramp": "linear", "to": STRAIN, "duration": 0.5 * END}
    law = {"use": "visco", "young": YOUNG, "poisson": POISSON, "share": SHARE, "tau": TAU, "density": 1e-9}
    scene = contactlab.Scene.from_data(
        {
            "time": {"end": END},
            "integrator": {"use": "newton", "steps": 10} if integrator == "newton" else integrator,
            "materials": {"m": law},
            "bodies": {"b": {"element": "q1", "material": "m", "mesh": mesh}},
            "supports": [*({"on": f"b.{side}", **held} for side, held in sides.items()), {"on": "b.top", "uy": ramp}],
            "record": {"frames": 10},
        },
        registry=Registry(files=[file]),
    )
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    shear = 0.5 * YOUNG / (1.0 + POISSON)
    lame = 2.0 * shear * POISSON / (1.0 - 2.0 * POISSON)
    time = np.asarray(results.history["time"])
    ramped, half = np.minimum(time, 0.5 * END), 0.5 * END
    grown = TAU / half * -np.expm1(-ramped / TAU) * np.exp(-(time - ramped) / TAU)
    stress = (lame + 2.0 * shear) * STRAIN * ramped / half + 2.0 * SHARE * shear * 2.0 / 3.0 * STRAIN * grown
    found = np.asarray(results.history["b.bottom.fy"])
    np.testing.assert_allclose(found, -0.5 * stress, rtol=0.0, atol=within * 0.5 * np.abs(stress).max())
