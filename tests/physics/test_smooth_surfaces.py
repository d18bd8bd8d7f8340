"""Gaps between smooth surfaces: arcs, rings and fits against closed forms, flat sides, turned scenes, and refusals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contactlab_cases.shrink_fit import ShrinkFit
from contactlab_cases.two_rings import RingsPressed
from contactlab_mortar.mortar import MortarP1
from tiers import some

import contactlab
from contactlab.api import Floats, Setup, Surface
from contactlab.cases.run_case import run_job, scene_of
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.smooth_pair import SmoothPair
from contactlab.errors import RequestError
from contactlab.meshing.mesh import surface_from_edges
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

MORTARS = ["mortar-p0", "mortar-p1", "mortar-dual"]
SIDES = [False, True]


def chain(first: int, nodes: int) -> Surface:
    """A chain of so many nodes from number `first` on."""
    return surface_from_edges(first + np.stack([np.arange(nodes - 1), np.arange(1, nodes)], axis=1))


def gaps(positions: Floats, slave: int, *, smooth: bool = True) -> Floats:
    """Gaps [mm] between a chain of `slave` nodes and one of the other nodes, where they cover each other fully."""
    sides = chain(0, slave), chain(slave, len(positions) - slave)
    kind = SmoothPair if smooth else OperatorPair
    pair = kind("contacts.0", MortarP1(), *sides, positions, 0, None, np.zeros(slave, np.bool_))
    pair.update(positions, np.zeros((0, slave)))
    return np.asarray(pair.gaps[:, 0].copy())


def arcs(cells: int) -> tuple[Floats, int]:
    """Two arcs of a quarter of radius 1 with unlike nodes; the slave has three halves as many."""
    inner, outer = np.linspace(0.0, 0.5 * np.pi, 3 * cells // 2 + 1), np.linspace(0.5 * np.pi, 0.0, cells + 1)
    angle = np.concatenate([inner, outer])
    return np.stack([np.cos(angle), np.sin(angle)], axis=1), len(inner)


def test_gaps_of_arcs_on_each_other_vanish_to_fourth_order() -> None:
    """Between their segments to second order alone."""
    errors: dict[bool, list[float]] = {False: [], True: []}
    for cells in (8, 16):
        positions, slave = arcs(cells)
        for smooth, found in errors.items():
            found.append(float(np.abs(gaps(positions, slave, smooth=smooth)).max()))
    order = {smooth: np.log2(found[0] / found[1]) for smooth, found in errors.items()}
    assert order[True] > 3.8
    assert order[False] == pytest.approx(2.0, abs=0.2)
    assert errors[True][1] < 0.01 * errors[False][1]


def test_gaps_between_flat_sides_do_not_change_by_a_bit() -> None:
    draw = np.random.default_rng(3)
    low, high = np.sort(draw.uniform(0.0, 1.0, 6)), np.sort(draw.uniform(0.0, 1.0, 9))
    low[[0, -1]] = high[[0, -1]] = 0.0, 1.0
    flat = np.concatenate([np.stack([low, np.full(6, 0.1)], 1), np.stack([high[::-1], np.zeros(9)], 1)])
    assert np.array_equal(gaps(flat, 6), gaps(flat, 6, smooth=False))


def test_gaps_do_not_change_when_all_is_turned() -> None:
    positions, slave = arcs(8)
    positions = positions + np.random.default_rng(4).uniform(-2e-3, 2e-3, positions.shape)
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    # round-off of positions of length 1
    np.testing.assert_allclose(gaps(positions @ turn.T, slave), gaps(positions, slave), rtol=0.0, atol=1e-14)


def test_corners_stay_corners() -> None:
    """A master that turns by 45 degrees (more than 34) is not rounded, by 22.5 it is."""
    for angle, rounded in ((45.0, False), (22.5, True)):
        flank = np.array([np.cos(np.radians(angle)), -np.sin(np.radians(angle))])
        slave = np.array([[-1.0, 0.3], [0.0, 0.3], [1.0, 0.3]])
        master = np.array([flank, [0.0, 0.0], [-1.0, 0.0]])
        at = np.concatenate([slave, master])
        assert np.array_equal(gaps(at, 3), gaps(at, 3, smooth=False)) != rounded


@pytest.mark.parametrize("swap", some(SIDES, [False]), ids=["inner", "outer"])
@pytest.mark.parametrize("algorithm", some(MORTARS, ["mortar-p1"]))
@pytest.mark.parametrize("wave", some([0.0, 0.5], [0.0]))
def test_the_pressure_of_two_rings_has_second_order(wave: float, algorithm: str, swap: bool) -> None:
    """Uniform or with cos 2t, as reported; between segments the finer side as slave has first order."""
    case, setup, found = RingsPressed(wave=wave), Setup(algorithm, swap, "q1", "newton"), []
    for cells in (24, 48):
        job = smoothed(case.job("rings", setup, cells))
        found.append(case.errors(run_job(job, scene_of(job)), cells)[1])
    assert np.log2(found[0] / found[1]) > 1.8
    assert found[1] < 2e-4 * (1.0 + wave)  # 1e-4 is the mesh's own error of a uniform pressure


def smoothed(job: Any) -> Any:
    """The same job with smooth surfaces."""
    return replace(job, changes={**job.changes, "contacts.0.smooth": True})


@pytest.mark.parametrize("swap", SIDES, ids=["inner", "outer"])
@pytest.mark.parametrize("algorithm", some(MORTARS, ["mortar-p1"]))
def test_a_fit_of_a_thousandth_has_the_pressure_of_lame(algorithm: str, swap: bool) -> None:
    """12 and 15 cells a quarter: facets are 2.1 interferences deep, and between segments the mean is 8 to 56 % low."""
    case = ShrinkFit(ratio=1.25)
    (job,) = case.plan(Setup(algorithm, swap, "q1", "newton"), {})
    cells = {"bodies.inner.mesh.cells": [12, 4], "bodies.outer.mesh.cells": [15, 4]}
    results = simulate(scene_of(job).with_({**cells, "contacts.0.smooth": True}))
    assert results.status == "finished"
    error = results.contact["contacts.0"].last.pressure / case.exact() - 1.0
    assert abs(error.mean()) < 0.02
    assert np.abs(error).max() < 0.06  # gaps err by h^4, which neighbouring nodes carry alike no more
    assert "coarse-facets" not in {warning.code for warning in results.warnings}
    assert results.summary["balance"]["ledger_error"] < 1e-10


def refused(**changes: Any) -> str:
    """What is said of disc-on-block with smooth surfaces and changes."""
    with pytest.raises(RequestError) as caught:
        contactlab.simulate(disc(**changes))
    return str(caught.value)


def disc(**changes: Any) -> Scene:
    """disc-on-block in statics with smooth surfaces."""
    given = {"integrator": "newton", "contacts.0.smooth": True, "contacts.0.algorithm": "mortar-p1"}
    return contactlab.load_scene("disc-on-block").with_({**given, **changes})


def test_what_has_no_smooth_surfaces_is_refused_in_words() -> None:
    assert "integrate over segments" in refused(**{"contacts.0.algorithm": "node-on-segment"})
    assert "curved edges already" in refused(**{"bodies.disc.element": "q2", "bodies.block.element": "q2"})
    frozen = {"use": "active-set", "forces": "consistent"}
    assert "derivatives of their gaps" in refused(**{"contacts.0.enforcement": frozen})
    law = {"use": "linear-pressure"}
    assert "stores energy" in refused(**{"contacts.0.enforcement": law})
