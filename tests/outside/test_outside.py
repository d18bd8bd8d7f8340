"""Parts of strangers give right answers in runs.

Run by tests/contract/test_strangers.py where the packages of this folder are installed; compare, explain and check are
asked there.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import contactlab
from contactlab.cli import main

MU = 0.3
COULOMB = {"use": "coulomb", "mu": MU}
STEEL = {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-6}


def test_run_names_the_parts_and_their_packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a slider in its first twentieth of the way, which presses on its base and rubs on it."""
    monkeypatch.chdir(tmp_path)
    words = ["--set", "integrator=plain-leapfrog", "--set", "contacts.0.algorithm=closest-point", "--out", "one"]
    assert main(["run", "corner-slide", "--set", "time.end=4e-5", *words]) == 0
    summary = json.loads((tmp_path / "one" / "summary.json").read_text())
    assert "plain-leapfrog" in json.dumps(summary["versions"])
    assert summary["parts"]["integrator"].startswith("plain-leapfrog")
    assert summary["reactions"]["base.bottom"][1] > 0.0
    assert summary["balance"]["ledger_error"] < 1e-6


def pressed(enforcement: Any, algorithm: str = "mortar-p1", friction: Any = COULOMB) -> Any:
    """A plate pressed on a floor and drawn along."""
    results = contactlab.simulate(
        contactlab.Scene.from_data(
            {
                "integrator": "newton",
                "materials": {"m": STEEL},
                "bodies": {
                    "plate": {
                        "element": "q1", "material": "m",
                        "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 0.3], "cells": [4, 2]},
                    }
                },
                "rigid": {"floor": {"line": [[3.0, 0.0], [-1.0, 0.0]]}},
                "contacts": [
                    {
                        "slave": "plate.bottom", "master": "floor", "algorithm": algorithm,
                        "enforcement": enforcement, "friction": friction,
                    }
                ],
                "supports": [{"on": "plate.top", "ux": {"ramp": "linear", "to": 0.1}, "uy": -0.003}],
            }
        )
    )  # fmt: skip
    assert results.status == "finished", results.reason
    return results.summary


def test_the_enforcement_tends_to_exact_multipliers() -> None:
    """Springs ten times as stiff leave a tenth of the error, down to the width over which they begin to act."""
    exact = pressed("active-set")["reactions"]["plate.top"]
    errors = []
    for factor in (100.0, 1000.0):
        found = pressed({"use": "soft", "factor": factor, "width": 1e-7})["reactions"]["plate.top"]
        errors.append(abs(found[1] - exact[1]) / abs(exact[1]))
        assert abs(found[0]) == pytest.approx(MU * abs(found[1]), rel=1e-3)
    assert 0.0 < errors[1] < 0.15 * errors[0] < 0.01


def test_a_law_sees_the_stress_behind_the_slave() -> None:
    """On a floor, frictionless: sigma = -p; the gap is -p/2k, k = factor M/depth of the cells, to strains of 1e-5.

    Plane strain of a plate that is free along: it takes E/(1 - nu^2) of the strain that is left.
    """
    factor, depth, height, push = 10.0, 0.15, 0.3, 3e-6
    scene = contactlab.Scene.from_data(
        {
            "integrator": "newton",
            "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-6}},
            "bodies": {
                "plate": {
                    "element": "q1", "material": "m",
                    "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, height], "cells": [4, 2]},
                }
            },
            "rigid": {"floor": {"line": [[3.0, 0.0], [-1.0, 0.0]]}},
            "contacts": [
                {
                    "slave": "plate.bottom", "master": "floor", "algorithm": "mortar-p1",
                    "enforcement": {"use": "half-traction", "factor": factor},
                }
            ],
            "supports": [{"on": "plate.top", "uy": -push}, {"on": "plate.left", "ux": 0.0}],
        }
    )  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    plain, dilatational = 1000.0 / (1.0 - 0.3**2), 1000.0 * 0.7 / (1.3 * 0.4)
    pressure = push / (height / plain + depth / (2.0 * factor * dilatational))
    assert results.summary["reactions"]["plate.top"][1] == pytest.approx(-2.0 * pressure, rel=1e-4)
    gap = results.contact["contacts.0"].last.gap
    assert list(gap) == pytest.approx([-pressure * depth / (2.0 * factor * dilatational)] * len(gap), rel=1e-4)


def test_a_mortar_in_numpy_carries_the_same_force() -> None:
    """A plate pressed on a floor: Gauss points are exact there but where the floor's segments end."""
    shipped, own = (pressed("active-set", name)["reactions"]["plate.top"] for name in ("mortar-p1", "gauss-mortar"))
    assert own[1] == pytest.approx(shipped[1], rel=1e-3)
    assert abs(own[0]) == pytest.approx(MU * abs(own[1]), rel=1e-6)


def test_friction_of_rate_has_its_coefficient_and_is_in_the_summary() -> None:
    """A plate drawn at 0.1 mm/s over a floor: rate and state at its own rate of reference, Stribeck's curve at any.

    What is left of elastic loading is 1e-3 after four of the steps.
    """
    stribeck = {"use": "stribeck", "static": 0.5, "kinetic": 0.3, "speed": 0.1}
    ageing = {"use": "rate-and-state", "mu": MU, "a": 0.02, "b": 0.03, "length": 0.1, "speed": 0.1}
    for law, expected in ((stribeck, 0.3 + 0.2 * 2.718281828**-1), (ageing, MU)):
        found = pressed("active-set", friction=law)
        force = found["reactions"]["plate.top"]
        assert abs(force[0]) / abs(force[1]) == pytest.approx(expected, rel=2e-3)
        assert "rate-friction" in found["parts"]["contacts.0.friction"]
