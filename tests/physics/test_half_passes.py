"""Two half passes of `gauss-point`: exchange of sides, patch test, balance, pressures, friction, motion, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab import load_scene, simulate
from contactlab.api import StepStatus
from contactlab.errors import RequestError
from contactlab.model.build import build
from contactlab.model.memory import model_memory, restore_model
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run.prepare import schedule_of
from contactlab.scene.scene import Scene
from contactlab.studies.measures import pressure_error
from contactlab.studies.profile import Profile
from contactlab.studies.reference import load_reference

YOUNG, WIDTH, DOWN, DENSITY = 1000.0, 2.0, 0.01, 1e-6
TWICE = {"use": "gauss-point", "passes": 2}
LAW = {"use": "linear-pressure"}
ROUND_OFF = 1e-12
SWAP = 1e-9  # of the largest: Newton's iteration ends at 1e-8 of the force, and falls by 1e-3 in its last iteration
MODES = pytest.mark.parametrize("integrator", ["newton", "implicit-dynamics", "central-difference"])


def blocks(integrator: str = "newton", cells: tuple[int, int] = (5, 7), layers: int = 3, **changes: Any) -> Scene:
    """Two blocks of nu = 0, each 1 high, meshes that do not match; the upper one is pressed down by DOWN."""
    body = {"element": "q1", "material": "m"}
    meshes = [
        {"use": "rectangle", "x": [0.0, WIDTH], "y": [low, low + 1.0], "cells": [count, layers]}
        for low, count in zip((0.0, -1.0), cells, strict=True)
    ]
    push = {"ramp": "parabola" if integrator == "central-difference" else "linear", "to": -DOWN}
    scene = Scene.from_data(
        {
            "integrator": integrator,
            "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": DENSITY}},
            "bodies": {name: {**body, "mesh": mesh} for name, mesh in zip(("upper", "lower"), meshes, strict=True)},
            "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": TWICE, "enforcement": LAW}],
            "supports": [
                {"on": "lower.bottom", "uy": 0.0},
                {"on": "lower.left", "ux": 0.0},
                {"on": "upper.left", "ux": 0.0},
                {"on": "upper.top", "uy": push},
            ],
            "record": {"frames": 4, "recorders": []},
        }
    )
    return scene.with_(changes) if changes else scene


def supports(integrator: str, way: float) -> list[dict[str, Any]]:
    """The lower block is held, the top of the upper one is pressed down and drawn along."""
    ramp = "parabola" if integrator == "central-difference" else "linear"
    top = {"on": "upper.top", "ux": {"ramp": ramp, "to": way}, "uy": {"ramp": ramp, "to": -DOWN}}
    return [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, top]


def disc(**changes: Any) -> Scene:
    """The disc of the shipped scene, pressed 0.1581 mm deep in one load step."""
    usual = {"integrator": {"use": "newton", "steps": 1}, "supports.1.uy.to": -0.1581, "record.recorders": []}
    given = {"contacts.0.algorithm": TWICE, "contacts.0.enforcement": LAW}
    return load_scene("disc-on-block").with_({**usual, **given, **changes})


def run(scene: Scene) -> Results:
    results = simulate(scene)
    assert results.status == "finished", results.reason
    return results


# --- neither side is the slave ------------------------------------------------------------------------


@pytest.mark.parametrize(
    "integrator",
    some(["newton", "implicit-dynamics", "central-difference"], ["newton"]),
)
def test_forces_do_not_know_which_side_is_the_slave(integrator: str) -> None:
    """A narrow block that slides on a wide one under friction; explicit steps differ by round-off alone."""
    changes = {
        "bodies.upper.mesh.x": [0.5, 1.5], "contacts.0.friction": {"use": "coulomb", "mu": 0.2}, "time.end": 2e-4,
        "supports": supports(integrator, 0.01),
    }  # fmt: skip
    if integrator != "central-difference":
        finer = {"time.step": 1e-5, "integrator.tolerance": 1e-10}
        changes |= {"integrator.steps": 3} if integrator == "newton" else finer
    one, other = (run(blocks(integrator, **changes, **{"contacts.0.swap": swap})) for swap in (False, True))
    for side, force in one.summary["reactions"].items():
        np.testing.assert_allclose(force, other.summary["reactions"][side], atol=SWAP * 20.0)


@pytest.mark.parametrize("element", ["q1", "q2"])
@pytest.mark.parametrize("law", [LAW, {"use": "exponential-pressure", "clearance": 0.001}])
def test_a_uniform_pressure_passes_between_sides_that_end_together(element: str, law: dict[str, Any]) -> None:
    """To round-off: each side has the consistent forces of one pressure, whatever the other side's meshes are."""
    changes = {f"bodies.{body}.element": element for body in ("upper", "lower")}
    results = run(blocks(**changes, **{"contacts.0.enforcement": law}))
    curve = results.contact["contacts.0"].last
    pressure = curve.pressure.mean()
    np.testing.assert_allclose(curve.pressure, pressure, rtol=1e-9)
    reactions = results.summary["reactions"]
    assert -reactions["upper.top"][1] == pytest.approx(WIDTH * pressure, rel=1e-9)
    assert reactions["lower.bottom"][1] == pytest.approx(-reactions["upper.top"][1], rel=1e-9)
    if law is LAW:  # two blocks in series with the springs between them
        behind = 10.0 * YOUNG * 3.0 / 2.0
        assert pressure == pytest.approx(DOWN / (2.0 / YOUNG + 1.0 / behind), rel=1e-9)


