"""Pressure laws with memory, those of tests/outside/remembering, against closed forms; restart and rejected steps."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tiers import some

import contactlab
from contactlab.api import Floats
from contactlab.errors import PartError
from contactlab.model.build import build
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene

PARTS = Path(__file__).parents[1] / "outside" / "remembering" / "src" / "remembering" / "parts.py"
REGISTRY = Registry(files=[PARTS])
YOUNG, DENSITY, WIDTH = 1000.0, 1e-9, 2.0
STIFF = {"use": "crushed-layer", "stiffness": 2000.0, "limit": 4.0, "hardening": 500.0}
SOFT = {"use": "crushed-layer", "stiffness": 2.0, "limit": 0.02, "hardening": 0.5}


def block(law: dict[str, Any], integrator: Any, **changes: Any) -> Scene:
    """A block of unit height, one cell high, that touches a floor; Poisson's ratio is 0, so it is a bar."""
    return Scene.from_data(
        {
            "time": {"end": 1.0},
            "integrator": integrator,
            "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": DENSITY}},
            "bodies": {
                "b": {
                    "element": "q1", "material": "m",
                    "mesh": {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, 1.0], "cells": [2, 1]},
                }
            },
            "rigid": {"floor": {"line": [[50.0, 0.0], [-50.0, 0.0]]}},
            "contacts": [{"slave": "b.bottom", "master": "floor", "algorithm": "mortar-p1", "enforcement": law}],
        } | changes,
        registry=REGISTRY,
    )  # fmt: skip


def pressed_back_and_forth(points: list[list[float]]) -> dict[str, Any]:
    return {"supports": [{"on": "b.top", "ux": 0.0, "uy": {"ramp": "table", "to": -1.0, "points": points}}]}


def crushing(overlap: float, limit: float, stiffness: float, hardening: float) -> float:
    """Pressure at which more of the layer is crushed."""
    return stiffness * (limit + hardening * overlap) / (stiffness + hardening)


def crushed_in_series(pushes: Floats, limit: float, stiffness: float, hardening: float) -> list[float]:
    """Pressures of a bar and a layer in series, E (push - overlap) = p(overlap), branch by branch."""
    found, crushed = [], 0.0
    for push in pushes:
        elastic = YOUNG * stiffness * (push - crushed) / (YOUNG + stiffness)
        slope = stiffness * hardening / (stiffness + hardening)
        yielding = YOUNG * (crushing(0.0, limit, stiffness, hardening) + slope * push) / (YOUNG + slope)
        pressure = max(0.0, min(elastic, yielding))
        crushed = max(crushed, push - pressure / YOUNG - pressure / stiffness)
        found.append(pressure)
    return found


def test_a_crushed_layer_unloads_by_what_is_left_of_it() -> None:
    """Pushed beyond its limit, let go, lifted and pushed further; 1e-7 is what load steps are solved to."""
    points = [[0.0, 0.0], [0.4, 0.02], [0.7, 0.006], [1.0, 0.025]]
    results = contactlab.simulate(block(STIFF, {"use": "newton", "steps": 6}, **pressed_back_and_forth(points)))
    assert results.status == "finished", results.reason
    found = np.abs(results.history["contacts.0.fy"]) / WIDTH
    pushes = np.interp(results.history["time"], *np.array(points).T)
    numbers = {name: value for name, value in STIFF.items() if name != "use"}
    expected = crushed_in_series(pushes, **numbers)
    np.testing.assert_allclose(found, expected, atol=1e-6 * max(expected))
    assert found[np.searchsorted(results.history["time"], 0.7)] == 0.0
    assert max(expected) > STIFF["limit"]
    assert "remembering" in results.summary["parts"]["contacts.0.enforcement"]


def test_a_bounce_loses_what_it_crushes_in_explicit_steps() -> None:
    """What comes back is the elastic part of the largest pressure: v'/v = sqrt(p^2/k m)/v.

    The block is 500 times as stiff as the layer: its own vibrations keep (w/w_b)^2, 2e-3, of the energy.
    """
    speed, mass = 1500.0, DENSITY
    stiffness, limit, hardening = SOFT["stiffness"], SOFT["limit"], SOFT["hardening"]
    first = limit / stiffness

    def work(overlap: float) -> float:
        slope = stiffness / (stiffness + hardening)
        return 0.5 * limit * first + slope * (limit + 0.5 * hardening * (overlap + first)) * (overlap - first)

    deepest = brentq(lambda overlap: work(overlap) - 0.5 * mass * speed**2, first, 1.0)
    largest = crushing(deepest, limit, stiffness, hardening)
    period = math.pi * math.sqrt(mass / stiffness)
    scene = block(SOFT, "central-difference", time={"end": 1.6 * period}).with_({"bodies.b.velocity": [0.0, -speed]})
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    history = results.history
    assert np.abs(history["contacts.0.fy"]).max() / WIDTH == pytest.approx(largest, rel=2e-3)
    kept = history["energy.kinetic"][-1] / (0.5 * WIDTH * mass * speed**2)
    assert kept == pytest.approx(largest**2 / stiffness / (mass * speed**2), rel=5e-3)
    assert not results.summary["warnings"]


