"""Pressure laws: one class for statics and explicit steps, against closed forms of two pressed blocks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

E, RHO, HEIGHT, WIDTH = 1000.0, 1e-6, 1.0, 2.0
PUSH = 0.01  # mm
EXPLICIT = 3e-4  # of the force: a run has settled when reactions agree to 2e-4 and ring no more
CLEARANCE, TABLE = 0.002, ((-0.01, 0.0, 0.01), (40.0, 2.0, 0.0))
BEHIND = E / HEIGHT / 2.0  # MPa/mm: one cell of each block in series, Poisson's ratio 0
LAWS: dict[str, dict[str, Any]] = {
    "linear": {"use": "linear-pressure"},
    "exponential": {"use": "exponential-pressure", "clearance": CLEARANCE},
    "table": {"use": "tabular-pressure", "gaps": list(TABLE[0]), "pressures": list(TABLE[1])},
}


def pressure(law: str, gap: float) -> float:
    """The law by hand."""
    if law == "linear":
        return max(0.0, -10.0 * BEHIND * gap)
    if law == "table":
        return float(np.interp(gap, *TABLE))
    u = max(0.0, 1.0 - gap / CLEARANCE)
    return 10.0 * BEHIND * CLEARANCE * u * (math.exp(u) - 1.0) / (math.e - 1.0)


def closed_form(law: str) -> float:
    """Pressure at which both blocks give way by what the gap leaves of the push, by bisection."""
    low, high = 0.0, E * PUSH
    for _ in range(60):
        p = 0.5 * (low + high)
        gap = p * 2.0 * HEIGHT / E - PUSH
        low, high = (p, high) if pressure(law, gap) > p else (low, p)
    return p


def blocks(law: dict[str, Any] | str, integrator: str, **changes: Any) -> contactlab.Scene:
    """A block on another one, pressed by `PUSH`; one cell high."""
    top = {"ramp": "parabola", "to": -PUSH} if integrator == "central-difference" else -PUSH
    mesh = {"use": "rectangle", "x": [0.0, WIDTH], "cells": [2, 1]}
    body = {"element": "q1", "material": "m"}
    scene = contactlab.Scene.from_data(
        {
            "integrator": integrator,
            "materials": {"m": {"use": "linear-elastic", "young": E, "poisson": 0.0, "density": RHO}},
            "bodies": {
                "upper": body | {"mesh": mesh | {"y": [0.0, HEIGHT]}},
                "lower": body | {"mesh": mesh | {"y": [-HEIGHT, 0.0]}},
            },
            "contacts": [
                {"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p1", "enforcement": law}
            ],
            "supports": [{"on": "upper.top", "ux": 0.0, "uy": top}, {"on": "lower.bottom", "ux": 0.0, "uy": 0.0}],
        }
    )
    return scene.with_(changes) if changes else scene


def done(scene: contactlab.Scene) -> Results:
    results = simulate(scene)
    assert results.status == "finished", results.reason
    return results


IN_STATICS = [(law, "newton") for law in LAWS]
IN_TIME = [(law, "central-difference") for law in LAWS]


@pytest.mark.parametrize(("law", "integrator"), some(IN_STATICS + IN_TIME, IN_STATICS + IN_TIME[:1]))
def test_two_blocks_press_as_in_the_closed_form(law: str, integrator: str) -> None:
    results = done(blocks(LAWS[law], integrator))
    exact = WIDTH * closed_form(law)
    within = 1e-7 if integrator == "newton" else EXPLICIT
    assert -results.summary["reactions"]["upper.top"][1] == pytest.approx(exact, rel=within)
    assert not results.summary["warnings"]


@pytest.mark.parametrize("cells", [2, 16])
def test_an_overlap_that_the_law_asks_for_is_no_penetration(cells: int) -> None:
    """Springs of 5 MPa/mm in series with the blocks: nine tenths of the push are overlap, up to 0.8 of a segment."""
    given: dict[str, Any] = {f"bodies.{body}.mesh.cells": [cells, 1] for body in ("upper", "lower")}
    results = done(blocks({"use": "linear-pressure", "stiffness": 5.0}, "newton", **{"supports.0.uy": -0.1} | given))
    force = 0.1 * WIDTH / (2.0 * HEIGHT / E + 1.0 / 5.0)
    assert results.summary["reactions"]["upper.top"][1] == pytest.approx(-force, rel=1e-7)
    assert not results.summary["warnings"]


@pytest.mark.parametrize("cells", [(4, 3), (3, 4)])
def test_nodes_hold_sides_that_end_at_one_place(cells: tuple[int, int]) -> None:
    """The ends of the master are the ends of the slave: which of both is held does not change with each correction."""
    law = {"use": "tabular-pressure", "gaps": [-0.02, 0.0, 0.01], "pressures": [9.0, 1.0, 0.0]}
    given = {f"bodies.{body}.mesh.cells": [count, 2] for body, count in zip(("upper", "lower"), cells, strict=True)}
    given |= {"contacts.0.algorithm": "node-on-segment", "contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
    given["supports.0.uy"] = {"ramp": "linear", "to": -0.004}
    force = -done(blocks(law, "newton", **given)).summary["reactions"]["upper.top"][1]
    pressure = (1.0 + 400.0 * 0.004) / (1.0 + 400.0 * 2.0 * HEIGHT / E)  # of 1 - 400 g and g = 2 h p/E - 0.004
    assert force == pytest.approx(WIDTH * pressure, rel=1e-2)  # unlike nodes: the patch test fails by less


def free(law: dict[str, Any], **changes: Any) -> Results:
    """Blocks that nothing drives, in short steps and without damping."""
    held = [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}]
    given = {"supports": held, "time.damping": 0.0, "time.fraction": 0.1} | changes
    return done(blocks(law, "central-difference", **given))


def test_what_surfaces_store_at_the_start_is_no_energy_that_contact_makes() -> None:
    """Softened contact that begins in touch pushes a block away: all energy there is comes from the surfaces."""
    balance = free(LAWS["exponential"], **{"time.end": 1e-4}).summary["balance"]
    stored = WIDTH * 10.0 * BEHIND * CLEARANCE**2 / (math.e - 1.0) * 0.5  # of u e^u - u between 0 and 1
    assert balance["contact"] == pytest.approx(stored, rel=5e-2)  # leapfrog: (w dt / 2)^2, w dt = 0.2 to 0.4
    assert balance["kinetic"] + balance["internal"] == pytest.approx(balance["contact"], rel=1e-9)


def test_a_bounce_gives_back_what_it_took() -> None:
    """Work of the contact is zero again when a block has left: forces follow from a potential.

    Leapfrog keeps an energy that differs from it by the square of the step over the spring's period.
    """
    results = free(
        LAWS["linear"] | {"factor": 2.0}, **{"bodies.upper.velocity": [0.0, -100.0], "time.end": 3e-4}
    )  # fmt: skip
    kinetic = 0.5 * RHO * WIDTH * HEIGHT * 100.0**2
    assert float(np.max(results.contact["contacts.0"].last.pressure)) == 0.0
    assert abs(results.summary["balance"]["contact"]) < 1e-2 * kinetic
    assert min(results.history["energy.contact"]) < -0.05 * kinetic


@pytest.mark.parametrize("use", some(["linear-pressure", "exponential-pressure"], ["exponential-pressure"]))
def test_a_bounce_in_implicit_steps_keeps_its_energy(use: str) -> None:
    """A block thrown on a floor softer by 500: some 6 to 24 steps a contact, where forces at ends lose half to 15 %.

    Linear springs keep it to what is solved; others as well as four points integrate a pressure over a step.
    """
    speed, soft, far = 1.5, 2.0, 1e-3
    law = {"stiffness": soft} if use == "linear-pressure" else {"clearance": far, "pressure_at_zero": soft * far}
    kept = 1e-5 if use == "linear-pressure" else 1e-3
    contact = math.pi * math.sqrt(RHO * HEIGHT / soft)
    for steps in (24, 48, 12):
        results = done(blocks({"use": use} | law, "implicit-dynamics").with_({
            "integrator": {"use": "implicit-dynamics", "steps": steps}, "time.end": 2.0 * contact,
            "bodies.upper.velocity": [0.0, -speed], "bodies.upper.mesh.y": [far, far + HEIGHT],
            "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}], "record.frames": 8,
        }))  # fmt: skip
        whole, history = 0.5 * WIDTH * HEIGHT * RHO * speed**2, results.history
        assert np.count_nonzero(history["contacts.0.fy"])
        assert history["contacts.0.fy"][-1] == 0.0
        assert results.summary["balance"]["contact"] == pytest.approx(0.0, abs=kept * whole)
        few = steps < 20  # less than 10 in the contact
        assert [warning.code for warning in results.warnings] == ["few-steps-in-contact"] * few
        # what is left in waves of the blocks, 1/500
        assert history["energy.kinetic"][-1] == pytest.approx(whole, rel=kept + 2e-3)
        if use == "linear-pressure" and not few:
            # means over a step of a sine: 1/6 of the square of half of its angle, and the floor gives way, 1/500
            peak = np.abs(history["contacts.0.fy"]).max() / WIDTH
            angle = 2.0 * math.pi / steps
            assert peak == pytest.approx(speed * math.sqrt(RHO * HEIGHT * soft), rel=angle**2 / 2 + 2e-3)


@pytest.mark.parametrize("factor", [0.01, 100.0])
def test_a_soft_penalty_that_loses_a_bounce_is_told(factor: float) -> None:
    """Springs that follow the step keep no energy; the warning names a law that does. Stiff ones stop nodes alone."""
    results = done(blocks({"use": "penalty", "factor": factor}, "implicit-dynamics").with_({
        "integrator": {"use": "implicit-dynamics", "steps": 48}, "time.end": 4e-3, "bodies.upper.velocity": [0.0, -1.5],
        "bodies.upper.mesh.y": [1e-3, 1e-3 + HEIGHT], "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}],
        "record.frames": 4,
    }))  # fmt: skip
    lost = results.summary["balance"]["contact"] / (0.5 * WIDTH * HEIGHT * RHO * 1.5**2)
    told = [warning for warning in results.warnings if warning.code == "contact-energy"]
    assert len(told) == (factor < 1.0)
    for warning in told:
        assert warning.value == pytest.approx(lost, rel=1e-6)
        assert warning.key == "contacts.0.enforcement"
        assert "linear-pressure" in warning.text


def test_surfaces_that_a_law_presses_before_the_run_are_told() -> None:
    """The integral of the pressure over its clearance, over the width, beside the energy of a slow throw."""
    rest = {"time.end": 1e-6, "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}]}
    thrown = rest | {"bodies.upper.velocity": [0.0, 1.0], "integrator": {"use": "implicit-dynamics", "steps": 4}}
    (warning,) = done(blocks(LAWS["exponential"], "implicit-dynamics").with_(thrown)).warnings
    stored = WIDTH * sum(pressure("exponential", CLEARANCE * (n + 0.5) / 1000) for n in range(1000)) * CLEARANCE / 1000
    assert warning.code == "pressed-start"
    # a rule of 1000 middles, and the sum over gaps to four digits
    assert warning.value == pytest.approx(stored / (0.5 * RHO * WIDTH * HEIGHT), rel=1e-3)


@pytest.mark.parametrize("integrator", ["newton", "central-difference"])
def test_friction_carries_its_share_of_the_pressure(integrator: str) -> None:
    """A block dragged along slides under mu times its pressure; in an explicit run, which rings, it sticks at times."""
    way = {"ramp": "linear" if integrator == "newton" else "parabola", "to": 0.02}
    given = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}, "supports.0.ux": way, "time.end": 1e-3}
    given |= {"bodies.upper.mesh.x": [0.5, 1.5], "record.frames": 4}
    results = done(blocks(LAWS["linear"], integrator, **given))
    if integrator == "newton":
        curve = results.contact["contacts.0"].last
        np.testing.assert_allclose(np.abs(curve.shear), 0.2 * np.asarray(curve.pressure), rtol=1e-6)
    along, across = results.summary["contacts"]["contacts.0"]["resultant"]
    assert 0.1 < abs(along / across) < 0.2 * 1.02  # the surface tilts by a hundredth at most


def test_explicit_steps_follow_the_slope() -> None:
    """Stable steps are those of both blocks and of the springs between their nodes' masses."""
    registry = default_registry()
    steps = [build(blocks(law, "central-difference"), registry).step_within(1.0) for law in
             ("forward-increment", LAWS["linear"], LAWS["linear"] | {"factor": 1000.0})]  # fmt: skip
    mass_per_length = 0.5 * RHO * HEIGHT
    for step, factor in zip(steps[1:], (10.0, 1000.0), strict=True):
        square = 2.0 * 1.05 * 1.3 * factor * BEHIND * 2.0 / mass_per_length  # margins: docs/theory/pressure-laws.md
        assert step == pytest.approx((steps[0] ** -2 + square / 4.0) ** -0.5, rel=1e-9)


