"""What follows the clock holds at the end of a step that iterates: overlaps, supports, loads, effects, laws of rate.

Blocks of nu = 0 that nothing holds along their sides strain evenly, so that every reaction has a closed form at every
stored frame, whatever the number of steps.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contactlab.api import StepStatus
from contactlab.explanation.explain import explain
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.registry import Registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

YOUNG, OVERLAP, END = 1000.0, 0.0025, 1e-3
LAW = {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1e-6}


def smooth(share: float) -> float:
    s = min(1.0, share)
    return s * s * (3.0 - 2.0 * s)


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
@pytest.mark.parametrize("steps", [1, 10])
@pytest.mark.parametrize("duration", [4e-4, 1e-3])
def test_a_relaxed_overlap_is_all_there_when_its_ramp_is_over(algorithm: str, steps: int, duration: float) -> None:
    """Two blocks of height 0.5 each that overlap by d press each other with E d, at every frame by the ramp so far."""
    results = simulate(
        load_scene("initial-overlap").with_(
            {
                "integrator": {"use": "newton", "steps": steps},
                "contacts.0.algorithm": algorithm,
                "contacts.0.start.duration": duration,
                "supports.3.uy.to": 0.0,
            }
        )
    )
    assert results.status == "finished"
    history = results.history
    expected = [YOUNG * OVERLAP * smooth(time / duration) for time in history["time"]]
    # residuals of 1e-8 of the largest force
    assert history["lower.bottom.fy"] == pytest.approx(expected, abs=1e-7)
    assert history["lower.bottom.fy"][-1] == pytest.approx(2.5, abs=1e-7)


def test_relaxation_is_passed_in_as_many_steps_as_loading() -> None:
    """Half of the wished steps push the overlap out, half press: what happens on the way is followed alike."""
    scene = load_scene("initial-overlap").with_({"integrator": {"use": "newton", "steps": 10}, "record.frames": 1000})
    times = simulate(scene).history["time"]
    relaxed = [time for time in times if 0.0 < time <= 4e-4 * (1.0 + 1e-9)]
    assert relaxed[-1] == pytest.approx(4e-4), "a step ends where the relaxation does"
    assert len(relaxed) == pytest.approx(5, abs=1)


def test_a_relaxed_overlap_is_all_there_in_steps_in_time() -> None:
    """The gap of pressed surfaces is zero at the end of the run to round-off, however few its steps."""
    for steps in (5, 50):
        model = stepped(
            load_scene("initial-overlap").with_(
                {
                    "integrator": {"use": "implicit-dynamics", "steps": steps},
                    "contacts.0.start.duration": END,
                    "supports.3.uy.to": 0.0,
                }
            ),
            END,
            steps,
        )
        pair = model.contact.pairs[0]
        forces = model.state["multipliers"][0]
        upper, lower = (model.position[side.nodes, 1] for side in (pair.slave, pair.master))
        assert (forces > 0.0).sum() >= 4
        assert upper == pytest.approx(np.full(len(upper), lower.mean()), abs=1e-9)


def column(**more: Any) -> dict[str, Any]:
    mesh = {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [2, 2]}
    return {
        "name": "column",
        "time": {"end": 1.0},
        "integrator": {"use": "newton", "steps": 3},
        "materials": {"m": LAW},
        "bodies": {"column": {"element": "q1", "material": "m", "mesh": mesh}},
        "supports": [{"on": "column.bottom", "uy": 0.0}, {"on": "column", "ux": 0.0}],
        **more,
    }


@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("shape", ["linear", "parabola", "smooth"])
def test_loads_and_supports_are_those_of_the_end_of_the_step(shape: str, steps: int) -> None:
    """Reactions of 2 E u and of -2 p at every frame."""
    ramp = {"linear": lambda s: s, "parabola": lambda s: 1.0 - (1.0 - s) ** 2, "smooth": smooth}[shape]
    newton = {"use": "newton", "steps": steps}
    load = {"on": "column.top", "pressure": {"ramp": shape, "to": 3.0}, "follower": False}
    pushed = simulate(Scene.from_data(column(loads=[load], integrator=newton))).history
    assert pushed["column.bottom.fy"] == pytest.approx([6.0 * ramp(t) for t in pushed["time"]], abs=1e-6)
    held = column(integrator=newton)
    held["supports"].append({"on": "column.top", "uy": {"ramp": shape, "to": -0.001}})
    moved = simulate(Scene.from_data(held)).history
    assert moved["column.bottom.fy"] == pytest.approx([2.0 * ramp(t) for t in moved["time"]], abs=1e-6)


@pytest.mark.parametrize("steps", [1, 3])
def test_effects_are_those_of_the_end_of_the_step(steps: int) -> None:
    """Gravity that rises over the first 0.7 s: the bottom bears the weight times the ramp at every frame."""
    gravity = {"use": "gravity", "acceleration": [0.0, -9810.0], "ramp": 0.7}
    scene = Scene.from_data(column(effects=[gravity], integrator={"use": "newton", "steps": steps}))
    history = simulate(scene).history
    weight = 2.0 * LAW["density"] * 9810.0
    assert history["column.bottom.fy"] == pytest.approx([weight * smooth(t / 0.7) for t in history["time"]], rel=1e-7)


@pytest.mark.parametrize("use", ["newton", "implicit-dynamics"])
@pytest.mark.parametrize("steps", [1, 3])
def test_rigid_surfaces_are_where_the_end_of_the_step_puts_them(use: str, steps: int) -> None:
    """A plate that presses a column 0.001 down and moves aside by 0.3."""
    data = column(integrator=use)
    motion = {"ux": {"ramp": "linear", "to": 0.3}, "uy": {"ramp": "smooth", "to": -0.001}}
    data["rigid"] = {"plate": {"line": [[-1.0, 1.0], [3.0, 1.0]], **motion}}
    data["contacts"] = [{"slave": "column.top", "master": "plate", "algorithm": "mortar-p1"}]
    for time in (np.arange(steps) + 1.0) / steps:
        model = stepped(Scene.from_data(data), time, round(time * steps))
        top = model.position[model.contact.pairs[0].slave.nodes, 1]
        plate = model.loading.supports[-1].nodes
        expected = np.tile([0.3 * time, -0.001 * smooth(time)], (len(plate), 1))
        assert model.state["displacement"][plate] == pytest.approx(expected, abs=1e-15)
        # residuals of 1e-8 of a segment
        assert top == pytest.approx(np.full(len(top), 1.0 - 0.001 * smooth(time)), abs=1e-8)


# --- laws that depend on rate -------------------------------------------------------------------

MAXWELL = """
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import Kinematics, Material
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Maxwell(Material):
    \"\"\"A spring and a damper in a row, nu = 0, by the backward Euler rule.

    young    [MPa]
    time     of relaxation [s]
    density  [t/mm3]
    \"\"\"

    young: float
    time: float
    density: float

    kinematics: ClassVar[Kinematics] = "small"
    history_size: ClassVar[int] = 6
    history_names: ClassVar[tuple[str, ...]] = ("s_xx", "s_yy", "s_xy", "e_xx", "e_yy", "e_xy")
    rate_dependent: ClassVar[bool] = True

    def wave_speeds(self):
        return (self.young / self.density) ** 0.5, (0.5 * self.young / self.density) ** 0.5

    def stress(self, gradient, history, dt, stress, new_history):
        strain = gradient[0], gradient[3], 0.5 * (gradient[1] + gradient[2])
        fade = 1.0 / (1.0 + dt / self.time)
        for k in range(3):
            new = fade * (history[k] + self.young * (strain[k] - history[3 + k]))
            new_history[k], new_history[3 + k] = new, strain[k]
        stress[0], stress[1], stress[2], stress[3] = new_history[0], new_history[1], 0.0, new_history[2]


