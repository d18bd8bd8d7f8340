"""Barrier contact: pressure against its law, reactions over dhat, no intersection, friction, impacts, refusals."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contactlab_ipc import barrier
from scipy.optimize import brentq

from contactlab import load_scene, simulate
from contactlab.api import Floats, Ints, Setup
from contactlab.api.frame import OPEN
from contactlab.cases.run_case import run_case
from contactlab.errors import RequestError
from contactlab.model.build import build
from contactlab.model.contact import potential_start
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

YOUNG, POISSON, WIDTH, DOWN = 1000.0, 0.3, 2.0, 0.1
MODULUS = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))


def law(x: float) -> float:
    """Pressure over its scale at a distance x dhat: minus the derivative of -(x^2 - 1)^2 ln(x^2)."""
    return 4.0 * x * (x * x - 1.0) * np.log(x * x) + 2.0 * (x * x - 1.0) ** 2 / x


def blocks(cells: tuple[int, int] = (3, 3), **changes: Any) -> Scene:
    """Two blocks, each 1 high, between smooth walls, pressed together by DOWN."""
    body = {"element": "q1", "material": "m"}
    upper = {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, 1.0], "cells": [cells[0], 1]}
    lower = {"use": "rectangle", "x": [0.0, WIDTH], "y": [-1.0, 0.0], "cells": [cells[1], 1]}
    return Scene.from_data(
        {
            "name": "blocks",
            "time": {"end": 1.0, "ramp": 1.0},
            "integrator": {"use": "newton", "steps": 2},
            "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": POISSON, "density": 1e-6}},
            "bodies": {"upper": {**body, "mesh": upper}, "lower": {**body, "mesh": lower}},
            "contacts": [
                {"slave": "upper.bottom", "master": "lower.top", "algorithm": {"use": "barrier", "dhat": 0.1}}
            ],
            "supports": [
                {"on": "lower", "ux": 0.0},
                {"on": "lower.bottom", "uy": 0.0},
                {"on": "upper", "ux": 0.0},
                {"on": "upper.top", "uy": {"ramp": "linear", "to": -DOWN}},
            ],
            "record": {"frames": 2, "recorders": []},
        }
    ).with_(changes)


def disc(**changes: Any) -> Scene:
    return load_scene("disc-on-block").with_(
        {"integrator": "newton", "record.recorders": [], "contacts.0.algorithm": "barrier", **changes}
    )


def run(scene: Scene) -> Results:
    results = simulate(scene)
    assert results.status == "finished", results.reason
    return results


def intersect(at: Floats, one: Ints, other: Ints) -> bool:
    """Whether a segment of `one` (a, 2) and one of `other` (b, 2) cross or touch at positions (n, 2)."""
    a, b, c, d = at[one[:, 0], None], at[one[:, 1], None], at[None, other[:, 0]], at[None, other[:, 1]]

    def side(p: Floats, q: Floats, r: Floats) -> Floats:
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    return bool(((side(a, b, c) * side(a, b, d) <= 0.0) & (side(c, d, a) * side(c, d, b) <= 0.0)).any())


def segments_of(model: Any) -> tuple[Ints, Ints]:
    pair = model.contact.pairs[0]
    return pair.slave.nodes[pair.slave.segments], pair.master.nodes[pair.master.segments]


def advance(scene: Scene, dt: float, end: float = 1.0) -> Any:
    """The model at the end, each accepted state looked at for intersections of segments."""
    model = build(scene, scene.registry)
    one, other = segments_of(model)
    assert not intersect(model.reference, one, other)
    step, left = model.bound_integrator().step, end
    while left > 1e-9 * end:
        done = step(min(dt, left))
        if done.reason:
            dt *= 0.5
            assert dt > 1e-3 * end, done.reason
            continue
        left -= min(dt, left)
        assert not intersect(model.reference + model.state["displacement"], one, other)
    return model


def test_blocks_that_begin_in_touch_are_opened_by_dhat_and_have_the_pressure_of_the_law() -> None:
    """p = kappa f(d / dhat), in series with both blocks, from an opening that the run reports."""
    dhat = 0.1 * WIDTH / 3.0
    results = run(blocks())
    contact = results.summary["contacts"]["contacts.0"]
    assert contact["opened"] == pytest.approx(dhat, rel=1e-9)
    assert contact["complementarity"] is contact["stiffness"] is None, "there are no conditions"
    # the upper block is lower by dhat, and so is its stiffness larger
    heights = 2.0 - dhat
    distance = brentq(lambda x: DOWN - (1.0 - x) * dhat - heights * law(x), 0.5, 1.0, xtol=1e-14)
    pressure = MODULUS * law(distance)
    assert results.summary["reactions"]["upper.top"][1] == pytest.approx(-pressure * WIDTH, rel=1e-6)
    curve = results.contact["contacts.0"].last
    np.testing.assert_allclose(curve.pressure, pressure, rtol=1e-6)
    np.testing.assert_allclose(curve.gap, distance * dhat, rtol=1e-6)
    np.testing.assert_allclose(contact["resultant"], contact["pressure_integral"], rtol=1e-9, atol=1e-9)
    assert set(curve.state) == {2}, "pressed, and free to slide"
    (kept,) = [found for found in results.summary["invariants"] if found["code"] == "kept-overlap"]
    strain = 0.5 * pressure**2 / MODULUS * heights  # per width
    assert kept["value"] == pytest.approx(pressure * (1.0 - distance) * dhat / strain, rel=1e-6)


def test_surfaces_apart_are_not_opened() -> None:
    scene = blocks(**{"bodies.upper.shift": [0.0, 0.07]})  # dhat is 0.0667
    assert "opened" not in run(scene).summary["contacts"]["contacts.0"]


@pytest.mark.parametrize("gap", [0.01, 0.05])
def test_a_block_that_bulges_across_narrow_gaps_is_told_what_the_distance_of_the_barrier_costs(gap: float) -> None:
    """Between walls a block is held in x from e_x = gap on; what is more than that comes from the distance kept."""
    x = 1.0 + gap
    walls = {"left": {"line": [[-x, -1.0], [-x, 2.0]]}, "right": {"line": [[x, 2.0], [x, -1.0]]}}
    mesh = {"use": "rectangle", "x": [-1.0, 1.0], "y": [0.0, 1.0], "cells": [4, 3]}
    plane, ratio = 100.0 / (1.0 - 0.3**2), 0.3 / 0.7
    down = -gap / ratio - 0.05
    results = simulate(Scene.from_data({
        "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": 100.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {"b": {"element": "q1", "material": "m", "mesh": mesh}},
        "rigid": walls,
        "contacts": [{"slave": f"b.{side}", "master": side, "algorithm": "barrier"} for side in walls],
        "supports": [{"on": "b.bottom", "uy": 0.0}, {"on": "b.top", "uy": {"ramp": "linear", "to": down}}],
    }))  # fmt: skip
    right = plane / (1.0 - ratio**2) * (gap + ratio * down)
    error = abs(results.summary["reactions"]["left"][0] / right) - 1.0
    assert error > 0.05
    assert "early-contact" in {warning.code for warning in results.warnings}


@pytest.mark.parametrize("depth", [0.1581, pytest.param(0.35, marks=pytest.mark.full)])
def test_reactions_over_dhat_lead_to_those_of_a_mortar(depth: float) -> None:
    """At h/5, h/10, h/20 and by a line through them at 0: within 1 % of mortar-p1, and each nearer than the last."""
    deep = {"supports.1.uy.to": -depth, **({"integrator.steps": 4} if depth > 0.2 else {})}
    force = [
        run(disc(**{"contacts.0.algorithm.dhat": d, **deep})).summary["reactions"]["disc.top"][1]
        for d in (0.2, 0.1, 0.05)
    ]
    mortar = run(disc(**{"contacts.0.algorithm": "mortar-p1", **deep})).summary["reactions"]["disc.top"][1]
    off = np.abs(np.array(force) / mortar - 1.0)
    assert (np.diff(off) < 0.0).all()
    assert np.polyfit([0.2, 0.1, 0.05], force, 1)[1] == pytest.approx(mortar, rel=0.01)


@pytest.mark.parametrize("depth", [0.1581, pytest.param(0.35, marks=pytest.mark.full)])
def test_segments_never_intersect_in_any_state_of_a_disc(depth: float) -> None:
    model = advance(disc(**{"supports.1.uy.to": -depth, "time.end": 1.0, "time.ramp": 1.0}), 0.25)
    one, other = segments_of(model)
    place = model.reference + model.state["displacement"]
    # the test itself: the disc moved down by a tenth of a segment crosses the block
    place[: model.bodies[0].count, 1] -= 0.007
    assert intersect(place, one, other)


def test_a_block_slides_at_the_limit_of_coulomb() -> None:
    """A narrow block on a wide one, meshes that do not match, pushed sideways as a whole: mu times the normal force."""
    mu, side = 0.2, 0.05
    changes = {
        "contacts.0.friction": {"use": "coulomb", "mu": mu},
        "supports.2.ux": {"ramp": "linear", "to": side},
        "supports.0.uy": 0.0,  # a flat master: normal forces have no part along it
        "bodies.upper.mesh.x": [0.5, 1.5],
    }
    reactions = run(blocks((2, 3), **changes)).summary["reactions"]
    # normal forces may belong to the iteration before: friction changes by less than 1e-4 of the largest force then
    assert reactions["upper"][0] == pytest.approx(-mu * reactions["upper.top"][1], rel=1e-3)


def test_far_from_the_origin_it_slides_as_it_does_there() -> None:
    """At 1e4 times its size: positions keep 12 digits, small distances keep theirs as they are taken from near by."""
    changes = {
        "contacts.0.friction": {"use": "coulomb", "mu": 0.2},
        "supports.2.ux": {"ramp": "linear", "to": 0.05},
        "supports.0.uy": 0.0,
        "bodies.upper.mesh.x": [0.5, 1.5],
    }
    away = {f"bodies.{name}.shift": [1e4, -2e4] for name in ("upper", "lower")}
    near, far = (run(blocks((2, 3), **changes, **more)).summary["reactions"]["upper.top"] for more in ({}, away))
    assert far == pytest.approx(near, rel=1e-6)  # round-off of 4e-12 mm, in slips of 5e-6 mm that friction follows


def test_a_body_that_is_opened_keeps_its_weight() -> None:
    """Its slave nodes are moved into it by dhat, 2 % of its height: the floor carries what the scene declares."""
    weight = YOUNG * 1e-4
    results = run(blocks(**{
        "supports": [{"on": "lower", "ux": 0.0}, {"on": "lower.bottom", "uy": 0.0}, {"on": "upper", "ux": 0.0}],
        "effects": [{"use": "gravity", "acceleration": [0.0, -weight / (1e-6 * WIDTH)], "on": ["upper"]}],
    }))  # fmt: skip
    assert results.summary["reactions"]["lower.bottom"][1] == pytest.approx(weight, rel=1e-6)


def test_a_block_that_sticks_is_as_stiff_as_with_a_mortar() -> None:
    """Half-way to the limit in the mean; 0.83 % less height for the opening, and a slip of 0.1 % of the motion."""
    force, side = {}, 0.02
    for algorithm in ("barrier", "mortar-p1"):
        top = {"on": "upper.top", "ux": {"ramp": "linear", "to": side}, "uy": {"ramp": "linear", "to": -DOWN}}
        changes = {
            "contacts.0.algorithm": algorithm,
            "contacts.0.friction": {"use": "coulomb", "mu": 0.5},
            "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, top],
        }
        force[algorithm] = np.array(run(blocks((12, 10), **changes)).summary["reactions"]["upper.top"])
    x, y = force["barrier"] / force["mortar-p1"]
    assert x == pytest.approx(1.0, abs=0.02)
    assert y == pytest.approx(1.0, abs=0.02)


def test_a_block_that_meets_another_never_touches_it_and_gives_it_its_momentum() -> None:
    """Implicit dynamics: momentum is kept, contact makes no energy, most of the speed changes over."""
    speed, end = 20.0, 2.4e-4
    changes = {
        "integrator": {"use": "implicit-dynamics"},
        "time": {"end": end},
        "bodies.upper.velocity": [0.0, -speed],
        "bodies.upper.shift": [0.0, 0.067],  # dhat is 0.0667
        "supports": [{"on": "lower", "ux": 0.0}, {"on": "upper", "ux": 0.0}],
    }
    model = advance(blocks((2, 3), **changes), end / 120, end)
    mass = model.mass if model.mass.ndim == 1 else model.mass[:, 1]
    momentum = [
        float((mass * model.state["velocity"][:, 1])[body.first : body.first + body.count].sum())
        for body in model.bodies
    ]
    whole = -speed * 1e-6 * WIDTH
    assert sum(momentum) == pytest.approx(whole, rel=1e-9)
    assert momentum[1] / whole > 0.9
    assert not model.state["contact_force"].any(), "they have parted"


def test_an_impact_across_a_gap_tells_what_it_lost_and_how_early_it_was() -> None:
    """A bar that is thrown is compressed by v/c, 2e-3, as much as `dhat`; it comes and goes between its two frames."""
    floor = {"line": [[50.0, 0.0], [-50.0, 0.0]]}
    mesh = {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [2, 4]}
    results = simulate(Scene.from_data({
        "time": {"end": 2e-4}, "integrator": {"use": "implicit-dynamics", "steps": 80},
        "materials": {"m": {"use": "neo-hookean", "young": 1e3, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"b": {
            "element": "q1", "material": "m", "mesh": mesh, "shift": [0.0, 0.1], "velocity": [0.0, -2000.0],
        }},
        "rigid": {"floor": floor},
        "contacts": [{"slave": "b.bottom", "master": "floor", "algorithm": {"use": "barrier", "dhat": 2e-3}}],
        "record": {"frames": 1},
    }))  # fmt: skip
    assert results.contact["contacts.0"].last.state.max() == OPEN
    told = {warning.code: warning.value for warning in results.warnings}
    # what is left of the barrier is open again: its work is what was lost, of the energy of the throw
    lost = results.history["energy.contact"][-1] / results.history["energy.kinetic"][0]
    assert told["contact-energy"] == pytest.approx(lost, rel=1e-3)
    assert lost < -0.05
    assert told["early-contact"] > 0.1


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"integrator": "central-difference"}, "an explicit step has no use for it"),
        ({"contacts.0.friction": {"use": "tresca", "stress": 1.0}}, "friction by a coefficient alone"),
        ({"bodies.upper.shift": [0.0, -0.01]}, "overlap"),
        ({"contacts.0.algorithm": {"use": "barrier", "dhat": 0.6}}, r"dhat(?s:.*)0.6(?s:.*)above 0, up to 0.5"),
        ({"contacts.0.algorithm": {"use": "barrier", "stiffness": 0.0}}, r"stiffness(?s:.*)0.0(?s:.*)above 0"),
    ],
)
def test_what_the_barrier_cannot_do_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(RequestError, match=words):
        build(blocks(**changes), default_registry())


def test_surfaces_that_cross_or_stay_too_close_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = blocks()
    model = build(scene, scene.registry)
    (pair,) = model.contact.pairs
    crossed = model.reference.copy()
    crossed[pair.slave.nodes[0], 1] = -0.1
    plan: Any = SimpleNamespace(slave=pair.slave, master=pair.master, where="", opened=0.0)
    with pytest.raises(RequestError, match="slave and master intersect before the run"):
        potential_start.begin_open(plan, pair, crossed, model.state)
    monkeypatch.setattr(potential_start, "ROUNDS", 1)
    with pytest.raises(RequestError, match=r"surfaces cannot be opened(?s:.*)0.0667 mm too close after 1 rounds"):
        build(scene, scene.registry)


def test_without_the_toolkit_the_part_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = load_scene("two-bars")
    monkeypatch.setitem(sys.modules, "ipctk", None)
    barrier._toolkit.cache_clear()
    with pytest.raises(RequestError, match="pip install ipctk"):
        scene.with_({"contacts.0.algorithm": "barrier"})


def test_the_patch_test_converges_to_the_round_off_of_its_stiff_forces() -> None:
    """Its tolerance of 1e-12 of the largest force is below what gaps, differences of positions, leave of them."""
    case = default_registry().make("case", "patch")
    _, done = run_case(case, Setup("barrier", element=case.elements[0], integrator=case.integrators[0]))
    assert [record.status for record in done.values()] == ["finished"] * len(done)