@pytest.mark.parametrize("algorithm", some(["node-on-segment", "mortar-p0", "gauss-point"], ["node-on-segment"]))
def test_a_node_of_a_long_segment_presses_on_a_light_one(algorithm: str) -> None:
    """Two cells on seven: a node of the master carries one of the slave, 3.5 times as long. Runs diverged before."""
    law = LAWS["linear"] | {"factor": 100.0}
    given = {"bodies.lower.mesh.cells": [7, 1], "contacts.0.algorithm": algorithm, "record.frames": 4}
    scene = blocks(law, "central-difference", **given)
    plain, model = (
        build(scene.with_({"contacts.0.enforcement": use}), default_registry()) for use in ("forward-increment", law)
    )
    square = 2.0 * 1.05 * 1.3 * 100.0 * BEHIND * (1.0 + 7.0 / 2.0) / (0.5 * RHO * HEIGHT)
    expected = (plain.step_within(1.0) ** -2 + square / 4.0) ** -0.5
    assert model.step_within(1.0) == pytest.approx(expected, rel=1e-9)
    assert model.step_within(0.45) == pytest.approx(0.5 * expected, rel=1e-9)
    done(scene)


def test_a_block_that_slides_down_a_rigid_slope_gets_no_energy_from_a_law() -> None:
    """Its weight closes and opens the springs again and again: near their stable step the run diverged."""
    angle, length = np.radians(15.0), 30.0
    end = length * np.cos(angle), length * np.sin(angle)
    mesh = {"use": "rectangle", "x": [0.0, 4.0], "y": [0.0, 2.0], "cells": [6, 3]}
    results = done(contactlab.Scene.from_data({
        "integrator": "central-difference", "time": {"end": 1e-3},
        "materials": {"m": {"use": "neo-hookean", "young": 200.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {"b": {"element": "q1", "material": "m", "mesh": mesh, "rotate": 15.0}},
        "rigid": {"plane": {"line": [[*end], [-end[0], -end[1]]]}},
        "contacts": [{"slave": "b.bottom", "master": "plane", "algorithm": "mortar-p1",
                      "enforcement": LAWS["linear"], "friction": {"use": "coulomb", "mu": 0.1}}],
        "effects": [{"use": "gravity", "acceleration": [0.0, -9810.0]}],
        "record": {"frames": 4, "recorders": []},
    }))  # fmt: skip
    made, put_in = (results.history[f"energy.{name}"][-1] for name in ("contact", "external"))
    assert abs(made) < 0.01 * put_in  # the limit of the warning contact-energy


def test_stiff_laws_take_no_more_iterations_than_soft_ones() -> None:
    """A deep disc, 100 times as stiff as the cells: multipliers need 25; decided by gaps alone it takes 562."""
    way = {"level": 2, "integrator": {"use": "newton", "steps": 5}, "supports.1.uy.to": -0.1581, "record.frames": 1}
    law = {"use": "linear-pressure", "factor": 100.0}
    found = done(contactlab.load_scene("disc-on-block").with_(way | {"contacts.0.enforcement": law}))
    assert found.summary["iterations"] <= 40