@hookimpl
def contactlab_parts():
    return [Part("material", "maxwell", "maxwell:Maxwell", "for tests")]
"""
RELAXATION, RISE, STRETCH = 0.4, 0.2, 1e-3


@pytest.fixture(scope="module")
def maxwell(tmp_path_factory: pytest.TempPathFactory) -> Registry:
    """The installed parts and a law that relaxes."""
    file = tmp_path_factory.mktemp("law") / "maxwell.py"
    file.write_text(MAXWELL)
    return Registry(files=[file])


def relaxing(registry: Registry, steps: int, law: str = "maxwell") -> Scene:
    """A column stretched within the first 0.2 s, then held for two times of relaxation."""
    data = column(integrator={"use": "newton", "steps": steps}, record={"frames": 10000})
    data["materials"] = {
        "m": {"use": law, "young": YOUNG, "density": 1e-6}
        | ({"time": RELAXATION} if law == "maxwell" else {"poisson": 0.0})
    }
    data["supports"].append({"on": "column.top", "uy": {"ramp": "linear", "to": STRETCH, "duration": RISE}})
    return Scene.from_data(data, registry=registry)


def maxwell_stress(time: Any) -> Any:
    """Exact for a strain that rises evenly and then stays: E e (tau / T) (1 - exp(-t/tau)), and its decay."""
    risen = np.minimum(time, RISE)
    peak = YOUNG * STRETCH * RELAXATION / RISE * (1.0 - np.exp(-risen / RELAXATION))
    return peak * np.exp(-(time - risen) / RELAXATION)


def test_a_time_that_the_program_chose_is_told_where_a_law_depends_on_rate(maxwell: Registry) -> None:
    """The ramp of 0.2 s is over before the run: what relaxes after it depends on an end that nobody wrote."""
    for law, time, told in (("maxwell", {}, True), ("maxwell", {"end": 1.0}, False), ("linear-elastic", {}, False)):
        scene = relaxing(maxwell, 5, law).with_({"time": time})
        assert ("chosen-time" in {warning.code for warning in build(scene, maxwell).warnings}) == told


def test_a_hold_is_followed_where_a_law_depends_on_rate(maxwell: Registry) -> None:
    """As many steps as the scene wishes; the error of the law's own rule halves with their length."""
    errors = []
    for steps in (40, 80):
        results = simulate(relaxing(maxwell, steps))
        assert results.status == "finished"
        history = results.history
        assert results.summary["steps"] == pytest.approx(steps, abs=1)
        found = -history["column.bottom.fy"] / 2.0
        errors.append(np.abs(found - maxwell_stress(history["time"]))[-1] / maxwell_stress(1.0))
    # backward Euler: of 40 steps the hold gets 0.8/1.8, and n steps over two times t leave (1 + 2/n)^-n / exp(-2) - 1
    assert errors[0] == pytest.approx((1.0 + 2.0 / 18.0) ** -18 / np.exp(-2.0) - 1.0, rel=0.1)
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_explain_says_what_load_steps_follow(maxwell: Registry) -> None:
    rated, elastic = (explain(relaxing(maxwell, 40, law), maxwell).scene for law in ("maxwell", "linear-elastic"))
    assert rated.steps_follow == "loading and time: material of column is rate-dependent"
    assert elastic.steps_follow == "loading"
    assert rated.estimated_steps == pytest.approx(40, abs=1)
    assert elastic.estimated_steps == 41, "a hold of what does not depend on rate is passed in one step"


def stepped(scene: Scene, end: float, steps: int) -> Model:
    """The model after equal steps up to a time [s]."""
    model = build(scene, scene.registry)
    advance = model.bound_integrator().step
    for _ in range(steps):
        assert advance(end / steps).status is StepStatus.accepted
    return model