def test_a_side_beyond_the_end_of_the_other_errs_by_the_weight_of_a_point() -> None:
    """Its segments are covered in part, and a point counts as a whole: 5/18 of a segment at most, at either end."""
    narrow = {"bodies.upper.mesh.x": [0.5, 1.5]}
    for count in (7, 28):
        found = run(blocks(cells=(5, count), **narrow)).summary["reactions"]
        apart = abs(found["upper.top"][1] + found["lower.bottom"][1]) / found["lower.bottom"][1]
        assert apart < 2.0 * 5.0 / 18.0 * WIDTH / count


def test_forces_of_both_sides_agree_as_far_as_the_mesh_resolves() -> None:
    """Nothing asks that they do: they differ by 9e-4, 4e-4, 5e-5 on levels 1, 2, 4 of a disc."""
    apart = []
    for level in (1, 2):
        results = run(disc(level=level, **{"integrator.steps": 3}))
        up, down = (results.summary["reactions"][side][1] for side in ("block.bottom", "disc.top"))
        apart.append(abs(up + down) / up)
        assert not [w for w in results.summary["warnings"] if w["code"] == "linear-momentum"]
    assert apart[0] < 2e-3
    assert apart[1] < 0.5 * apart[0]


def test_explicit_steps_settle_with_what_the_sides_lack() -> None:
    """Their sums differ by 0.9 % on the coarse disc, and reactions by as much: that is no motion."""
    given = {"contacts.0.algorithm": TWICE, "contacts.0.enforcement": LAW, "record.recorders": []}
    given |= {"bodies.disc.mesh.cells": [12, 3], "bodies.block.mesh.cells": [18, 3], "record.frames": 4}
    results = run(load_scene("disc-on-block").with_(given))
    up, down = (results.summary["reactions"][side][1] for side in ("block.bottom", "disc.top"))
    assert 1e-3 < abs(up + down) / up < 0.01


# --- pressures ----------------------------------------------------------------------------------------


def test_pressures_of_a_disc_are_as_accurate_as_those_of_a_mortar_under_the_same_law() -> None:
    """With either slave: what errs is the overlap of the law (3 to 4 % on level 1), not the passes."""
    reference = load_reference("disc-on-block-deep")
    for swap in (False, True):
        error = []
        for algorithm in (TWICE, {"use": "mortar-p1"}):
            scene = disc(level=1).with_({"contacts.0.swap": swap, "contacts.0.algorithm": algorithm})
            curve = run(scene).contact["contacts.0"].last
            found = Profile.of_nodes(np.asarray(curve.x), np.nan_to_num(curve.pressure))
            error.append(pressure_error(found, reference.profile, reference.window))
        assert error[0] < 1.1 * error[1]


def test_nodal_pressures_sum_up_to_the_force() -> None:
    """Of the named slave, with shears, on curved sides: nodes have the mean of the points beside them."""
    results = run(disc(**{"level": 1, "contacts.0.friction": {"use": "coulomb", "mu": 0.2}}))
    found = results.summary["contacts"]["contacts.0"]
    force = results.history["contacts.0.fy"][-1]
    assert found["resultant"][1] == pytest.approx(force, rel=1e-9)
    np.testing.assert_allclose(found["pressure_integral"], found["resultant"], atol=5e-3 * abs(force))  # facets lean
    curve = results.contact["contacts.0"].last
    assert np.all(np.abs(curve.shear) <= 0.2 * curve.pressure * (1.0 + 1e-9))


# --- friction and motion --------------------------------------------------------------------------------


def drawn(integrator: str, mu: float, way: float, **changes: Any) -> Results:
    """The upper block, drawn along by its top."""
    given = {"contacts.0.friction": {"use": "coulomb", "mu": mu}, "supports": supports(integrator, way)}
    return run(blocks(integrator, **{**given, **changes}))


