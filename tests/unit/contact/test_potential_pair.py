"""A contact by a potential: a quadratic penalty, written as an outside author would, against closed forms."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.sparse import csr_array

from contactlab.api import Floats, NodalForces, Potential, PotentialView, Pressures
from contactlab.api.plugin import Part, hookimpl
from contactlab.errors import RequestError
from contactlab.model.build import build
from contactlab.parts.registry import Registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene


@dataclass(frozen=True)
class Springs(Potential):
    """Springs between slave nodes and a master that runs along x; differences give their second derivatives.

    k      [MPa/mm] pressure per overlap
    hand   whether the Hessian is given by hand
    shows  what is shown of its slave: the forces that act, or the same by `nodal_forces` or by `pressures`
    """

    k: float = 500.0
    hand: bool = True
    shows: str = "what acts"

    passes_patch_test: ClassVar[bool] = False
    rubs: ClassVar[bool] = True

    def overlaps(self, view: PotentialView, positions: Floats) -> tuple[Floats, Any]:
        """Overlaps (m,) >= 0, and their derivatives (m, 2n) by the positions."""
        m = len(view.slave.nodes)
        ends = view.edges[len(view.slave.segments) :, ::-1]  # along x: the master has its body below
        ends = ends[np.argsort(positions[ends[:, 0], 0])]
        x = positions[:m]
        at = np.clip(np.searchsorted(positions[ends[:, 0], 0], x[:, 0]) - 1, 0, len(ends) - 1)
        a, b = (ends[at, end] for end in range(2))
        span = positions[b] - positions[a]
        share, slope = (x[:, 0] - positions[a, 0]) / span[:, 0], span[:, 1] / span[:, 0]
        over = positions[a, 1] + share * span[:, 1] - x[:, 1]
        row = np.repeat(np.arange(m), 6)
        column = np.stack([2 * np.arange(m), 2 * np.arange(m) + 1, 2 * a, 2 * a + 1, 2 * b, 2 * b + 1], 1)
        value = np.stack([slope, -np.ones(m), -slope * (1 - share), 1 - share, -slope * share, share], 1)
        value[over < 0.0] = 0.0
        shape = (m, positions.size)
        return np.maximum(over, 0.0), csr_array((value.ravel(), (row, column.ravel())), shape=shape)

    def energy(self, view: PotentialView, positions: Floats) -> float:
        """k/2 times the squares of overlaps, over the tributary lengths."""
        over, _ = self.overlaps(view, positions)
        return float(0.5 * self.k * view.length[: len(over)] @ over**2)

    def gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Its derivative."""
        over, by = self.overlaps(view, positions)
        return np.asarray(by.T @ (self.k * view.length[: len(over)] * over)).reshape(-1, 2)

    def hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Without the change of slopes, which are nearly zero here."""
        if not self.hand:
            return None
        over, by = self.overlaps(view, positions)
        return by.T @ (by * (self.k * view.length[: len(over)])[:, None])

    def friction_gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Coulomb's friction along x, smooth below a slip of a millionth; the slave alone slides."""
        over, _ = self.overlaps(view, view.lagged)
        out = np.zeros_like(positions)
        slip = positions[: len(over), 0] - view.start[: len(over), 0]
        assert view.friction is not None
        force = view.friction.coefficient * self.k * view.length[: len(over)] * over
        out[: len(over), 0] = force * np.tanh(slip / 1e-6)
        return out

    def nodal_forces(self, view: PotentialView, positions: Floats) -> NodalForces | None:
        if self.shows != "forces":
            return None
        m = len(view.slave.nodes)
        return NodalForces(-self.gradient(view, positions)[:m], -self.friction_gradient(view, positions)[:m])

    def pressures(self, view: PotentialView, positions: Floats, normal: Floats, length: Floats) -> Pressures | None:
        if self.shows != "stresses":
            return None
        m, along = len(length), np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        push, rub = self.gradient(view, positions)[:m], self.friction_gradient(view, positions)[:m]
        return Pressures((push * normal).sum(axis=1) / length, -(rub * along).sum(axis=1) / length)


