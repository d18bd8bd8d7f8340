"""Contact on the common line: patch test, exchange of sides, penetration, derivatives, friction, impact, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_segments.midplane import Midplane
from tiers import some

from contactlab import load_scene, simulate
from contactlab.contact.potential_pair import differences
from contactlab.errors import RequestError
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.scene.scene import Scene
from contactlab.studies.measures import pressure_error
from contactlab.studies.profile import Profile
from contactlab.studies.reference import load_reference
from contactlab.testing.surfaces import curved, pair_of

YOUNG, WIDTH, DOWN = 1000.0, 2.0, 0.1
ROUND_OFF = 1e-12
SWAP = 1e-10  # of the largest displacement: Newton's iteration ends at 1e-8 and converges quadratically


def blocks(cells: tuple[int, int] = (3, 4), **changes: Any) -> Scene:
    """Two blocks of nu = 0, each 1 high, the upper one pressed down by DOWN; two and three layers of cells."""
    body = {"element": "q1", "material": "m"}
    upper = {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, 1.0], "cells": [cells[0], 2]}
    lower = {"use": "rectangle", "x": [0.0, WIDTH], "y": [-1.0, 0.0], "cells": [cells[1], 3]}
    return Scene.from_data(
        {
            "name": "blocks",
            "time": {"end": 1.0, "ramp": 1.0},
            "integrator": {"use": "newton", "steps": 2},
            "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1e-6}},
            "bodies": {"upper": {**body, "mesh": upper}, "lower": {**body, "mesh": lower}},
            "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "midplane"}],
            "supports": [
                {"on": "lower.bottom", "uy": 0.0},
                {"on": "lower.left", "ux": 0.0},
                {"on": "upper.left", "ux": 0.0},
                {"on": "upper.top", "uy": {"ramp": "linear", "to": -DOWN}},
            ],
            "record": {"frames": 2, "recorders": []},
        }
    ).with_(changes)


def disc(**changes: Any) -> Scene:
    return load_scene("disc-on-block").with_(
        {"integrator": "newton", "record.recorders": [], "contacts.0.algorithm": "midplane", **changes}
    )


def run(scene: Scene) -> Results:
    results = simulate(scene)
    assert results.status == "finished", results.reason
    return results


# --- patch test and law ---------------------------------------------------------------------------


@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize(("element", "cells"), [("q1", (3, 4)), ("q1", (1, 5)), ("q1", (7, 2)), ("q2", (2, 3))])
def test_a_uniform_pressure_passes_to_round_off(element: str, cells: tuple[int, int], swap: bool) -> None:
    """At the nodes of either side, with meshes that do not match: p = DOWN / (2 / E + 1 / k), k from the cells."""
    bodies = {f"bodies.{name}.element": element for name in ("upper", "lower")}
    results = run(blocks(cells, **bodies, **{"contacts.0.swap": swap}))
    stiffness = Midplane().stiffness * YOUNG / (1.0 / 2.0 + 1.0 / 3.0)  # in series: depths of cells 1/2 and 1/3
    pressure = DOWN / (2.0 / YOUNG + 1.0 / stiffness)
    curve = results.contact["contacts.0"].last
    np.testing.assert_allclose(curve.pressure, pressure, rtol=ROUND_OFF)
    np.testing.assert_allclose(
        curve.gap, -pressure / stiffness, rtol=1e-9
    )  # differences of positions a thousand larger
    assert results.summary["reactions"]["upper.top"][1] == pytest.approx(-pressure * WIDTH, rel=ROUND_OFF)


@pytest.mark.parametrize(("layers", "told"), [(1, True), (4, False)])
def test_what_overlaps_take_from_the_force_is_told_from_a_hundredth_on(layers: int, told: bool) -> None:
    """p 2h/30M of overlap beside p 2H/E of strain: twice the share of the push that bodies do not feel."""
    cells = {f"bodies.{name}.mesh.cells": [2, layers] for name in ("upper", "lower")}
    results = run(blocks(**cells))
    share = 1.0 / (30.0 * layers)
    assert results.summary["reactions"]["lower.bottom"][1] == pytest.approx(
        0.5 * YOUNG * DOWN * WIDTH / (1.0 + share), rel=1e-9
    )
    found = {warning.code: warning.value for warning in results.warnings if warning.code == "kept-overlap"}
    assert found == ({"kept-overlap": pytest.approx(2.0 * share, rel=1e-9)} if told else {})


def test_overlaps_of_contacts_in_series_add_up() -> None:
    """Four layers of cells between floor and lid: p h/30M at each, below the limit, of p H/E."""
    walls = {"floor": {"line": [[WIDTH, 0.0], [0.0, 0.0]]}}
    walls["lid"] = {"line": [[0.0, 1.0], [WIDTH, 1.0]], "uy": {"ramp": "linear", "to": -0.01}}
    both = [{"slave": f"b.{s}", "master": m, "algorithm": "midplane"} for s, m in (("bottom", "floor"), ("top", "lid"))]
    mesh = {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, 1.0], "cells": [2, 4]}
    held = [{"on": "b.left", "ux": 0.0}]
    bodies = {"b": {"element": "q1", "material": "m", "mesh": mesh}}
    results = run(blocks(bodies=bodies, rigid=walls, contacts=both, supports=held))
    share = 2.0 / (30.0 * 4.0)
    assert abs(results.summary["reactions"]["lid"][1]) == pytest.approx(YOUNG * 0.01 * WIDTH / (1.0 + share), rel=1e-9)
    (warning,) = results.warnings
    assert (warning.code, warning.value) == ("kept-overlap", pytest.approx(2.0 * share, rel=1e-9))


def test_the_patch_stays_uniform_under_finite_strain_and_contraction() -> None:
    """Sides that contract by nu and are turned: forces are those of undeformed lengths, of both sides alike."""
    changes = {"materials.m": {"use": "neo-hookean", "young": YOUNG, "poisson": 0.3, "density": 1e-6}}
    curve = run(blocks(**changes)).contact["contacts.0"].last
    assert np.ptp(curve.pressure) < ROUND_OFF * curve.pressure.mean()


def test_what_lies_on_something_is_held_from_the_start() -> None:
    """A load presses a block that only touches another: a gap of zero is stiff, or nothing would hold the block."""
    pressure = 10.0
    supports = [{"on": "lower.bottom", "uy": 0.0}, {"on": "lower.left", "ux": 0.0}, {"on": "upper.left", "ux": 0.0}]
    results = run(blocks(**{"supports": supports, "loads": [{"on": "upper.top", "pressure": pressure}]}))
    stiffness = Midplane().stiffness * YOUNG / (1.0 / 2.0 + 1.0 / 3.0)
    curve = results.contact["contacts.0"].last
    np.testing.assert_allclose(curve.gap, -pressure / stiffness, rtol=1e-9)
    assert results.summary["reactions"]["lower.bottom"][1] == pytest.approx(pressure * WIDTH, rel=1e-9)


# --- neither side is the slave --------------------------------------------------------------------


@pytest.mark.parametrize("friction", [None, {"use": "coulomb", "mu": 0.3}])
def test_nothing_changes_when_slave_and_master_are_exchanged(friction: Any) -> None:
    """Displacements and reactions of the same disc; the sides are only numbered and summed in another order."""
    scene = disc(**{"supports.1.uy.to": -0.05, "contacts.0.friction": friction, "integrator.steps": 2})
    one, other = (run(scene.with_({"contacts.0.swap": swap})) for swap in (False, True))
    assert np.abs(one.displacement - other.displacement).max() < SWAP * np.abs(one.displacement).max()
    first, second = (np.array(found.summary["reactions"]["disc.top"]) for found in (one, other))
    assert np.abs(first - second).max() < SWAP * np.abs(first).max()


def test_energy_and_forces_of_exchanged_sides_are_equal_to_round_off() -> None:
    """Curved sides that cover each other in part."""
    at, part = curved(), Midplane()
    view = pair_of(part, at)[0].view
    exchanged = type(at)(at.nodes, at.master, at.slave)
    back = pair_of(part, exchanged)[0].view
    m, n = len(at.slave.nodes), len(at.master.nodes)
    assert part.energy(view, view.reference) > 0.0
    assert part.energy(view, view.reference) == pytest.approx(part.energy(back, back.reference), rel=1e-13)
    force, turned = part.gradient(view, view.reference), part.gradient(back, back.reference)
    np.testing.assert_allclose(force[:m], turned[n:], atol=1e-13 * np.abs(force).max())
    np.testing.assert_allclose(force[m:], turned[:n], atol=1e-13 * np.abs(force).max())


# --- accuracy -------------------------------------------------------------------------------------


def test_reactions_and_pressures_of_a_disc_approach_those_of_a_mortar() -> None:
    """Half the difference on half the mesh, as overlaps are of the size of cells; pressures nearly as accurate."""
    reference = load_reference("disc-on-block-deep")
    off, error = [], {}
    for level in (1, 2):
        force = {}
        for algorithm in ("midplane", "mortar-p1"):
            keys = {"contacts.0.algorithm": algorithm, "level": level, "supports.1.uy.to": -0.1581}
            results = run(disc(**keys, **{"integrator": {"use": "newton", "steps": 1}}))
            force[algorithm] = results.summary["reactions"]["disc.top"][1]
            curve = results.contact["contacts.0"].last
            found = Profile.of_nodes(np.asarray(curve.x), np.nan_to_num(curve.pressure))
            error[algorithm, level] = pressure_error(found, reference.profile, reference.window)
        off.append(abs(force["midplane"] / force["mortar-p1"] - 1.0))
    assert off[0] < 0.01
    assert off[1] == pytest.approx(0.5 * off[0], rel=0.15)  # first order, next to errors of second order
    for level in (1, 2):
        assert error["midplane", level] < 1.6 * error["mortar-p1", level]
    assert error["midplane", 2] < 0.6 * error["midplane", 1]


@pytest.mark.parametrize("factor", some([0.1, 10.0], [0.1]))
def test_a_tenth_and_ten_times_the_stiffness_run(factor: float) -> None:
    """Overlaps are inverse to it, and so is the difference of the reaction from that of a mortar."""
    depth = {"supports.1.uy.to": -0.1581}
    part = {"use": "midplane", "stiffness": factor * Midplane().stiffness}
    mortar = run(disc(**depth, **{"contacts.0.algorithm": "mortar-p1"})).summary["reactions"]["disc.top"][1]
    usual = run(disc(**depth)).summary["reactions"]["disc.top"][1]
    found = run(disc(**depth, **{"contacts.0.algorithm": part})).summary["reactions"]["disc.top"][1]
    ratio = (1.0 - found / mortar) / (1.0 - usual / mortar)
    assert (8.0 < ratio < 11.0) if factor < 1.0 else (abs(ratio) < 0.2)


def test_forces_and_stiffness_are_derivatives_of_the_energy_between_curved_sides() -> None:
    """Central differences, whose error is that of round-off over the step; kinks are of third order in overlaps."""
    at, part = curved(), Midplane()
    view = pair_of(part, at)[0].view
    x, step = view.reference, 1e-6 * at.spacing
    gradient, hessian = part.gradient(view, x), part.hessian(view, x).toarray()
    rng = np.random.default_rng(1)
    for _ in range(4):
        along = rng.normal(size=x.shape)
        rise = part.energy(view, x + step * along) - part.energy(view, x - step * along)
        assert rise / (2.0 * step) == pytest.approx(np.vdot(gradient, along), rel=1e-6)
    np.testing.assert_allclose(hessian, hessian.T, atol=1e-12 * np.abs(hessian).max())
    np.testing.assert_allclose(hessian, differences(part.gradient, view, x, step), atol=1e-6 * np.abs(hessian).max())


# --- friction and motion --------------------------------------------------------------------------


def test_a_block_slides_at_the_limit_of_coulomb() -> None:
    """A narrow block on a wide flat one, meshes that do not match: mu times the normal force, in curves as well."""
    mu, side = 0.2, 0.05
    pushed = [
        {"on": "lower", "ux": 0.0, "uy": 0.0},
        {"on": "upper", "ux": {"ramp": "linear", "to": side}},
        {"on": "upper.top", "uy": {"ramp": "linear", "to": -DOWN}},
    ]
    changes = {"contacts.0.friction": {"use": "coulomb", "mu": mu}, "supports": pushed}
    results = run(blocks((2, 3), **changes, **{"bodies.upper.mesh.x": [0.5, 1.5]}))
    # normal forces may belong to the iteration before: friction changes by less than 1e-4 of the largest force then
    reactions = results.summary["reactions"]
    assert reactions["upper"][0] == pytest.approx(-mu * reactions["upper.top"][1], rel=1e-3)
    curve = results.contact["contacts.0"].last
    np.testing.assert_allclose(curve.shear, -mu * curve.pressure, rtol=1e-3)


def test_a_block_that_sticks_is_as_stiff_as_with_a_mortar() -> None:
    """Half-way to the limit in the mean; the overlap takes 1 % of the height, and slips 0.1 % of the motion."""
    force, side = {}, 0.02
    for algorithm in ("midplane", "mortar-p1"):
        top = {"on": "upper.top", "ux": {"ramp": "linear", "to": side}, "uy": {"ramp": "linear", "to": -DOWN}}
        changes = {
            "contacts.0.algorithm": algorithm,
            "contacts.0.friction": {"use": "coulomb", "mu": 0.5},
            "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, top],
        }
        force[algorithm] = np.array(run(blocks((12, 10), **changes)).summary["reactions"]["upper.top"])
    np.testing.assert_allclose(force["midplane"] / force["mortar-p1"], 1.0, atol=0.02)


def test_friction_of_a_hold_is_that_of_the_motion_before() -> None:
    """A top that stops half-way: its reaction stays, and the contact shows it; a step without slip has no friction."""
    held = {"ramp": "table", "points": [[0.0, 0.0], [0.5, 1.0], [1.0, 1.0]]}
    top = {"on": "upper.top", "ux": held | {"to": 0.02}, "uy": held | {"to": -DOWN}}
    changes = {
        "contacts.0.friction": {"use": "coulomb", "mu": 0.5},
        "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, top],
        "integrator.steps": 4,
    }
    history = run(blocks((4, 3), **changes)).history
    force = history["upper.top.fx"][history["time"] >= 0.5]
    np.testing.assert_allclose(force, force[-1], rtol=1e-9)
    np.testing.assert_allclose(np.abs(history["contacts.0.fx"][-1]), np.abs(force[-1]), rtol=1e-6)


def test_a_block_that_meets_another_gives_it_its_momentum() -> None:
    """Implicit dynamics: momentum is kept, and of the speed all changes over but what twenty cells keep in waves."""
    speed, end, steps = 20.0, 2.4e-4, 120
    changes = {
        "integrator": {"use": "implicit-dynamics"},
        "time": {"end": end},
        "bodies.upper.velocity": [0.0, -speed],
        "bodies.upper.shift": [0.0, 1e-4],
        "bodies.upper.mesh.cells": [2, 20],
        "bodies.lower.mesh.cells": [3, 20],
        "supports": [{"on": "lower", "ux": 0.0}, {"on": "upper", "ux": 0.0}],
    }
    scene = blocks(**changes)
    model = build(scene, scene.registry)
    step, left = model.bound_integrator().step, end
    while left > 1e-9 * end:
        dt = min(end / steps, left)
        done = step(dt)
        assert not done.reason, done.reason
        left -= dt
    mass = model.mass if model.mass.ndim == 1 else model.mass[:, 1]
    momenta = [
        float((mass * model.state["velocity"][:, 1])[body.first : body.first + body.count].sum())
        for body in model.bodies
    ]
    whole = -speed * 1e-6 * WIDTH
    assert sum(momenta) == pytest.approx(whole, rel=ROUND_OFF)
    assert momenta[1] / whole > 0.96
    assert not model.state["contact_force"].any(), "they have parted"


# --- what it costs, and what it refuses ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"integrator": "central-difference"}, "an explicit step has no use for it"),
        ({"contacts.0.friction": {"use": "tresca", "stress": 1.0}}, "friction by a coefficient alone"),
        ({"contacts.0.algorithm": {"use": "midplane", "stiffness": 0.0}}, r"stiffness(?s:.*)0.0(?s:.*)above 0"),
        ({"contacts.0.algorithm": {"use": "midplane", "slip": -1.0}}, r"slip(?s:.*)-1.0(?s:.*)above 0"),
    ],
)
def test_what_it_cannot_do_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(RequestError, match=words):
        build(blocks(**changes), default_registry())


def test_facets_of_a_roll_are_told_with_the_force_that_they_take() -> None:
    """A roll of short segments has the force that one of long ones lacks: chords lie within the circle."""
    block = {"use": "rectangle", "x": [-6.0, -1.5, 1.5, 6.0], "y": [-4.0, 0.0], "cells": [[4, 12, 4], 5]}
    roll = {"arc": {"centre": [0.0, 5.0], "radius": 5.0, "angles": [160.0, 500.0]}}
    told, force = {}, {}
    for segment in (0.5, 0.1):
        data = {
            "integrator": "newton",
            "materials": {"m": {"use": "neo-hookean", "young": YOUNG, "poisson": 0.3, "density": 1e-6}},
            "bodies": {"block": {"element": "q1", "material": "m", "mesh": block}},
            "rigid": {"roll": {**roll, "segment": segment, "uy": {"ramp": "linear", "to": -0.08}}},
            "contacts": [{"slave": "block.top", "master": "roll", "algorithm": "midplane"}],
            "supports": [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
            "record": {"frames": 2, "recorders": []},
        }
        results = run(Scene.from_data(data))
        told[segment] = {w.code: w.value for w in results.warnings}.get("kept-gap", 0.0)
        force[segment] = results.summary["contacts"]["contacts.0"]["resultant"][1]
    missing = 1.0 - force[0.5] / force[0.1]
    assert missing > 0.03
    # between nodes the chords are as deep on average as at nodes that meet them here and there
    assert told[0.5] == pytest.approx(missing, rel=0.3)
    assert told[0.1] == 0.0


@pytest.mark.parametrize("algorithm", ["midplane", "barrier"])
def test_friction_does_not_weaken_with_more_steps(algorithm: str) -> None:
    """A block pushed along a floor by f from rest slides by (f - mu g) t^2 / 2, in 10 steps and in 30.

    The speed of slip at which friction has its bound is the same for all steps, and reached late by 3 % of the way.
    """
    mu, gravity, push, end = 0.2, 1e4, 5e3, 4e-3
    scene = {
        "time": {"end": end},
        "integrator": {"use": "implicit-dynamics", "steps": 10},
        "materials": {"m": {"use": "linear-elastic", "young": 1e4, "poisson": 0.3, "density": 1e-9}},
        "bodies": {
            "block": {
                "element": "q1", "material": "m",
                "mesh": {"use": "rectangle", "x": [0.0, 4.0], "y": [0.0, 1.0], "cells": [4, 1]},
            }
        },
        "rigid": {"floor": {"line": [[20.0, 0.0], [-20.0, 0.0]]}},
        "contacts": [
            {
                "slave": "block.bottom", "master": "floor", "algorithm": algorithm,
                "friction": {"use": "coulomb", "mu": mu},
            }
        ],
        "effects": [{"use": "gravity", "acceleration": [push, -gravity]}],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    slid = []
    for steps in (10, 30):
        results = simulate(Scene.from_data(scene).with_({"integrator.steps": steps}))
        assert results.status == "finished"
        slid.append(float(results.displacement[results.layout.bodies[0].cells].mean(axis=(0, 1))[0]))
    exact = 0.5 * (push - mu * gravity) * end**2
    assert slid[0] == pytest.approx(exact, rel=0.05)
    assert slid[1] == pytest.approx(slid[0], rel=0.01)