def test_what_slides_carries_mu_times_its_pressure_on_both_sides() -> None:
    """At every node, and the reactions of both sides differ by what the pressed edges of both meshes do."""
    results = drawn("newton", 0.2, 0.02)
    curve = results.contact["contacts.0"].last
    np.testing.assert_allclose(np.abs(curve.shear), 0.2 * curve.pressure, rtol=1e-6)
    (x, _), (back, _) = (results.summary["reactions"][side] for side in ("upper.top", "lower.bottom"))
    assert x == pytest.approx(-back, rel=0.01)
    balance = results.summary["balance"]
    slid = 0.02 - 2.0 * x / WIDTH * 2.0 / YOUNG  # less the shear of both blocks (G = E / 2), that of a beam aside
    assert balance["friction"] == pytest.approx(0.5 * x * slid, rel=0.35)  # force and slip grow together
    assert balance["external"] == pytest.approx(balance["stored"] + balance["friction"] - balance["contact"], rel=1e-9)


@pytest.mark.parametrize("integrator", some(["newton", "central-difference"], ["central-difference"]))
def test_what_sticks_is_nearly_as_stiff_as_with_a_mortar(integrator: str) -> None:
    """Springs of shear as stiff as those of pressure give way by a fifteenth of what a block does."""
    changes = {} if integrator == "newton" else {"time.end": 4e-4}
    force = [
        drawn(integrator, 0.9, 0.004, **changes, **{"contacts.0.algorithm": algorithm}).summary["reactions"][
            "upper.top"
        ][0]
        for algorithm in (TWICE, {"use": "mortar-p1"})
    ]
    assert force[0] == pytest.approx(force[1], rel=0.03)


@pytest.mark.parametrize("integrator", ["implicit-dynamics", "central-difference"])
def test_a_block_gives_another_its_momentum(integrator: str) -> None:
    """Of flat sides that end together momentum is kept to round-off; all of it changes over but what waves keep."""
    speed = 20.0
    changes = {
        "supports": [{"on": "lower", "ux": 0.0}, {"on": "upper", "ux": 0.0}],
        "bodies.upper.velocity": [0.0, -speed], "bodies.upper.shift": [0.0, 1e-4],
        "time": {"end": 2.4e-4, "damping": 0.0},
    }  # fmt: skip
    steps = {"time.step": 2e-6} if integrator == "implicit-dynamics" else {}
    scene = blocks(integrator, layers=10, **changes, **steps)
    model = build(scene, default_registry())
    step, left, dt = model.bound_integrator().step, 2.4e-4, schedule_of(model, scene).dt
    while left > 1e-9:
        assert step(min(dt, left)).status is StepStatus.accepted
        left -= dt
    mass = model.mass if model.mass.ndim == 1 else model.mass[:, 1]
    parts = [slice(b.first, b.first + b.count) for b in model.bodies]
    upper, lower = (float(mass[own] @ model.state["velocity"][own, 1]) for own in parts)
    whole = -speed * DENSITY * WIDTH
    assert upper + lower == pytest.approx(whole, rel=ROUND_OFF * 100.0)
    assert lower / whole > 0.93
    assert not model.state["contact_force"].any(), "they have parted"


@MODES
def test_a_restart_gives_the_same_bits(integrator: str) -> None:
    """Near lists and multipliers of both passes are among what a run keeps."""
    friction = {"use": "coulomb", "mu": 0.2}
    scene = blocks(integrator, **{"contacts.0.friction": friction, "supports": supports(integrator, 0.001)})
    model = build(scene, default_registry())
    step = model.bound_integrator().step
    dt = 0.5 if integrator == "newton" else 1e-6 if integrator == "implicit-dynamics" else 1e-7
    step(dt)
    memory = {name: np.copy(values) for name, values in model_memory(model).items()}
    step(dt)
    other = build(scene, default_registry())
    restore_model(other, memory)
    other.bound_integrator().step(dt)
    np.testing.assert_array_equal(other.state.buffer, model.state.buffer)


# --- what it refuses and costs ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contacts.0.enforcement": "active-set"}, "press by a law of the gap(?s:.*)linear-pressure"),
        ({"contacts.0.enforcement": "augmented-lagrangian"}, "press by a law of the gap(?s:.*)linear-pressure"),
        ({"contacts.0.enforcement": "penalty"}, "press by a law of the gap"),
        ({"contacts.0.enforcement": "nitsche"}, "press by a law of the gap"),
        ({"contacts.0.algorithm": {"use": "gauss-point", "passes": 3}}, r"passes(?s:.*)3(?s:.*)1 or 2"),
        (
            {"rigid": {"floor": {"line": [[3.0, 0.0], [-1.0, 0.0]]}}, "contacts.0.master": "floor"},
            "two sides that deform(?s:.*)floor",
        ),
    ],
)
def test_what_it_cannot_do_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(RequestError, match=words):
        build(blocks(**changes), default_registry())