@hookimpl
def contactlab_parts() -> list[Part]:
    return [Part("contact", "springs", f"{__name__}:Springs", "quadratic penalty as a potential")]


@pytest.fixture
def registry() -> Registry:
    from contactlab.parts.loading import Origin, load

    found = Registry()
    found._add(load(Origin("springs", "a test"), lambda: sys.modules[__name__]))
    return found


WIDTH, DOWN = 2.0, 0.1
MODULUS = 1000.0 * 0.7 / (1.3 * 0.4)  # lambda + 2 mu of E = 1000, nu = 0.3


def pressed(registry: Registry, **changes: Any) -> Scene:
    """Two blocks, each 1 high, between smooth walls, pressed together by DOWN."""
    body = {"element": "q1", "material": "m"}
    data = {
        "name": "pressed",
        "time": {"end": 1.0, "ramp": 1.0},
        "integrator": {"use": "newton", "steps": 2},
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-6}},
        "bodies": {
            "upper": {**body, "mesh": {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, 1.0], "cells": [3, 1]}},
            "lower": {**body, "mesh": {"use": "rectangle", "x": [0.0, WIDTH], "y": [-1.0, 0.0], "cells": [3, 1]}},
        },
        "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "springs"}],
        "supports": [
            {"on": "lower", "ux": 0.0},
            {"on": "lower.bottom", "uy": 0.0},
            {"on": "upper", "ux": 0.0},
            {"on": "upper.top", "uy": {"ramp": "linear", "to": -DOWN}},
        ],
        "record": {"frames": 2},
    }
    return Scene.from_data(data, registry=registry).with_(changes)


def run(scene: Scene) -> Results:
    results = simulate(scene)
    assert results.status == "finished", results.reason
    return results


