"""What a scene declares in time is simulated to its end, warned of, or refused, whatever the integrator.

Two blocks of equal height under an even displacement strain evenly; statics give the force in one step. Times are a few
periods of the lowest mode, so that explicit runs stay short, and far beyond the end that the program would choose.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.api import Step
from contactlab.errors import SceneError
from contactlab.missing_effects.quasi_static import work_detectors
from contactlab.model.build import build
from contactlab.results.results import Results
from contactlab.run.prepare import schedule_of
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

HELD = {"on": "l.bottom", "ux": 0.0, "uy": 0.0}
TO = -0.02
LATE = 2e-3  # s; the program would end at 4e-4 s, or at 2e-4 s without a history
EACH = ("central-difference", "implicit-dynamics", "newton")
IMPLICIT = {"use": "implicit-dynamics", "steps": 330}  # two of them in the lowest period, in a run of 0.3 of `LATE`


def block(y: list[float], cells: list[int]) -> dict[str, Any]:
    return {"element": "q1", "material": "m", "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": y, "cells": cells}}


def blocks(integrator: Any, uy: Any = TO, **more: Any) -> Scene:
    """A block pressed on another one; more: tables of the scene."""
    law = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}
    return Scene.from_data(
        {
            "integrator": integrator,
            "materials": {"m": law},
            "bodies": {"l": block([-1.0, 0.0], [4, 2]), "u": block([0.0, 1.0], [3, 2])},
            "contacts": [{"slave": "u.bottom", "master": "l.top", "algorithm": "mortar-p0"}],
            "supports": [HELD, {"on": "u.top", "ux": 0.0, "uy": uy}],
            "record": {"frames": 4, "recorders": []},
            **more,
        }
    )


def force(results: Results) -> float:
    return float(results.history["l.bottom.fy"][-1])


def codes(results: Results) -> list[str]:
    return [warning["code"] for warning in results.summary["warnings"]]


@pytest.fixture(scope="module")
def pressed() -> float:
    """The force of the whole displacement."""
    return force(simulate(blocks("newton")))


TIMES: dict[str, dict[str, Any]] = {
    "duration": {"ramp": "linear", "to": TO, "duration": LATE},
    "begin": {"ramp": "linear", "to": TO, "begin": LATE},
    "table": {"ramp": "table", "to": TO, "points": [[0.0, 0.0], [0.5 * LATE, 0.1], [LATE, 1.0]]},
    "step": {"ramp": "constant", "to": TO, "begin": LATE},
}


def later(times: dict[str, Any], factor: float) -> dict[str, Any]:
    """A table of a value in time with all times multiplied."""
    found = {key: factor * value if key in ("duration", "begin") else value for key, value in times.items()}
    return found | ({"points": [[factor * t, f] for t, f in times["points"]]} if "points" in times else {})


EXPLICIT, STATIC = ("central-difference", 1.0), ("newton", 3.0 / LATE)
AUTOMATIC = [*((how, *use) for use in (EXPLICIT, STATIC) for how in TIMES)]


@pytest.mark.parametrize(
    ("how", "integrator", "factor"),
    [
        *some(AUTOMATIC, [("table", *EXPLICIT), *((how, *STATIC) for how in TIMES)]),
        pytest.param("duration", IMPLICIT, 0.3, marks=pytest.mark.full),
    ],
)
def test_an_automatic_end_does_not_cut_a_support(how: str, integrator: Any, factor: float, pressed: float) -> None:
    """1 %: what reactions may still swing by when a run is called settled is 2e-4."""
    results = simulate(blocks(integrator, later(TIMES[how], factor)))
    assert results.status == "finished", results.reason
    assert results.history["time"][-1] >= factor * LATE * (1.0 - 1e-9)
    assert force(results) == pytest.approx(pressed, rel=0.01)


@pytest.mark.parametrize(
    ("integrator", "end"),
    [
        pytest.param("central-difference", LATE, marks=pytest.mark.full),
        ("newton", 3.0),
        pytest.param(IMPLICIT, 0.3 * LATE, marks=pytest.mark.full),
    ],
)
def test_an_automatic_end_does_not_cut_loads_gravity_and_overlaps(integrator: Any, end: float) -> None:
    """A load of 1 on a length of 2 and a weight of 4; an overlap of 0.01 as statics have it without times."""
    sides = [HELD, {"on": "u.left", "ux": 0.0}]
    heavy = {"use": "gravity", "acceleration": [0.0, -1e9]}
    load = {"on": "u.top", "ty": {"ramp": "linear", "to": -1.0, "duration": end}}
    found = simulate(blocks(integrator, supports=sides, loads=[load], effects=[heavy | {"ramp": end}]))
    assert found.status == "finished", found.reason
    assert force(found) == pytest.approx(2.0 + 4.0, rel=0.01)
    overlap = {"u": block([-0.01, 1.0], [3, 2]), "l": block([-1.0, 0.0], [4, 2])}
    contact = {"slave": "u.bottom", "master": "l.top", "algorithm": "mortar-p0"}
    expected, ramped = (
        simulate(blocks(use, 0.0, bodies=overlap, contacts=[contact | {"start": {"overlap": "ramp"} | how}]))
        for use, how in (("newton", {}), (integrator, {"duration": end}))
    )
    assert ramped.status == "finished", ramped.reason
    assert force(ramped) == pytest.approx(force(expected), rel=0.01)


@pytest.mark.parametrize("integrator", EACH)
def test_what_a_written_end_cuts_is_told_with_key_time_and_share(integrator: str) -> None:
    late = {"ramp": "linear", "to": TO, "duration": 4e-4}
    model = build(blocks(integrator, late, time={"end": 1e-4}, effects=[
        {"use": "gravity", "acceleration": [0.0, -1.0], "ramp": 2e-4}]), None or blocks("newton").registry)  # fmt: skip
    told = {warning.key: warning for warning in model.warnings if warning.code == "beyond-end"}
    assert set(told) == {"supports.1.uy.duration", "effects.0.ramp"}
    ramp = told["supports.1.uy.duration"]
    assert (ramp.value, ramp.limit) == (4e-4, 1e-4)
    assert "75% of its time" in ramp.text
    assert "0.25 of `to`" in ramp.text
    assert "write time.end = 0.0004" in ramp.text
    assert "50% of its time" in told["effects.0.ramp"].text


def test_a_table_that_rests_beyond_the_end_loses_nothing() -> None:
    registry = blocks("newton").registry
    for last, told in ((1.0, 0), (0.5, 1)):
        table = {"ramp": "table", "to": TO, "points": [[0.0, 0.0], [5e-5, 1.0], [1.5e-4, 1.0], [2e-4, last]]}
        model = build(blocks("newton", table, time={"end": 1e-4}), registry)
        assert sum(warning.code == "beyond-end" for warning in model.warnings) == told


def test_the_ramp_of_the_run_and_its_hold_are_declared_too() -> None:
    uy = {"ramp": "linear", "to": TO}
    model = build(scene := blocks("newton", uy, time={"end": 1.0, "ramp": 4.0, "hold": 1.0}), scene.registry)
    assert {warning.key for warning in model.warnings} == {"time.ramp", "time.hold"}
    longer = build(scene := blocks("newton", uy, time={"ramp": 4.0, "hold": 1.0}), scene.registry)
    assert longer.timing.last == pytest.approx(5.0)
    assert not longer.warnings


@pytest.mark.parametrize("integrator", EACH)
def test_a_ramp_that_begins_later_fills_what_is_left_of_the_run(integrator: str) -> None:
    uy = {"ramp": "linear", "to": TO, "begin": 1e-4}
    model = build(scene := blocks(integrator, uy, time={"end": 4e-4}), scene.registry)
    values = [float(model.prescribed.values(time).copy()[-1]) for time in (1e-4, 2.5e-4, 4e-4)]
    assert values == pytest.approx([0.0, 0.5, 1.0])
    assert not model.warnings


@pytest.mark.parametrize("integrator", EACH)
def test_a_function_without_an_end_asks_for_one(integrator: str) -> None:
    wave = {"ramp": "function", "to": TO, "function": {"use": "sine", "period": 1e-3}}
    with pytest.raises(SceneError) as told:
        build(scene := blocks(integrator, wave), scene.registry)
    assert "supports.1.uy.function" in str(told.value)
    assert "write end = 1.0 under [time]" in str(told.value)
    pulse = {"ramp": "function", "to": TO, "function": {"use": "half-ellipse", "half_width": LATE, "centre": LATE}}
    model = build(scene := blocks(integrator, pulse), scene.registry)
    assert model.timing.last == pytest.approx(max(2.0 * LATE, 1.0 if integrator == "newton" else 0.0))


@pytest.mark.parametrize("key", ["velocity", "spin"])
def test_bodies_that_are_thrown_in_statics_are_refused(key: str) -> None:
    value: Any = [0.0, -100.0] if key == "velocity" else 3.0
    scene = blocks("newton").with_({f"bodies.u.{key}": value})
    with pytest.raises(SceneError, match=f"bodies.u.{key}") as told:
        build(scene, scene.registry)
    assert "integrator with inertia" in str(told.value)
    build(moving := scene.with_({"integrator": "implicit-dynamics"}), moving.registry)


@pytest.mark.parametrize("integrator", EACH[:2])
@pytest.mark.parametrize("key", ["velocity", "spin"])
def test_an_initial_motion_that_quasi_static_damping_takes_is_told(integrator: str, key: str) -> None:
    scene = blocks(integrator).with_({f"bodies.u.{key}": [0.0, -100.0] if key == "velocity" else 3.0})
    for time, told in (({}, {f"bodies.u.{key}"}), ({"end": LATE}, set()), ({"damping": 0.0}, set())):
        model = build(changed := scene.with_({"time": time}), changed.registry)
        assert {warning.key for warning in model.warnings if warning.code == "damped-velocity"} == told


def test_steps_of_quasi_static_implicit_dynamics_follow_the_period() -> None:
    """The midpoint rule keeps vibrations that are shorter than a step; a hundred million steps are refused instead."""
    late = {"ramp": "linear", "to": TO, "duration": LATE}
    model = build(scene := blocks("implicit-dynamics", late), scene.registry)
    assert schedule_of(model, scene).dt <= 0.5 * model.timing.period * (1.0 + 1e-12)
    model = build(scene := blocks("implicit-dynamics", late | {"duration": 1e3}), scene.registry)
    with pytest.raises(SceneError, match=r"supports.1.uy.duration"):
        schedule_of(model, scene)


@pytest.mark.parametrize(
    ("integrator", "uy", "key", "line"),
    [
        ("central-difference", {"duration": LATE}, "supports.1.uy.duration", "supports.1.uy.duration = 0.02 "),
        ("central-difference", {"begin": LATE}, "time.ramp", "write time.ramp = "),
        ("implicit-dynamics", {"duration": LATE}, "supports.1.uy.duration", "supports.1.uy.duration = 0.02 "),
        ({"use": "implicit-dynamics", "steps": 20}, {"duration": LATE}, "integrator.steps", "or omit it"),
    ],
)
def test_a_loading_that_is_too_fast_is_told_by_the_key_that_slows_it(
    integrator: Any, uy: dict[str, float], key: str, line: str
) -> None:
    """Steps that are longer than half a period vibrate however slow the loading is."""
    scene = blocks(integrator, {"ramp": "linear", "to": TO, **uy}, time={"history": True})
    detector = next(iter(work_detectors(scene, build(scene, scene.registry))))
    detector.worst[:] = 0.9, 1.0
    told = detector.warning()
    assert told is not None
    assert told.key == key
    assert line in told.text


# --- values that go to and fro ----------------------------------------------------------------------

AMPLITUDE, MU = 0.05, 0.3


def dragged(period: float, integrator: Any = "newton", end: float = 1.0, **time: float) -> Scene:
    """A block pressed on a longer one and drawn to and fro by a sine."""
    wave = {"ramp": "function", "to": AMPLITUDE, "begin": 0.1 * end, "function": {"use": "sine", "period": period}}
    press = {"ramp": "linear", "to": -0.01, "duration": 0.1 * end}
    scene = blocks(integrator, press, time={"end": end, **time})
    return scene.with_({
        "bodies.l.mesh.x": [-1.0, 3.0], "bodies.l.mesh.cells": [8, 2],
        "contacts.0.friction": {"use": "coulomb", "mu": MU}, "supports.1.ux": wave,
    })  # fmt: skip


def friction_work(results: Results) -> float:
    assert results.status == "finished", results.reason
    return float(results.summary["balance"]["friction"])


def test_load_increments_follow_a_sine() -> None:
    """Friction work within 5 % of that of three times as many steps; ten steps of the whole gave less than 10 % of it.

    Beside it the work of a rigid block on each way, mu N times twice the amplitude, of which shear takes some.
    """
    found, fine = (simulate(dragged(0.1, use, 0.2)) for use in ("newton", {"use": "newton", "steps": 150}))
    assert friction_work(found) == pytest.approx(friction_work(fine), rel=0.05)
    assert found.summary["steps"] < 100
    assert "coarse-steps" not in codes(found)
    rigid = MU * abs(force(fine)) * AMPLITUDE * 7.05  # 0.18 s are 1.8 periods: 7 quarters, and 1 - cos 18 degrees
    assert 0.7 * rigid < friction_work(fine) < 1.01 * rigid


def test_friction_that_turns_at_once_loses_no_work() -> None:
    """A stiff pad on a rigid floor: mu N times the way. The step in which friction turns books none, and is short."""
    stiff = {"use": "linear-elastic", "young": 2e5, "poisson": 0.0, "density": 1e-9}
    wave = {"ramp": "function", "to": AMPLITUDE, "function": {"use": "sine", "period": 0.5}}
    results = simulate(Scene.from_data({
        "time": {"end": 0.5},
        "integrator": "newton",
        "materials": {"m": stiff},
        "bodies": {"pad": block([0.0, 0.5], [2, 1])},
        "rigid": {"floor": {"line": [[4.0, 0.0], [-2.0, 0.0]]}},
        "contacts": [{"slave": "pad.bottom", "master": "floor", "algorithm": "mortar-p0",
                      "friction": {"use": "coulomb", "mu": MU}}],
        "supports": [{"on": "pad.top", "ux": wave}],
        "loads": [{"on": "pad.top", "ty": -20.0}],
        "record": {"frames": 4, "recorders": []},
    }))  # fmt: skip
    assert friction_work(results) == pytest.approx(MU * 40.0 * 4.0 * AMPLITUDE, rel=0.01)


def test_steps_end_where_a_function_turns_and_where_an_effect_is_over() -> None:
    scene = dragged(0.25).with_({"effects": [{"use": "gravity", "acceleration": [0.0, -1.0], "ramp": 0.33}]})
    schedule = schedule_of(build(scene, scene.registry), scene)
    turns = 0.1 + 0.25 * (0.25 + 0.5 * np.arange(7))
    corners = np.array(schedule.path.corners)  # type: ignore[attr-defined]
    for time in (0.1, 0.33, *turns, 1.0):
        assert np.abs(corners - time).min() < 1e-6
    assert len(corners) == len(turns) + 3


@pytest.mark.parametrize(
    ("fixed", "key"),
    [
        ({"integrator": {"use": "newton", "steps": 10}}, "integrator.steps"),
        pytest.param({"step": 0.1}, "time.step", marks=pytest.mark.full),
    ],
)
def test_steps_that_the_scene_fixes_too_few_are_told_with_the_sampling(fixed: dict[str, Any], key: str) -> None:
    scene = dragged(0.25, **fixed)
    (told,) = (warning for warning in simulate(scene).warnings if warning.code == "coarse-steps")
    assert told.key == key
    assert "supports.1.ux" in told.text
    assert told.value < 2.0
    better = json.loads(told.text.partition(f"write {key} = ")[2].partition(",")[0])
    assert "coarse-steps" not in codes(simulate(scene.with_({key: better})))


def test_fixed_steps_of_statics_end_where_the_loading_turns_too() -> None:
    """Steps of 0.13 s passed the peaks of a table at 0.35 and 0.7 s by 0.04 and 0.08 s, and never saw them."""
    table = {"ramp": "table", "to": AMPLITUDE, "points": [[0.1, 0.0], [0.35, 1.0], [0.7, -1.0], [1.0, 1.0]]}
    scene = dragged(0.25, step=0.13).with_({"supports.1.ux": table})
    found = simulate(scene.with_({"record.frames": 1000}))
    assert {0.1, 0.35, 0.7, 1.0} <= set(np.round(found.history["time"], 9).tolist())
    assert found.summary["steps"] == 1 + 2 + 3 + 3  # of at most 0.13 s, from corner to corner


def test_implicit_steps_in_time_are_short_where_a_value_swings_and_only_there() -> None:
    """A pulse of a thousandth of the run: at least eight steps of each way, and the rest in the usual ones."""
    pulse = {
        "ramp": "function",
        "to": -1.0,
        "begin": 0.5,
        "function": {"use": "half-ellipse", "half_width": 5e-4, "centre": 5e-4},
    }
    scene = blocks("implicit-dynamics", loads=[{"on": "u.top", "ty": pulse}], supports=[HELD], time={"end": 1.0})
    model = build(scene, scene.registry)
    schedule = schedule_of(model, scene)
    times = [0.0]
    while times[-1] < 1.0 - 1e-9:
        model.state["clock"][0] = times[-1]
        schedule.every_step[0](Step(iterations=1), 0.0)  # type: ignore[arg-type]
        times.append(times[-1] + schedule.dt)
    inside = [time for time in times if 0.5 < time < 0.501]
    assert len(inside) >= 16
    assert len(times) < 540


def test_frames_that_cannot_show_a_wave_are_told() -> None:
    scene = dragged(0.1).with_({"record.frames": 20})
    model = build(scene, scene.registry)
    schedule_of(model, scene)
    (told,) = (warning for warning in model.warnings if warning.code == "coarse-frames")
    frames = int(told.text.rpartition("record.frames = ")[2])
    model = build(more := scene.with_({"record.frames": frames}), more.registry)
    schedule_of(model, more)
    assert not {warning.code for warning in model.warnings} & {"coarse-frames", "coarse-steps"}
