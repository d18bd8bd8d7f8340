"""Gravity, springs, dampers and forces between bodies against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from contactlab.errors import ContactlabError
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene

DENSITY = 2e-3
STEP = 1e-3


def square(x: float = 0.0, cells: int = 1, **more: Any) -> dict[str, Any]:
    """A unit square of mass 2e-3, its lower left corner at (x, 0)."""
    mesh = {"use": "rectangle", "x": [x, x + 1.0], "y": [0.0, 1.0], "cells": [cells, cells]}
    return {"element": "q1", "material": "m", "mesh": mesh, **more}


def model(effects: list[dict[str, Any]], bodies: dict[str, Any] | None = None, **more: Any) -> Model:
    data = {
        "name": "effects",
        "time": {"end": 1e3, "step": STEP},
        "integrator": "central-difference",
        "materials": {"m": {"use": "neo-hookean", "young": 1.0, "poisson": 0.0, "density": DENSITY}},
        "bodies": bodies or {"square": square()},
        "effects": effects,
        **more,
    }
    return build(Scene.from_data(data), default_registry())


def steps(made: Model, count: int) -> Model:
    advance = made.bound_integrator().step
    for _ in range(count):
        advance(STEP)
    return made


def mean(made: Model, name: str, field: str = "displacement") -> np.ndarray:
    body = next(body for body in made.bodies if body.name == name)
    own = slice(body.first, body.first + body.count)
    return made.mass[own] @ made.state[field][own] / made.mass[own].sum()


# --- gravity ------------------------------------------------------------------------------------------


def test_a_body_falls_by_half_g_t_squared() -> None:
    """Central differences are exact for constant accelerations; every node falls alike."""
    made = steps(model([{"use": "gravity", "acceleration": [2.0, -5.0]}], {"square": square(cells=3)}), 200)
    wanted = 0.5 * np.array([2.0, -5.0]) * 0.2**2
    assert made.state["displacement"] == pytest.approx(np.tile(wanted, (16, 1)), rel=1e-11)


def test_gravity_pulls_on_the_bodies_it_names() -> None:
    bodies = {"left": square(), "right": square(3.0)}
    made = steps(model([{"use": "gravity", "acceleration": [0.0, -5.0], "on": ["right"]}], bodies), 50)
    assert mean(made, "right")[1] == pytest.approx(-2.5 * 0.05**2, rel=1e-11)
    assert np.all(mean(made, "left") == 0.0)


def test_a_ramp_of_gravity_gives_half_of_its_time_as_impulse() -> None:
    """3 s^2 - 2 s^3 has the mean 1/2: from the ramp on the speed is g (t - ramp/2)."""
    made = steps(model([{"use": "gravity", "acceleration": [0.0, -5.0], "ramp": 0.1}]), 200)
    # velocities are half a step back; the sum over the ramp is the trapezoidal rule, of error (step/ramp)^2
    assert mean(made, "square", "velocity")[1] == pytest.approx(-5.0 * (0.2 - 0.5 * STEP - 0.05), rel=1e-6)


def test_the_reaction_of_a_hung_block_is_its_weight() -> None:
    """Held at its top and damped until it rests: reaction M g, elongation rho g H^2/2E of the small-strain limit."""
    held = {"on": "square.top", "ux": 0.0, "uy": 0.0}
    made = model(
        [{"use": "gravity", "acceleration": [0.0, -1.0]}], {"square": square(cells=4)}, supports=[held],
        time={"end": 1e3, "step": STEP, "damping": 30.0},
    )  # fmt: skip
    steps(made, 3000)
    assert made.reactions()["square.top"] == pytest.approx([0.0, DENSITY], abs=1e-9 * DENSITY)
    sunk = -made.state["displacement"][: made.bodies[0].count, 1].max(initial=-1.0), made.state["displacement"][:, 1]
    # strains of 1e-3 make a neo-Hookean law linear to that order
    assert sunk[1].min() == pytest.approx(-DENSITY / 2.0, rel=2e-3)


# --- springs ------------------------------------------------------------------------------------------


def test_a_body_on_springs_swings_as_central_differences_say() -> None:
    """u_n = v dt sin(n a)/sin(a) with cos(a) = 1 - k dt^2/2M, along both axes, for equal masses of the nodes."""
    stiffness, speed, count = np.array([3.0, 0.7]), np.array([0.2, -0.1]), 400
    made = model(
        [{"use": "spring", "on": "square", "stiffness": stiffness.tolist()}],
        {"square": square(velocity=speed.tolist())},
    )
    angle = np.arccos(1.0 - 0.5 * stiffness * STEP**2 / DENSITY)
    steps(made, count)
    wanted = speed * STEP * np.sin(count * angle) / np.sin(angle)
    assert made.state["displacement"] == pytest.approx(np.tile(wanted, (4, 1)), rel=1e-9)


def test_springs_of_an_edge_share_their_stiffness() -> None:
    """A block pressed on an edge of springs sinks by force over stiffness, however many nodes there are.

    A set that is listed twice counts once.
    """
    on = ["square.bottom", "square.bottom"]
    load = {"on": "square.top", "ty": -1e-4}
    for cells in (1, 4):
        made = model(
            [{"use": "spring", "on": on, "stiffness": [1.0, 0.01]}], {"square": square(cells=cells)},
            loads=[load], time={"end": 1e3, "step": STEP, "damping": 5.0},
        )  # fmt: skip
        steps(made, 12000)
        bottom = made.state["displacement"][made.reference[:, 1] == 0.0, 1]
        assert bottom.mean() == pytest.approx(-1e-2, rel=1e-6)


@pytest.mark.parametrize("element", ["q1", "q2"])
@pytest.mark.parametrize("on", ["beam.bottom", "beam"])
def test_a_stiff_beam_on_even_springs_sinks_and_turns_as_they_say(element: str, on: str) -> None:
    """Sunk by P/k, turned by P e/(k L^2/12) under a load P at e from the middle, whatever the cells.

    Its cells are eight times as long on the right as on the left: springs that nodes share by number would stand on the
    left. Springs stand at nodes, whose moment of inertia exceeds that of the edge by up to (h/L)^2, and along x
    within the height H of a body, too.
    """
    length, height, stiffness, force, off = 2.0, 0.1, 10.0, 0.01, 0.5
    mesh = {"use": "rectangle", "x": [0.0, 1.0, length], "y": [0.0, height], "cells": [[32, 4], 2]}
    made = model(
        [{"use": "spring", "on": on, "stiffness": [1.0, stiffness]}],
        {"beam": {"element": element, "material": "m", "mesh": mesh}},
        integrator="newton", time={},
        materials={"m": {"use": "linear-elastic", "young": 1e9, "poisson": 0.0, "density": DENSITY}},
        # force / L (1 + 12 e (x - L/2)/L^2): its resultant is `force`, at `off` from the middle
        loads=[{"on": "beam.top", "ty": -force / length, "profile": {"by": "x", "function": {
            "use": "polynomial", "coefficients": [1.0 - 6.0 * off / length, 12.0 * off / length**2]}}}],
    )  # fmt: skip
    made.bound_integrator().step(1.0)
    ends = [int(np.hypot(*(made.reference - [x, 0.0]).T).argmin()) for x in (0.0, length)]
    sunk = made.state["displacement"][ends, 1]
    turned = force * off / (stiffness * length**2 / 12.0) * length / 2.0
    assert sunk.mean() == pytest.approx(-force / stiffness, rel=1e-5)  # k L^3/EI = 1e-3: it bends by less
    assert sunk[0] - sunk[1] == pytest.approx(2.0 * turned, rel=(0.25 / length) ** 2 + (height / length) ** 2)


def test_springs_of_bodies_and_of_edge_sets_are_declared_apart() -> None:
    with pytest.raises(ContactlabError, match="bodies and edge sets in one list"):
        model([{"use": "spring", "on": ["square", "square.top"], "stiffness": [1.0, 1.0]}])
    with pytest.raises(ContactlabError, match="no such body"):
        model([{"use": "spring", "on": ["square", "disc"], "stiffness": [1.0, 1.0]}])


# --- damping ------------------------------------------------------------------------------------------


def test_damping_leaves_rigid_motion_alone() -> None:
    """A square that flies and spins, shaken at random: both momenta stay to round-off, the shaking dies out."""
    made = model(
        [{"use": "vibration-damping", "rate": 20.0}],
        {"square": square(cells=3, velocity=[0.3, -0.2], spin=1.0)},
    )
    random = np.random.default_rng(3)
    made.state["velocity"][:] += 0.01 * random.standard_normal(made.reference.shape)
    advance = made.bound_integrator().step
    advance(STEP)

    def momenta() -> np.ndarray:
        v, r = made.state["velocity"], made.position
        return np.array([*(made.mass @ v), made.mass @ (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0])])

    def shaking() -> float:
        v, own = made.state["velocity"], made.position - made.mass @ made.position / made.mass.sum()
        rest = v - made.mass @ v / made.mass.sum()
        turn = made.mass @ (own[:, 0] * rest[:, 1] - own[:, 1] * rest[:, 0]) / (made.mass @ (own**2).sum(axis=1))
        rest -= turn * np.stack([-own[:, 1], own[:, 0]], axis=1)
        return float(made.mass @ (rest**2).sum(axis=1))

    start, before = momenta(), shaking()
    for _ in range(2000):
        advance(STEP)
    # the spin is taken out with velocities half a step old, whose moment about the present centre is the same
    assert momenta() == pytest.approx(start, rel=1e-11)
    # velocities half a step old have a share towards the centre, w^2 r dt/2 = 2e-4: 3e-4 of the shaking here
    assert shaking() < 1e-3 * before


@pytest.mark.parametrize("rate", [1.0, 4.0])
def test_vibrations_die_out_as_an_exponential(rate: float) -> None:
    """The first mode along a bar: its energy falls by exp(-rate t)."""
    bar = square(cells=1) | {"mesh": {"use": "rectangle", "x": [0.0, 8.0], "y": [0.0, 1.0], "cells": [16, 1]}}
    made = model([{"use": "vibration-damping", "rate": rate}], {"bar": bar})
    mode = np.cos(math.pi * made.reference[:, 0] / 8.0)
    made.state["velocity"][:, 0] = 1e-3 * mode
    advance, energy = made.bound_integrator().step, []
    for _ in range(1501):
        internal = made.state["internal_force"].copy()
        advance(STEP)
        energy.append(made.kinetic_energy() + 0.5 * float((internal * made.state["displacement"]).sum()))
    # over many periods of 0.72 s / 16 cells of dispersion; damping acts twice a period, in waves of rate/2w
    slope = np.polyfit(STEP * np.arange(len(energy)), np.log(energy), 1)[0]
    assert slope == pytest.approx(-rate, rel=0.03)


def test_damping_ends_when_it_says() -> None:
    made = model([{"use": "vibration-damping", "rate": 20.0, "until": 0.01}], {"square": square(cells=2)})
    made.state["velocity"][:, 0] = 1e-3 * np.cos(math.pi * made.reference[:, 0])
    steps(made, 11)
    before = made.state["work"][1]
    assert before < 0.0
    steps(made, 100)
    assert made.state["work"][1] == before


# --- attraction ---------------------------------------------------------------------------------------


def test_two_bodies_draw_each_other_together() -> None:
    """Distance d0 - F/2 (1/m1 + 1/m2) t^2, each on its way, no turning, no momentum."""
    bodies = {
        "light": square(),
        "heavy": square() | {"mesh": {"use": "rectangle", "x": [3.0, 5.0], "y": [4.0, 6.0], "cells": [2, 2]}},
    }
    made = model([{"use": "attraction", "between": ["light", "heavy"], "force": 3e-3}], bodies)
    towards = np.array([3.5, 4.5]) / math.hypot(3.5, 4.5)
    steps(made, 300)
    for name, mass, sign in (("light", DENSITY, 1.0), ("heavy", 4.0 * DENSITY, -1.0)):
        wanted = sign * 0.5 * 3e-3 / mass * 0.3**2 * towards
        assert mean(made, name) == pytest.approx(wanted, rel=1e-11)
    assert made.mass @ made.state["velocity"] == pytest.approx([0.0, 0.0], abs=1e-15)
    assert made.state["internal_force"] == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize(("between", "word"), [(["square", "square"], "different"), (["square", "ghost"], "ghost")])
def test_a_wrong_pair_is_refused(between: list[str], word: str) -> None:
    with pytest.raises(ContactlabError, match=word) as refused:
        model([{"use": "attraction", "between": between, "force": 1.0}])
    assert "effects.0.between" in str(refused.value)
