"""Nitsche's method: an even pressure passes, tractions have exact derivatives, and it tends to mortar multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.api import Floats
from contactlab.errors import PartError, SceneError
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

E, NU, PUSH, WIDTH = 1000.0, 0.3, 0.01, 2.0


def data(element: str, law: str, cells: tuple[int, int] = (5, 4)) -> dict[str, Any]:
    """Two blocks 1 mm high, two cells each, free on their right; five cells above stand on four below."""
    body = {"element": element, "material": "m"}
    mesh = {"use": "rectangle", "x": [0.0, WIDTH]}
    return {
        "integrator": "newton",
        "materials": {"m": {"use": law, "young": E, "poisson": NU, "density": 1e-6}},
        "bodies": {
            "upper": body | {"mesh": mesh | {"y": [0.0, 1.0], "cells": [cells[0], 2]}},
            "lower": body | {"mesh": mesh | {"y": [-1.0, 0.0], "cells": [cells[1], 2]}},
        },
        "contacts": [
            {"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p1", "enforcement": "nitsche"}
        ],
        "supports": [
            {"on": "upper.top", "uy": -PUSH}, {"on": "lower.bottom", "uy": 0.0},
            {"on": "upper.left", "ux": 0.0}, {"on": "lower.left", "ux": 0.0},
        ],
    }  # fmt: skip


def blocks(element: str, law: str, cells: tuple[int, int] = (5, 4), **changes: Any) -> contactlab.Scene:
    scene = contactlab.Scene.from_data(data(element, law, cells))
    return scene.with_(changes) if changes else scene


@pytest.mark.parametrize("element", ["q1", "q2"])
@pytest.mark.parametrize("gamma", [1.0, 1000.0])
def test_an_even_pressure_passes(element: str, gamma: float) -> None:
    """Uniform stress is in the space: plane strain E/(1 - nu^2) times PUSH over both heights, to round-off.

    The gap is zero as well: the method is consistent, and springs would leave p over their stiffness, 1e-3 mm here.
    """
    results = simulate(blocks(element, "linear-elastic", **{"contacts.0.enforcement": given(gamma)}))
    assert results.status == "finished", results.reason
    force = WIDTH * E / (1.0 - NU**2) * PUSH / 2.0
    assert -results.summary["reactions"]["upper.top"][1] == pytest.approx(force, rel=1e-10)
    last = results.contact["contacts.0"].last
    assert np.ptp(last.pressure) < 1e-11 * np.max(last.pressure)
    assert np.abs(last.gap).max() < 1e-12


def given(gamma: float, **more: Any) -> dict[str, Any]:
    return {"use": "nitsche", "gamma": gamma} | more


@pytest.mark.parametrize(("element", "law"), [("q1", "hypoelastic"), ("q2", "neo-hookean"), ("q2", "linear-elastic")])
def test_tractions_have_exact_derivatives(element: str, law: str) -> None:
    """Against central differences on a crooked state with strains of a fifth: 1e-6 mm leaves 1e-9."""
    model: Any = build(blocks(element, law, cells=(2, 2)), default_registry())
    u = model.state["displacement"]
    at = 0.05 * np.random.default_rng(3).uniform(-1.0, 1.0, u.shape)
    tractions = model.contact.enforcement.tractions

    def values(displacement: Floats) -> Floats:
        u[:] = displacement
        model.internal_force(1.0)
        return np.asarray(tractions.values())

    values(at)
    found, step = tractions.derivative().toarray(), 1e-6
    assert np.abs(found).max() > E
    for column in np.flatnonzero(np.abs(found).any(axis=0))[::3]:
        moved = np.zeros_like(at)
        moved.reshape(-1)[column] = step
        expected = (values(at + moved) - values(at - moved)) / (2.0 * step)
        np.testing.assert_allclose(found[:, column], expected, rtol=0.0, atol=1e-8 * np.abs(found).max())


def disc(enforcement: Any, swap: bool, level: int, depth: float = 0.01, steps: int = 1) -> Results:
    results = simulate(
        contactlab.load_scene("disc-on-block").with_(
            {
                "level": level, "integrator": {"use": "newton", "steps": steps}, "supports.1.uy.to": -depth,
                "contacts.0.algorithm": "mortar-p1", "contacts.0.swap": swap, "contacts.0.enforcement": enforcement,
                "record.frames": 1,
            }
        )
    )  # fmt: skip
    assert results.status == "finished", results.reason
    return results


def apart(one: Results, other: Results) -> tuple[float, float]:
    """Relative differences of the reactions, and of the pressures in the mean square."""
    force = [float(r.summary["reactions"]["block.bottom"][1]) for r in (one, other)]
    p, q = (np.asarray(next(iter(r.contact.values())).last.pressure) for r in (one, other))
    return abs(force[0] / force[1] - 1.0), float(np.sqrt(((p - q) ** 2).sum() / (q**2).sum()))


def test_it_tends_to_multipliers_of_the_same_rows() -> None:
    """With the mesh (gamma = 1, where there is most to see: 2.3 and 3.2 times less a level), and as 1/gamma on each.

    The block is the slave, whose cells are the coarser ones.
    """
    exact = {level: disc("active-set", True, level) for level in (1, 2)}
    found = {level: apart(disc(given(1.0), True, level), exact[level]) for level in (1, 2)}
    assert max(found[2]) < 0.03
    assert found[2][0] < found[1][0] / 2.0
    assert found[2][1] < found[1][1] / 2.0
    stiff = apart(disc(given(100.0), True, 2), exact[2])
    assert max(stiff) < 1.5e-2 * max(found[2])


def test_newton_converges_quadratically() -> None:
    """Deep, as tests of the mortars do it: the log ratio of three residuals is 2 once statuses are settled."""
    rows = disc(given(10.0), False, 2, depth=0.1581, steps=5).iterations
    assert len(rows) <= 35  # mortar: 25
    ratios = []
    for first, second, third in zip(rows, rows[1:], rows[2:], strict=False):
        settled = second.changed == third.changed == 0 and first.step == third.step and second.force < first.force
        if settled and first.force < 5e-3 and third.force > 1e-13:
            ratios.append(np.log(third.force / second.force) / np.log(second.force / first.force))
    assert len(ratios) >= 2
    assert np.median(ratios) == pytest.approx(2.0, abs=0.25)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"integrator": "central-difference"}, "an integrator of statics"),
        ({"integrator": "implicit-dynamics"}, "an integrator of statics"),
        ({"bodies.upper.element": "q1-fbar"}, "take q1 or q2 there"),
        ({"bodies.upper.element": "q1-reduced"}, "take q1 or q2 there"),
    ],
)
def test_what_it_cannot_do_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(PartError, match=words):
        build(blocks("q1", "linear-elastic", **changes), default_registry())


def test_a_rigid_master_will_do_and_a_rigid_slave_is_refused() -> None:
    on_floor = data("q1", "linear-elastic")
    del on_floor["bodies"]["lower"]
    contact = on_floor["contacts"][0] | {"master": "floor"}
    on_floor |= {"rigid": {"floor": {"line": [[3.0, 0.0], [-1.0, 0.0]]}}, "supports": on_floor["supports"][::2]}
    results = simulate(contactlab.Scene.from_data(on_floor | {"contacts": [contact]}))
    force = WIDTH * E / (1.0 - NU**2) * PUSH
    assert -results.summary["reactions"]["upper.top"][1] == pytest.approx(force, rel=1e-10)
    with pytest.raises(SceneError, match="swap"):
        build(contactlab.Scene.from_data(on_floor | {"contacts": [contact | {"swap": True}]}), default_registry())


def test_a_gamma_that_holds_nothing_is_refused() -> None:
    with pytest.raises(SceneError, match="1 and above"):
        build(blocks("q1", "linear-elastic", **{"contacts.0.enforcement": given(0.5)}), default_registry())
