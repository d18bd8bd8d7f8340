"""Explicit steps follow what effects add to stiffness and damping."""

from __future__ import annotations

import numpy as np
import pytest

import contactlab
from contactlab.api import Floats, State
from contactlab.errors import SceneError
from contactlab.model.build import build
from contactlab.model.loading.effect_rates import EffectRates, effect_rates

FREE = {"contacts": [], "rigid": {}, "record.recorders": []}
BODIES = 1e-3  # s, stable step of the bodies in what follows


def rates(effect: object, mass: Floats) -> EffectRates:
    state = State({"displacement": (len(mass), 2), "velocity": (len(mass), 2)})
    before = state["displacement"].copy()
    found = effect_rates([effect(state)], state, mass, 10.0, BODIES, (0.0, 1.0))  # type: ignore[operator]
    assert (state["displacement"] == before).all()
    assert (state["velocity"] == before).all()
    return found


def test_springs_and_dampers_are_found_exactly_and_constant_forces_not_at_all() -> None:
    mass = np.full(20, 2e-3)

    def spring_and_damper(state: State) -> object:
        def pull(time: float, force: Floats) -> None:
            force -= 5.0 * state["displacement"] + 0.3 * state["velocity"]
            force += 1e6  # a large constant force

        return pull

    found = rates(spring_and_damper, mass)
    assert found.square == pytest.approx(5.0 / 2e-3, rel=1e-6)  # differences of forces that are 1e9 times as large
    assert found.damping == pytest.approx(0.3 / 2e-3, rel=1e-6)
    assert rates(lambda state: lambda time, force: force.__iadd__(3.0), mass) == EffectRates()


def test_the_stiffest_node_counts_and_rigid_surfaces_do_not() -> None:
    mass = np.linspace(1e-3, 3e-3, 30)
    mass[7] = 0.0  # of a rigid surface
    stiffness = np.linspace(1.0, 2.0, 30)[:, None]

    def springs(state: State) -> object:
        return lambda time, force: force.__isub__(stiffness * state["displacement"])

    most = np.max(stiffness[mass > 0.0, 0] / mass[mass > 0.0])
    # twelve iterations; the next eigenvalues are 6 % lower: from below, within what MARGIN allows
    assert most / 1.05 < rates(springs, mass).square <= most * (1.0 + 1e-9)


def test_forces_that_jump_have_no_rate() -> None:
    """Dry friction at rest: by differences it would be the stiffer the smaller they are, and steps without end."""

    def drag(state: State) -> object:
        return lambda time, force: force.__isub__(4.0 * np.sign(state["velocity"]))

    assert rates(drag, np.full(20, 2e-3)) == EffectRates()


@pytest.mark.parametrize(("square", "damping"), [(0.0, 800.0), (4e6, 0.0), (2e6, 3000.0)])
def test_central_differences_stay_bounded_up_to_the_limit_and_not_beyond(square: float, damping: float) -> None:
    limit = EffectRates(square / 1.05, damping / 1.05).limit(BODIES)  # without the margin
    total = 4.0 / BODIES**2 + square  # the highest mode of the bodies, with the effects on it

    def largest(dt: float) -> float:
        roots = np.roots([1.0, -(2.0 - total * dt**2 - damping * dt), 1.0 - damping * dt])
        return float(np.abs(roots).max())

    assert largest(0.999 * limit) <= 1.0 + 1e-12
    assert largest(1.001 * limit) > 1.0 + 1e-6
    assert EffectRates().limit(BODIES) == pytest.approx(BODIES, rel=1e-15)


@pytest.mark.parametrize(
    "effect",
    [
        {"use": "spring", "on": "block", "stiffness": [1e5, 1e5]},
        {"use": "vibration-damping", "rate": 1e6},
    ],
    ids=lambda effect: effect["use"],
)
def test_a_stiff_effect_shortens_steps_instead_of_ending_the_run(effect: dict[str, object]) -> None:
    """Each of them makes steps of 0.9 of the bodies' stable one diverge."""
    scene = contactlab.load_scene("dropped-block").with_({**FREE, "effects": [effect], "time.end": 2e-4})
    scene = scene.with_({"bodies.block.velocity": [50.0, 20.0]})
    model = build(scene, scene.registry)
    bodies = 0.9 * model.stable_step()
    assert model.step_within(0.9) < 0.7 * bodies
    done = contactlab.simulate(scene)
    assert done.summary["status"] == "finished"
    assert abs(done.history["energy.error"][-1]) < 1e-9
    with pytest.raises(SceneError, match="fixed step is longer") as refused:
        contactlab.simulate(scene.with_({"time.step": bodies}))
    assert "effects (springs, damping)" in str(refused.value)


def test_effects_that_steps_follow_anyway_change_no_step() -> None:
    scene = contactlab.load_scene("dropped-block")  # gravity and damping
    model = build(scene, scene.registry)
    assert model.loading.rates.damping == pytest.approx(float(scene.effects[1]["rate"]), rel=1e-6)
    assert model.step_within(0.9) == 0.9 * model.stable_step()
