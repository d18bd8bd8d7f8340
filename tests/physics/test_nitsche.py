"""Nitsche's method: an even pressure passes, derivatives are exact, and it tends to mortar multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.api import Floats
from contactlab.errors import PartError, SceneError
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

E, NU, PUSH, WIDTH = 1000.0, 0.3, 0.01, 2.0


_SIDES = ("left", "right")


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
@pytest.mark.parametrize(("theta", "gamma"), [(0, 2.25), (0, 1000.0), (1, 10.0), (-1, 0.1), (-1, 1000.0)])
def test_an_even_pressure_passes(element: str, theta: int, gamma: float) -> None:
    """Uniform stress is in the space: plane strain E/(1 - nu^2) times PUSH over both heights, to round-off.

    The gap is zero as well: the method is consistent, and springs would leave p over their stiffness, 1e-3 mm here.
    """
    results = simulate(blocks(element, "linear-elastic", **{"contacts.0.enforcement": given(gamma, theta=theta)}))
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


def apart(one: Results, other: Results, pressures: bool = True) -> tuple[float, float]:
    """Relative differences of the reactions, and of the pressures in the mean square."""
    force = [float(r.summary["reactions"]["block.bottom"][1]) for r in (one, other)]
    if not pressures:
        return abs(force[0] / force[1] - 1.0), np.nan
    p, q = (np.asarray(next(iter(r.contact.values())).last.pressure) for r in (one, other))
    return abs(force[0] / force[1] - 1.0), float(np.sqrt(((p - q) ** 2).sum() / (q**2).sum()))


def test_forces_of_the_symmetric_variant_have_a_potential() -> None:
    """It is the sum of length (p^2 - sigma^2) / (2 gamma k): Chouly, Hild & Renard 2015, section 2.2.

    Strains of 1e-6 leave as much to the motion of lengths and normals; forces along stresses do 2 % of the work.
    """
    model: Any = build(
        blocks("q2", "linear-elastic", **{"contacts.0.enforcement": given(10.0, theta=1)}), default_registry()
    )
    contact, u = model.contact, model.state["displacement"]
    rng = np.random.default_rng(5)
    at, along = 1e-6 * rng.uniform(-1.0, 1.0, (2, *u.shape))
    own, gamma_k = contact.enforcement, 10.0 * contact.enforcement.stiffness

    def moved(share: float) -> tuple[float, Floats]:
        u[:] = at + share * along
        model.begin_step(1.0)
        model.internal_force(1.0)
        contact.evaluate(model.position)
        pressure = np.maximum(0.0, -own.traction - gamma_k * contact.conditions.gap)
        contact.conditions.force[0] = pressure * contact.length
        normal, tangential = np.zeros_like(u), np.zeros((0, 2))
        contact.forces(normal, tangential)
        return float((contact.length * (pressure**2 - own.traction**2) / (2.0 * gamma_k)).sum()), normal

    forces = moved(0.0)[1]
    pressed = contact.conditions.force[0] > 0.0
    assert 1 < np.count_nonzero(pressed) < len(pressed)
    difference = moved(1e-3)[0] - moved(-1e-3)[0]
    assert -2e-3 * float(np.vdot(forces, along)) == pytest.approx(difference, rel=1e-4, abs=0.0)


def test_it_tends_to_multipliers_of_the_same_rows() -> None:
    """With the mesh (gamma = 2.25, where there is most to see), and as 1/gamma on each.

    The block is the slave, whose cells are the coarser ones.
    """
    exact = {level: disc("active-set", True, level) for level in (1, 2)}
    found = {level: apart(disc(given(2.25), True, level), exact[level]) for level in (1, 2)}
    assert max(found[2]) < 0.03
    assert found[2][0] < found[1][0] / 2.0
    assert found[2][1] < found[1][1] / 2.0
    stiff = apart(disc(given(100.0), True, 2), exact[2])
    assert max(stiff) < 3e-2 * max(found[2])


VARIANTS = [(theta, element) for theta in (-1, 0, 1) for element in ("q1", "q2")]


@pytest.mark.parametrize("swap", some([False, True], [False]))
def test_the_skew_variant_is_right_for_any_gamma(swap: bool) -> None:
    """From 0.01 to 100 times the default, reaction and pressure differ by no more than a coarse mesh does.

    Errors of the mesh: of multipliers at level 1 against level 2, and 2.5 and 1.8 % of pressures against the reference
    (docs/methods.md).
    """
    deep = {"swap": swap, "depth": 0.1581, "steps": 5}
    exact, fine = disc("active-set", level=1, **deep), disc("active-set", level=2, **{**deep, "steps": 1})
    by_mesh = apart(exact, fine, pressures=False)[0]
    for gamma in (0.1, 10.0, 1000.0):
        found = disc(given(gamma, theta=-1), level=1, **deep)
        assert apart(found, fine, pressures=False)[0] <= by_mesh * 1.001  # gamma = 1000 is the mortar but for 5e-6
        assert apart(found, exact)[1] < 0.013
        assert len(found.iterations) <= 50  # the mortar: 24; second derivatives of tractions are left out
        assert not any("not stable" in str(warning) for warning in found.warnings)


@pytest.mark.parametrize(("theta", "element"), some(VARIANTS, [(-1, "q1"), (0, "q2"), (1, "q1")]))
@pytest.mark.parametrize("slides", [False, True])
def test_an_even_shear_passes_with_friction(element: str, theta: int, slides: bool) -> None:
    """Uniform pressure p and shear s: s = G U / 2 H below mu p; else s = mu p, and the rest of U is slip.

    Sides carry the shear as a load; nu = 0, so that tops keep their widths. Strains of 1e-6 leave as much.
    """
    push, mu = 1e-6, 0.4
    p = E * push / 2.0
    across = 2.0 * mu * p / (0.5 * E)  # where it begins to slide
    moved = across * (1.5 if slides else 0.5)
    shear = mu * p * (1.0 if slides else 0.5)
    scene = data(element, "linear-elastic")
    scene["materials"]["m"]["poisson"] = 0.0
    scene["contacts"][0] |= {"enforcement": given(10.0, theta=theta), "friction": {"use": "coulomb", "mu": mu}}
    scene["supports"] = [
        {"on": "upper.top", "uy": -push, "ux": moved}, {"on": "lower.bottom", "uy": 0.0, "ux": 0.0}
    ]  # fmt: skip
    scene["loads"] = [{"on": f"{body}.{side}", "shear": shear} for body in ("upper", "lower") for side in _SIDES]
    results = simulate(contactlab.Scene.from_data(scene))
    assert results.status == "finished", results.reason
    last = results.contact["contacts.0"].last
    np.testing.assert_allclose(last.pressure, p, rtol=1e-5)
    np.testing.assert_allclose(np.abs(last.shear), shear, rtol=1e-5)
    assert set(last.state) == {2 if slides else 1}
    exact = np.stack([(results.nodes[:, 1] + 1.0) * shear / (0.5 * E), -(results.nodes[:, 1] + 1.0) * p / E], axis=1)
    above = np.abs(results.displacement[:, 0] - exact[:, 0]) > 0.25 * across
    assert above.any() == slides
    exact[above, 0] += moved - across
    np.testing.assert_allclose(results.displacement, exact, rtol=0.0, atol=1e-5 * across)


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


def test_a_load_on_the_slave_is_refused_and_one_on_the_master_will_do() -> None:
    """Behind a loaded slave the stress is that of the load and of the contact together."""
    loaded = data("q1", "linear-elastic") | {"loads": [{"on": "upper.bottom", "ty": {"ramp": "linear", "to": 1.0}}]}
    with pytest.raises(SceneError, match="a load acts on the slave as well"):
        build(contactlab.Scene.from_data(loaded), default_registry())
    build(contactlab.Scene.from_data(loaded).with_({"contacts.0.swap": True}), default_registry())


@pytest.mark.parametrize(
    ("enforcement", "words"),
    [
        (given(2.0), r"got\s+2.0\s+allowed\s+2.25 and above with theta = 0"),
        (given(8.9, theta=1), r"allowed\s+9 and above with theta = 1"),
        (given(0.0, theta=-1), r"allowed\s+above 0"),
        (given(10.0, theta=2), r"got\s+2\s+allowed\s+0, 1 or -1"),
        (given(10.0, theta=0.5), r"theta.*"),
    ],
)
def test_numbers_that_hold_nothing_are_refused(enforcement: dict[str, Any], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        build(blocks("q1", "linear-elastic", **{"contacts.0.enforcement": enforcement}), default_registry())


@pytest.mark.parametrize(("element", "most"), [("q1", 4.0), ("q2", 9.0)])
def test_edge_stresses_are_bounded_by_the_energy_of_cells(element: str, most: float) -> None:
    """Their square is below (q + 1)^2 times the energy, from which limits of gamma follow, and q^2 where nu = 0.

    Incompressible cells reach the bound.
    """
    for poisson in (0.0, 0.3, 0.499):
        for width in (0.1, 1.0, 10.0):
            found = _largest_stress(element, poisson, width)
            assert found < most, (poisson, width)
            if poisson == 0.0:
                assert found == pytest.approx((np.sqrt(most) - 1.0) ** 2, rel=1e-9)
    assert _largest_stress(element, 0.499, 0.1) > 0.99 * most


def _largest_stress(element: str, poisson: float, width: float) -> float:
    """Largest sum of length * traction^2 over k times twice the energy, of a cell 1 mm high."""
    cell = data(element, "linear-elastic")
    cell["bodies"]["upper"]["mesh"] = {"use": "rectangle", "x": [0.0, width], "y": [0.0, 1.0], "cells": [1, 1]}
    cell["bodies"]["lower"]["mesh"] |= {"x": [0.0, width]}
    cell["materials"]["m"]["poisson"] = poisson
    model: Any = build(contactlab.Scene.from_data(cell), default_registry())
    model.begin_step(1.0)
    model.internal_force(1.0)
    model.contact.evaluate(model.position)
    size, own = 2 * model.bodies[0].count, model.contact.enforcement
    stiffness = model.stiffness(1.0).toarray()[:size, :size]
    by_node = own.tractions.derivative().toarray()[:, :size] * np.sqrt(model.contact.length / own.stiffness)[:, None]
    value, vector = np.linalg.eigh(stiffness)
    stretched = value > 1e-9 * value.max()
    return float(np.linalg.norm(by_node @ (vector[:, stretched] / np.sqrt(value[stretched])), 2) ** 2)
