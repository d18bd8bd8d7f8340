"""Slaves that are closed and covered all around: a shaft in its hub, pressed, turned and thrown."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

HOLE, FIT, OUTSIDE = 0.3, 0.6, 1.0  # mm
MORTARS = ("mortar-p0", "mortar-p1", "mortar-dual")


def rings(cells: tuple[int, int], contact: dict[str, Any], **more: Any) -> Scene:
    """A shaft with a hole in a hub, each with so many cells around."""
    bodies = {
        name: {"element": "q1", "material": "steel", "mesh": {"use": "ring", "radii": radii, "cells": [count, 3]}}
        for name, radii, count in zip(("shaft", "hub"), ([HOLE, FIT], [FIT, OUTSIDE]), cells, strict=True)
    }
    steel = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}
    return Scene.from_data(
        {"materials": {"steel": steel}, "bodies": bodies, "record": {"recorders": []},
         "contacts": [{"slave": "shaft.outer", "master": "hub.inner"} | contact]} | more
    )  # fmt: skip


def turned(algorithm: str, swap: bool, shear: float) -> Scene:
    """Pressed from outside by 1 MPa and turned by a shear there, on a shaft whose hole is held."""
    contact = {
        "algorithm": algorithm, "swap": swap, "friction": {"use": "coulomb", "mu": 0.2}, "start": {"gap": "zero"},
    }  # fmt: skip
    return rings(
        (24, 24), contact, time={"end": 2.0}, integrator={"use": "newton", "steps": 2},
        supports=[{"on": "shaft.inner", "ux": 0.0, "uy": 0.0}],
        loads=[{"on": "hub.outer", "pressure": {"ramp": "linear", "to": 1.0, "duration": 1.0}},
               {"on": "hub.outer", "shear": {"ramp": "linear", "to": shear, "begin": 1.0, "duration": 1.0}}],
    )  # fmt: skip


@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("algorithm", MORTARS)
def test_a_turned_shaft_carries_its_torque_evenly(algorithm: str, swap: bool) -> None:
    """All nodes are alike, so that pressure and shear are: to the tolerance of the iteration, 1e-8."""
    shear = 0.05
    results = simulate(turned(algorithm, swap, shear))
    assert results.status == "finished", results.reason
    last = results.contact["contacts.0"].last
    assert len(last.pressure) == 24
    for found in (last.pressure, last.nodal_pressure, last.shear):
        assert np.ptp(found) < 1e-7 * np.abs(found).max()
    assert (last.state == 1).all()
    # the torque of the load: edges of a 24th of the circle, radii of their middles; directions at both ends of a
    # segment differ by 15 degrees, for 1 % of its force
    side, middle = 2.0 * np.sin(np.pi / 24), np.cos(np.pi / 24)
    force = 24.0 * np.abs(last.shear).mean() * FIT * side
    assert force * FIT == pytest.approx(24.0 * shear * OUTSIDE * side * OUTSIDE * middle, rel=1e-2)


@pytest.mark.parametrize("algorithm", MORTARS)
def test_unlike_meshes_converge_as_fast_as_open_ones(algorithm: str) -> None:
    """Derivatives of the coupling are exact: five iterations, as for a quarter of the same rings."""
    overlap = {"algorithm": algorithm, "start": {"overlap": "ramp"}}
    scene = rings(
        (40, 24), overlap, time={"end": 1.0}, integrator={"use": "newton", "steps": 1},
        supports=[{"on": "shaft.inner", "ux": 0.0, "uy": 0.0}, {"on": "hub.outer", "ux": 0.0, "uy": 0.0}],
    ).with_({"bodies.hub.mesh.radii": [0.98 * FIT, OUTSIDE]})  # fmt: skip
    results = simulate(scene)
    assert results.status == "finished", results.reason
    assert results.summary["iterations"] <= 5


@pytest.mark.parametrize("element", ["q1", pytest.param("q2", marks=pytest.mark.full)])
def test_a_thrown_shaft_keeps_momentum_and_energy(element: str) -> None:
    """It hits its hub, which is free: consistent forces keep all but round-off."""
    scene = rings(
        (24, 20), {"algorithm": "mortar-p1"}, time={"end": 2e-4}, integrator={"use": "central-difference"},
    ).with_({
        "bodies.shaft.mesh.radii": [HOLE, 0.99 * FIT], "bodies.shaft.velocity": [300.0, 40.0],
        "bodies.shaft.spin": 200.0, "bodies.shaft.element": element, "bodies.hub.element": element,
        "materials.steel.use": "neo-hookean", "record.frames": 5,
    })  # fmt: skip
    results = simulate(scene)
    assert results.status == "finished", results.reason
    found = {one["name"]: one["value"] for one in results.summary["invariants"]}
    for name in ("change of the momentum along x", "change of the angular momentum", "error of the energy ledger"):
        assert found[name] < 1e-12
    assert not {"contact-energy", "energy-at-end"} & {warning.code for warning in results.warnings}