@pytest.mark.parametrize("use", some(["newton", "central-difference"], ["central-difference"]))
def test_wear_is_pressure_times_slip(use: str) -> None:
    """Pushed down at a rate on a floor that moves: dw/ds = c p and p = k (u - w), k of bar and layer in series.

    So p = U/(c S) (1 - exp(-c k S)) after the way S, at the push U. A step wears by its first or last pressure, which
    is half of c k S/25 off at the most; an explicit bar rings by the stress of its push, density c v, 8e-3 of p.
    """
    stiffness, wear, way, push, end = 500.0, 2e-4, 3.0, 0.01, 4e-4
    scene = block(
        {"use": "worn-layer", "stiffness": stiffness, "wear": wear},
        {"use": use, "steps": 25} if use == "newton" else use, time={"end": end},
        supports=[{"on": "b.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -push}}],
    ).with_(
        {"rigid.floor.ux": {"ramp": "linear", "to": way}, "contacts.0.friction": {"use": "coulomb", "mu": 0.0},
         "record.frames": 1}
    )  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    series = YOUNG * stiffness / (YOUNG + stiffness)
    expected = push / (wear * way) * -math.expm1(-wear * series * way)
    found = np.abs(results.history["contacts.0.fy"][-1]) / WIDTH
    assert found == pytest.approx(expected, rel=4e-3 if use == "newton" else 8e-3)
    worn = results.contact["contacts.0"].last.memory["worn"]
    # a load step is worn at its end, when its pressure is known
    allowed = wear * expected * way / 25 if use == "newton" else 8e-3 * expected / series
    np.testing.assert_allclose(worn, push - expected / series, atol=allowed)


def test_what_wears_needs_friction_to_measure_slip() -> None:
    with pytest.raises(PartError, match=r"contacts\.0\.friction(.|\n)*measured in contacts with friction"):
        build(block({"use": "worn-layer", "stiffness": 500.0, "wear": 2e-4}, "newton"), REGISTRY)


@pytest.mark.parametrize("use", ["central-difference", "implicit-dynamics", "newton"])
def test_memory_survives_a_restart_and_no_step_that_fails_advances_it(use: str, taken_up: Any) -> None:
    """Taken up by new parts half-way, and with steps that are rejected or taken back: the same bits."""
    integrator = {"use": use} | ({"impacts": False} if use == "implicit-dynamics" else {})
    # more than the limit within the first step, in statics as well
    pushed = {"supports": [{"on": "b.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.1, "duration": 1e-4}}]}
    scene = block(STIFF, integrator, **pushed).with_({"materials.m.use": "neo-hookean"})
    dt, steps = 2e-7 if use == "central-difference" else 1e-5, 120 if use == "central-difference" else 8
    model, saved = taken_up(scene, REGISTRY, dt, steps)
    assert (model.state["pressure_law"] > saved["state.pressure_law"]).any()


def test_what_laws_remember_is_in_every_output(tmp_path: Path) -> None:
    """In `contact.csv`, the summary, stored results and the timeline; of a restart from the stored results, too."""
    law = {"use": "worn-layer", "stiffness": 500.0, "wear": 2e-4}
    supports = [{"on": "b.top", "ux": {"ramp": "linear", "to": 0.1}, "uy": -0.01}]
    scene = block(law, {"use": "newton", "steps": 4}, supports=supports).with_(
        {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}, "record.recorders": ["vtkhdf"]}
    )
    results = contactlab.simulate(scene, out=tmp_path / "run")
    curves = contactlab.load_results(tmp_path / "run").contact["contacts.0"].curves
    assert curves == results.contact["contacts.0"].curves
    worn = [curve.memory["worn"] for curve in curves]
    assert (np.diff(worn, axis=0) > 0.0).all()
    rows = list(csv.DictReader((tmp_path / "run" / "contact.csv").open()))
    assert [float(row["memory.worn"]) for row in rows] == worn[-1].tolist()
    ends = {"least": worn[-1].min(), "most": worn[-1].max()}
    assert results.summary["contacts"]["contacts.0"]["memory"] == {"worn": ends}
