"""Statics from coarse meshes to fine: the same end as load steps give, and nothing said that was not followed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.api import Estimate
from contactlab.api.meshing import structured
from contactlab.errors import SimulationFailure
from contactlab.meshing.locate import located
from contactlab.model.prolongation import Prolongation
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run import nested
from contactlab.run.nested import coarser_levels
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene


def disc(**changes: Any) -> Scene:
    """A coarser disc-on-block in statics; level 2 has two thirds of the bundled cells along each side."""
    cells = {"bodies.disc.mesh.cells": [16, 4], "bodies.block.mesh.cells": [24, 4]}
    return contactlab.load_scene("disc-on-block").with_({"integrator": "newton", "level": 2} | cells | changes)


def reaction(results: Results) -> float:
    return float(results.summary["reactions"]["block.bottom"][1])


def pressure(results: Results) -> np.ndarray:
    return np.asarray(results.contact["contacts.0"].last.pressure)


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
@pytest.mark.parametrize("swap", [False, True], ids=["disc-slave", "block-slave"])
def test_the_end_is_that_of_load_steps(algorithm: str, swap: bool) -> None:
    """Elastic and frictionless: one solution to the tolerance, whatever the iteration began with."""
    keys = {"contacts.0.algorithm": algorithm, "contacts.0.swap": swap}
    found = simulate(disc(**keys))
    steps = simulate(disc(**keys, integrator={"use": "newton", "steps": 2}))
    assert found.status == steps.status == "finished"
    assert found.summary["iterations"] <= 4, "the prolonged end is right but for a few nodes"
    assert reaction(found) == pytest.approx(reaction(steps), rel=1e-7)
    np.testing.assert_allclose(pressure(found), pressure(steps), atol=1e-6 * pressure(steps).max(), rtol=0.0)


def test_iterations_do_not_grow_with_the_level() -> None:
    """What a single load step from rest cannot do: on the bundled mesh it takes 9 at level 2 and 16 at level 4."""
    for level in (2, 4):
        assert simulate(disc(level=level)).summary["iterations"] <= 4


def test_a_nested_run_says_what_it_is() -> None:
    results = simulate(disc())
    summary = results.summary
    assert summary["history"] == {"matters": False, "because": [], "curve": "the end only"}
    assert [level["level"] for level in summary["nested"]] == [1]
    assert results.history["time"].tolist() == [0.0, 1.0]
    # work along a way that nobody followed is not known; what is stored at its end is
    assert summary["balance"]["internal"] is None
    assert summary["balance"]["ledger_error"] is None
    followed = simulate(disc(**{"integrator.steps": 20, "level": 1}))
    assert followed.summary["balance"]["stored"] == pytest.approx(followed.summary["balance"]["internal"], rel=4e-3)
    alone = simulate(disc(level=1))
    assert alone.summary["balance"]["stored"] == pytest.approx(followed.summary["balance"]["stored"], rel=1e-7)


@pytest.mark.parametrize(
    ("keys", "because"),
    [
        ({"time.history": True}, "time.history"),
        ({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}, "contacts.0.friction"),
        ({"integrator.nested": False}, None),
        ({"integrator.steps": 4}, None),
        ({"time.step": 0.5}, None),
    ],
)
def test_the_way_is_followed_where_it_matters_or_is_asked_for(keys: dict[str, Any], because: str | None) -> None:
    results = simulate(disc(level=1, **{"supports.1.uy.to": -0.01}, **keys))
    assert results.summary["history"]["curve"] == "quasi-static"
    assert results.summary["history"]["because"] == ([because] if because else [])
    assert results.summary["steps"] >= 2
    assert results.summary["balance"]["ledger_error"] < 1e-9


def test_a_law_with_history_is_followed() -> None:
    law = {"use": "power-law", "strength": 348.0, "prestrain": 0.02, "exponent": 0.03}
    soft = {f"materials.soft.{key}": value for key, value in law.items()}
    results = simulate(disc(level=1, **soft, **{"supports.1.uy.to": -0.002}))
    assert results.summary["history"]["because"] == ["bodies.block.material"]
    assert results.summary["steps"] == 10


def test_a_loading_that_turns_is_solved_where_it_turns() -> None:
    """Down and half-way up again: a step to each corner, each with an estimate of its own."""
    uy = {"ramp": "table", "to": -0.05, "points": [[0.0, 0.0], [0.5, 1.0], [1.0, 0.5]]}
    keys = {"time.end": 1.0, "supports.1.uy": uy}
    found, steps = simulate(disc(**keys)), simulate(disc(**keys, **{"integrator.steps": 4}))
    assert found.summary["steps"] == 2
    assert reaction(found) == pytest.approx(reaction(steps), rel=1e-7)
    assert found.history["time"].tolist() == [0.0, 0.5, 1.0]
    half = np.flatnonzero(np.isclose(steps.history["time"], 0.5))[0]
    assert found.history["block.bottom.fy"][1] == pytest.approx(steps.history["block.bottom.fy"][half], rel=1e-7)


def test_a_finest_level_that_fails_follows_the_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """An estimate of nothing, and too few iterations to find the end at once: load steps find it, and their work."""
    monkeypatch.setattr(
        Prolongation,
        "estimate",
        lambda self, time, u, p: Estimate(time, np.zeros(self.shape), np.zeros(self.multipliers)),
    )
    scene = disc(**{"supports.1.uy.to": -0.05, "integrator": {"use": "newton", "iterations": 3}})
    results, expected = simulate(scene), simulate(scene.with_({"integrator": {"use": "newton", "steps": 2}}))
    assert results.status == expected.status == "finished"
    assert reaction(results) == pytest.approx(reaction(expected), rel=1e-7)
    assert "rejected after" in results.events[1].text
    assert results.summary["history"]["curve"] == "quasi-static"
    assert results.summary["balance"]["ledger_error"] < 1e-9


def test_a_coarser_level_that_fails_is_told_and_the_way_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> None:
        raise SimulationFailure("not-converged", "for a test")

    monkeypatch.setattr(nested, "_solved", fails)
    results = simulate(disc(**{"supports.1.uy.to": -0.01}))
    assert results.status == "finished"
    assert results.events[0].level == "warning"
    assert "level 1 was tried first, not solved" in results.events[0].text
    assert results.summary["steps"] == 10
    assert results.summary["history"]["curve"] == "quasi-static"


@pytest.mark.parametrize("element", ["q1", "q2"])
def test_points_are_located_and_values_prolonged_to_the_degree_of_the_element(element: str) -> None:
    """On a sheared and graded grid the element's own polynomials come back at the nodes of another mesh."""
    part = default_registry().make("element", element)
    coarse, fine = (structured(part, (3 * n, 2 * n), lambda s, t: (2.0 * s + 0.5 * t, t + 0.2 * s)) for n in (1, 5))
    cells, places = located(coarse, part, fine.nodes)
    assert np.abs(places).max() <= 1.0 + 1e-9
    values = part.shape(places).value

    def polynomial(x: np.ndarray) -> np.ndarray:
        return 1.0 + 2.0 * x[:, 0] - x[:, 1] + (part.degree - 1) * x[:, 0] * x[:, 1] ** (part.degree - 1)

    found = np.einsum("na,na->n", values, polynomial(coarse.nodes)[coarse.cells[cells]])
    np.testing.assert_allclose(found, polynomial(fine.nodes), atol=1e-12)


def test_levels_are_halved() -> None:
    assert coarser_levels(1) == []
    assert coarser_levels(8) == [1, 2, 4]
    assert coarser_levels(11) == [1, 2, 5]
