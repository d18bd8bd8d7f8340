"""Static contact with exact or published answers, where the quick matrix (test_hard_cases.py) does not go.

Other friction, the other slave, and what a run must refuse.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_cases.ironing import PUBLISHED, Ironing
from contactlab_cases.pulled_block import PulledBlock
from contactlab_cases.rough_plate import RoughPlate

from contactlab.api import Case, Floats, Setup
from contactlab.cases.run_case import scene_of
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene


def runs_of(case: Case, algorithm: str, swap: bool = False, **changes: Any) -> list[Results]:
    """All runs of a case in statics."""
    jobs = case.plan(Setup(algorithm, swap, "q1", "newton", 1), {})
    return [simulate(scene_of(job).with_(changes)) for job in jobs]


@pytest.mark.parametrize("mu", [2.0, 5.0, 20.0])
def test_high_friction(mu: float) -> None:
    """Equilibria are found with any friction that a user may mean; with mu = 5 the corner lifts off up to 7.5 mm."""
    (results,) = runs_of(RoughPlate(mu), "mortar-p0")
    assert results.status == "finished"
    assert results.summary["iterations"] <= 12
    contact = results.summary["contacts"]["contacts.0"]
    assert contact["cone_violation"] < 1e-8
    if mu == 5.0:
        curve = results.contact["contacts.0"].last
        assert curve.x[curve.state == 0].max() == pytest.approx(7.5e-3, abs=1.25e-3)


def test_absurd_friction_is_never_accepted_silently() -> None:
    """mu = 1000: the iteration fails, and the run says so after the shortest step."""
    (results,) = runs_of(RoughPlate(1000.0, cells=8), "mortar-p0")
    if results.status == "finished":
        assert results.summary["contacts"]["contacts.0"]["cone_violation"] < 1e-8
    else:
        assert results.status == "not-converged"
        assert "iterations left residuals" in results.reason


@pytest.mark.parametrize(("poisson", "mu", "algorithm"), [(0.0, 5.0, "mortar-p0"), (0.3, 2.0, "mortar-p1")])
def test_a_block_that_only_friction_holds(algorithm: str, poisson: float, mu: float) -> None:
    """Pulled by 0.9 mu P: what sticks has not moved, and the plane holds what an unlimited friction would.

    Before the first touch has a force, friction has no bound: nothing would keep the block from flying away.
    """
    coarse = {"bodies.block.mesh.cells": [8, 8]}
    results, unlimited = runs_of(PulledBlock(mu, poisson), algorithm, **coarse)
    assert results.status == unlimited.status == "finished", results.reason
    pull, weight = results.summary["reactions"]["plane"]
    np.testing.assert_allclose([-pull, weight], [900.0 * mu, 1000.0], rtol=1e-6)
    curve = results.contact["contacts.0"].last
    stuck = curve.state == 1
    assert stuck.any() if poisson else stuck.all()
    assert np.abs(curve.x - np.linspace(0.0, 10.0, 9))[stuck].max() < 1e-9 * 1.25


def test_a_body_that_nothing_holds_is_not_in_balance() -> None:
    """Pulled without friction, the block has no equilibrium: the run must not end well."""
    free = {"bodies.block.mesh.cells": [4, 4], "contacts.0.friction.mu": 0.0}
    assert runs_of(PulledBlock(1.0, 0.3), "mortar-p0", **free)[0].status == "not-converged"


def ironed(algorithm: str, swap: bool) -> tuple[float, float]:
    """Forces of 1.2 mm of sliding: vertical and horizontal at the end, in the range of published ones.

    The vertical force is still on its way from that of the press to that of sliding, 1.15 to 1.3 times as large.
    """
    (results,) = runs_of(Ironing(slide=1.2), algorithm, swap, **{"integrator.steps": 20, "record.frames": 4})
    assert results.status == "finished"
    time, fx, fy = (np.asarray(results.history[name]) for name in ("time", "block.top.fx", "block.top.fy"))
    least, most = PUBLISHED["end of press"]
    pressed = float(np.interp(1.0, time, -fy))
    assert least <= pressed <= most
    assert 1.1 < -fy[-1] / pressed < 1.35
    return float(-fy[-1]), float(fx[-1])


@pytest.mark.full
def test_ironing_with_the_foundation_as_slave() -> None:
    """Coarse and short of the whole path: forces in the range of the published ones."""
    vertical, horizontal = ironed("mortar-p0", True)
    assert 0.28 < horizontal / vertical < 0.53


def test_ironing_with_slivers_of_cover_at_the_rim() -> None:
    """P1 on the foundation: its segments at the rim of the block are covered in part.

    Forces are those of the other side as slave, to what the two discretisations differ by (1 % is seen), and the
    pressures that belong to slivers are shown four times too large; forces are right.
    """
    vertical, horizontal = ironed("mortar-p1", True)
    assert 0.28 < horizontal / vertical < 0.53
    assert vertical == pytest.approx(ironed("mortar-p1", False)[0], rel=0.03)


def test_steps_end_where_the_loading_turns() -> None:
    """Six steps for a path with corners at 0.25 and 0.5 of the time: the largest displacement is reached, whatever the
    number of steps, and frames that lie on corners are stored there."""
    path = [[0.0, 0.0], [0.25, 1.0], [0.5, -0.5], [1.0, 0.0]]
    mesh = {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [1, 1]}
    top = {"on": "b.top", "uy": {"ramp": "table", "to": 0.01, "points": path}}
    data = {
        "integrator": {"use": "newton", "steps": 6},
        "time": {"end": 1.0},
        "materials": {"m": {"use": "linear-elastic", "young": 1.0, "poisson": 0.0, "density": 1.0}},
        "bodies": {"b": {"element": "q1", "material": "m", "mesh": mesh}},
        "supports": [{"on": "b.bottom", "ux": 0.0, "uy": 0.0}, top],
        "record": {"recorders": [], "frames": 4},
    }
    results = simulate(Scene.from_data(data))
    times: Floats = np.asarray(results.history["time"])
    force = np.asarray(results.history["b.top.fy"])
    # the last step takes the last sixth of the way at once: the frame at 0.75 falls together with that of the end
    np.testing.assert_allclose(times, [0.0, 0.25, 0.5, 1.0], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(force, 0.01 * np.array([0.0, 1.0, -0.5, 0.0]), atol=1e-9)


def test_bodies_that_only_move_are_in_balance() -> None:
    """A hyperelastic block carried through space: forces of round-off are none, however stiff it is."""
    mesh = {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [6, 6]}
    data = {
        "integrator": {"use": "newton", "steps": 4},
        "materials": {"m": {"use": "neo-hookean", "young": 1e9, "poisson": 0.32, "density": 1.0}},
        "bodies": {"b": {"element": "q1", "material": "m", "mesh": mesh}},
        "supports": [{"on": "b.top", "ux": {"ramp": "linear", "to": 30.0}, "uy": {"ramp": "linear", "to": -0.3}}],
        "record": {"recorders": []},
    }
    results = simulate(Scene.from_data(data))
    assert results.status == "finished", results.reason
    np.testing.assert_allclose(results.displacement, np.tile([30.0, -0.3], (49, 1)), rtol=1e-9)