def test_pressed_blocks_agree_with_springs_in_series(registry: Registry) -> None:
    """u = p (2 H / M + 1 / k), with a Hessian by hand and by differences; curves and rows hold the same pressure."""
    pressure = DOWN / (2.0 / MODULUS + 1.0 / Springs.k)
    for hand in (True, False):
        results = run(pressed(registry, **{"contacts.0.algorithm": {"use": "springs", "hand": hand}}))
        assert results.summary["reactions"]["upper.top"][1] == pytest.approx(-pressure * WIDTH, rel=1e-7)
        curve = results.contact["contacts.0"].last
        np.testing.assert_allclose(curve.pressure, pressure, rtol=1e-7)
        np.testing.assert_allclose(curve.gap, -pressure / Springs.k, rtol=1e-7)
        resultant = results.summary["contacts"]["contacts.0"]["resultant"]
        np.testing.assert_allclose(resultant, [0.0, pressure * WIDTH], rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("shows", ["what acts", "forces", "stresses"])
def test_friction_bears_its_share_of_the_pressure_of_the_end(registry: Registry, shows: str) -> None:
    """A slave pushed sideways slides: shear is mu times the pressure of the end of the step, and is dissipated."""
    mu, side = 0.2, 1e-4  # far above the slip over which friction grows, far below a cell: nodes stay on nodes
    changes = {
        "contacts.0.algorithm": {"use": "springs", "shows": shows},
        "contacts.0.friction": {"use": "coulomb", "mu": mu},
        "supports.2.ux": {"ramp": "linear", "to": side},
        "time.history": True,
    }
    results = run(pressed(registry, **changes))
    pressure = DOWN / (2.0 / MODULUS + 1.0 / Springs.k)
    fx, fy = results.summary["reactions"]["upper"][0], results.summary["reactions"]["upper.top"][1]
    assert fy == pytest.approx(-pressure * WIDTH, rel=1e-4)
    curve = results.contact["contacts.0"].last
    np.testing.assert_allclose(curve.shear, -mu * curve.pressure, rtol=1e-7)  # normal forces lag by 1e-8
    # over two steps whose forces are half and all of it: the trapezoidal rule for work, ends of steps for dissipation
    whole = mu * pressure * WIDTH * side
    assert results.history["energy.friction"][-1] == pytest.approx(-0.5 * whole, rel=1e-3)
    assert results.history["energy.slip"][-1] == pytest.approx(0.75 * whole, rel=1e-3)
    assert fx == pytest.approx(mu * pressure * WIDTH, rel=1e-3)


@pytest.mark.parametrize(("side", "creep"), [(1e-4, []), (2e-7, [1.0])])
def test_nodes_that_stick_by_slipping_are_reported(registry: Registry, side: float, creep: list[float]) -> None:
    """All that moves in the second step is the slip over which friction grows: creep of 1; beyond it nodes slide."""
    aside = {"ramp": "table", "to": side, "points": [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]}
    down = {"ramp": "table", "to": -DOWN, "points": [[0.0, 0.0], [0.5, 1.0], [1.0, 1.0]]}
    friction = {"use": "coulomb", "mu": 0.2}
    changes = {"contacts.0.friction": friction, "supports.2.ux": aside, "supports.3.uy": down, "time.history": True}
    results = run(pressed(registry, **changes))
    found = [warning.value for warning in results.warnings if warning.code == "creep"]
    assert found == [pytest.approx(value, rel=1e-3) for value in creep]  # differences of positions 1e7 times larger


def test_a_block_that_falls_on_springs_goes_as_deep_as_an_oscillator(registry: Registry) -> None:
    """v sqrt(m / (k W)) deep after a quarter of a period; the end-of-step rule takes about w dt / 2 of the energy."""
    k, v, steps = 5.0, 20.0, 100
    mass = 1e-6 * WIDTH
    quarter = 0.5 * np.pi * np.sqrt(mass / (k * WIDTH))
    changes = {
        "contacts.0.algorithm": {"use": "springs", "k": k},
        "integrator": {"use": "implicit-dynamics", "steps": steps},
        "time.end": float(quarter),
        "materials.m.young": 1e5,
        "bodies.upper.velocity": [0.0, -v],
        "supports": [{"on": "lower", "ux": 0.0, "uy": 0.0}, {"on": "upper", "ux": 0.0}],
    }
    results = run(pressed(registry, **changes))
    depth = v * np.sqrt(mass / (k * WIDTH))
    # a step takes (w dt)^2 / 4 of it: 0.6 % of the depth in all; the block itself is 0.01 % as soft as the springs
    assert -results.contact["contacts.0"].last.gap.mean() == pytest.approx(depth, rel=0.01)
    held = 0.5 * k * WIDTH * depth**2
    assert results.history["energy.contact"][-1] == pytest.approx(-held, rel=0.02)
    assert np.abs(results.history["energy.error"]).max() < 1e-6


def test_a_step_that_fails_leaves_the_state_and_a_restart_continues_with_the_same_bits(registry: Registry) -> None:
    scene = pressed(
        registry,
        **{"contacts.0.friction": {"use": "coulomb", "mu": 0.2}, "supports.2.ux": {"ramp": "linear", "to": 0.05}},
    )
    model = build(scene, registry)
    step = model.bound_integrator().step
    assert not step(0.5).reason
    kept = model.state.snapshot()
    assert not step(0.5).reason
    after = model.state.snapshot()
    again = build(scene, registry)
    again.state.restore(kept)
    again.internal_force(0.0)
    assert not again.bound_integrator().step(0.5).reason
    np.testing.assert_array_equal(again.state.snapshot(), after)
    short = build(scene.with_({"integrator.iterations": 1}), registry)
    before = short.state.snapshot()
    assert short.bound_integrator().step(0.5).reason
    np.testing.assert_array_equal(short.state.snapshot(), before)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"integrator": "central-difference"}, "an explicit step has no use for it"),
        ({"contacts.0.start": {"overlap": "ramp"}}, "counts distances as they are"),
        ({"contacts.0.enforcement": "linear-pressure"}, "no use for another rule of the pressure"),
        ({"contacts.0.enforcement": "nitsche"}, "no use for another rule of the pressure"),
        ({"contacts.0.enforcement": "augmented-lagrangian"}, "no use for another rule of the pressure"),
        ({"contacts.0.corner": 30.0}, "no normals at nodes that a corner could split"),
    ],
)
def test_what_a_potential_cannot_do_is_refused(registry: Registry, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(RequestError, match=words):
        build(pressed(registry, **changes), registry)
