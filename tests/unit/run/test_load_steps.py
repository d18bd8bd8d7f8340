"""Steps that iterate: what is not tried again, what is cut, what costs nothing, and what is advised."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.api import Iteration, Step, StepStatus
from contactlab.errors import SimulationFailure
from contactlab.model.build import build
from contactlab.model.memory import model_memory, restore_model
from contactlab.results.results import Results
from contactlab.run.guarded_step import MOST
from contactlab.run.guards import Guards
from contactlab.run.load_steps import CUT, LoadSchedule, repeats
from contactlab.run.prepare import prepare_run
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

FAILED = StepStatus.not_converged


def disc(**changes: Any) -> Scene:
    return load_scene("disc-on-block").with_({"integrator": "newton", "level": 1} | changes)


def floating() -> Scene:
    """A disc pushed down by a load, a hundredth of its size above the block: nothing holds it yet."""
    data = disc().data
    data["supports"] = data["supports"][:1]
    data["loads"] = [{"on": "disc.top", "pressure": {"ramp": "linear", "to": 10.0}, "follower": False}]
    data["bodies"]["disc"]["shift"] = [0.0, 0.01]
    return Scene.from_data(data)


def taken_back(results: Results) -> list[str]:
    return [event.text for event in results.events if "rejected after" in event.text]


def attempt(*residuals: float) -> Step:
    return Step(FAILED, reason="for a test", trace=tuple(Iteration(r, 0.1 * r, 1, 0, 0, 1.0) for r in residuals))


def test_a_body_that_its_load_moves_until_surfaces_meet_is_in_balance_there() -> None:
    """10 MPa on 1.6 mm, whatever the gap was: no spring and no support holds the disc."""
    for gap in (0.01, 5.0):
        results = simulate(floating().with_({"bodies.disc.shift": [0.0, gap]}))
        assert results.status == "finished", results.reason
        assert results.summary["reactions"]["block.bottom"][1] == pytest.approx(16.0, rel=1e-6)


def test_a_body_that_its_load_moves_away_is_told_with_its_motion_at_the_first_failure() -> None:
    """Nothing is there for it to meet."""
    ramp = {"ramp": "linear", "to": 10.0}
    results = simulate(floating().with_({"loads": [{"on": "disc.top", "ty": ramp}]}))
    assert results.status == "not-converged"
    told = taken_back(results)
    assert "no support holds disc against sliding along x or sliding along y or turning" in told[0]
    # the second attempt fails as the first did, in its first iteration, and is the last but for stabilised ones
    assert len(told) == 2
    assert "stabilised: what nothing holds moves away" in told[1]
    assert "with the same iterations as the longer step" in results.reason
    assert '[[supports]] with on = "disc.EDGE_SET" and ux = 0.0, uy = 0.0' in results.reason


@pytest.mark.parametrize(("push", "holds"), some([(0.999, True), (1.25, False)], [(0.999, True)]))
def test_a_load_beyond_what_friction_can_carry_is_told_as_a_limit(push: float, holds: bool) -> None:
    """A layer pressed by 4 MPa and pushed by shares of mu = 0.5 times that, both in proportion: 1.25 never holds.

    Ends slip first, so that the last state in balance carries all that it can to a per cent.
    """
    layer = {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 0.25], "cells": [4, 1]}
    soft = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.25, "density": 1e-9}
    friction = {"use": "coulomb", "mu": 0.5}
    first = {"ramp": "linear", "to": -4.0, "duration": 0.5}
    then = {"ramp": "linear", "to": 2.0 * push, "begin": 0.5, "duration": 0.5}
    scene = Scene.from_data(
        {
            "format": 1,
            "time": {"end": 1.0},
            "integrator": "newton",
            "materials": {"soft": soft},
            "bodies": {"block": {"element": "q1", "material": "soft", "mesh": layer}},
            "rigid": {"floor": {"line": [[4.0, 0.0], [-2.0, 0.0]]}},
            "contacts": [{"slave": "block.bottom", "master": "floor", "algorithm": "mortar-p1", "friction": friction}],
            "loads": [{"on": "block.top", "ty": first}, {"on": "block.top", "tx": then}],
        }
    )
    results = simulate(scene)
    assert results.status == ("finished" if holds else "not-converged")
    if not holds:
        told = re.search(r"friction of contacts\.0 carries ([0-9.]+)% of its limit", results.reason)
        assert told, results.reason
        assert 99.0 < float(told[1]) <= 100.0


@pytest.mark.full
def test_a_limit_load_is_met_and_named_where_the_load_bends_what_it_slides_on() -> None:
    """A block pressed by 1 N and pushed at one end by up to 0.35: mu = 0.3 holds until 0.3/0.35 of it.

    The last state in balance is within 1/500 of a tenth of the load of that: 0.5 % is what a user is promised.
    """
    soft = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.25, "density": 1e-9}
    block = {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [2, 2]}
    floor = {"use": "rectangle", "x": [-1.0, 3.0], "y": [-1.0, 0.0], "cells": [4, 1]}
    sides = {"slave": "block.bottom", "master": "floor.top", "algorithm": "mortar-p1"}
    scene = Scene.from_data(
        {
            "format": 1,
            "integrator": {"use": "newton", "stabilised": False},
            "materials": {"soft": soft},
            "bodies": {
                "block": {"element": "q1", "material": "soft", "mesh": block},
                "floor": {"element": "q1", "material": "soft", "mesh": floor},
            },
            "contacts": [{**sides, "friction": {"use": "coulomb", "mu": 0.3}}],
            "supports": [{"on": "floor.bottom", "ux": 0.0, "uy": 0.0}],
            "loads": [{"on": "block.top", "ty": -1.0}, {"on": "block.left", "tx": {"ramp": "linear", "to": 0.35}}],
        }
    )
    results = simulate(scene)
    assert results.status == "not-converged"
    assert "carries 100.0% of its limit, and nothing else holds block against sliding along x" in results.reason
    assert results.summary["reached"]["share"] == pytest.approx(0.3 / 0.35, rel=0.005)


def test_attempts_are_compared_by_their_residuals() -> None:
    assert repeats(attempt(1.0, 0.5), attempt(1.0, 0.5 * (1.0 + 1e-8)))
    assert not repeats(attempt(1.0, 0.5), attempt(1.0, 0.4))
    assert not repeats(attempt(1.0, 0.5), attempt(1.0, 0.5, 0.5))


def test_a_step_that_a_corner_shortens_is_cut_from_its_own_length() -> None:
    """A tenth of a wished step before a corner: a part of the wished one would be longer than that."""
    uy = {"ramp": "table", "to": -0.01, "points": [[0.0, 0.0], [0.5, 0.1], [1.0, 1.0]]}
    scene = disc(**{"time.end": 1.0, "integrator": {"use": "newton", "steps": 1}, "supports.1.uy": uy})
    schedule = LoadSchedule(build(scene, scene.registry), scene)
    assert schedule.dt == pytest.approx(0.5)
    for number, left in enumerate((0.5, 0.4)):
        schedule.cut(attempt(left))
        assert schedule.dt == pytest.approx(0.5 * CUT ** (number + 1), rel=0.01)


def test_multipliers_come_free_evenly_before_a_corner() -> None:
    """All are free where the loading turns or ends: what is left to free is freed in the steps that are left."""
    uy = {"ramp": "linear", "to": -0.01}
    scene = disc(**{"time.end": 1.0, "integrator": {"use": "newton", "steps": 10}, "supports.1.uy": uy})
    model = build(scene, scene.registry)
    clock, pace = model.state["clock"], model.state["release_pace"]
    clock[0] = 0.96
    schedule = LoadSchedule(model, scene)
    assert pace[0] == 1.0  # nothing was cut
    paces = []
    for k in range(3):
        schedule.cut(attempt(0.1**k))
        paces.append(pace[0])
    # 0.04 are left: in two, four and eight steps, where a wished one would be 2.5 times as long
    assert paces == pytest.approx([1 / 2, 1 / 4, 1 / 8], rel=1e-6)
    freedom = 0.0
    while clock[0] < 1.0 - 1e-9:
        before, freedom = freedom, min(1.0, freedom + pace[0])
        assert freedom - before <= 0.5 + 1e-9
        clock[0] += schedule.dt
        schedule.every_step[0](attempt(0.1)._replace(iterations=9), schedule.dt)
    assert freedom == pytest.approx(1.0)


@pytest.mark.parametrize("factor", [0.8, 0.95])
def test_more_iterations_are_made_while_residuals_fall(factor: float) -> None:
    from contactlab.implicit.iteration import FALL, MORE, NewtonIteration

    iteration = NewtonIteration.__new__(NewtonIteration)
    iteration.most = 10
    trace = [Iteration(factor**k, 0.0, 0, 0, 0, 1.0) for k in range(10)]
    assert iteration._goes_on(trace[:9])
    assert iteration._goes_on(trace) is (factor < FALL)
    assert not iteration._goes_on([*trace[:-1], trace[-1]._replace(force=1.0)])
    assert not iteration._goes_on([Iteration(0.8**k, 0.0, 0, 0, 0, 1.0) for k in range(10 * MORE)])


def test_nothing_costs_no_iteration() -> None:
    """What is neither moved nor loaded is in balance as it is; so is a hold."""
    results = simulate(disc(**{"supports.1.uy": 0.0}))
    assert results.status == "finished"
    assert results.summary["iterations"] == 0
    held = {"ramp": "linear", "to": -0.01, "duration": 0.5}
    results = simulate(disc(**{"time.end": 1.0, "supports.1.uy": held}))
    assert max(row.time for row in results.iterations) < 0.5
    assert results.history["time"][-1] == 1.0


@pytest.mark.full
def test_a_step_that_a_guard_objects_to_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps over 0.03 end in positions that a guard stops the run for; shorter ones do not."""
    look, begun = Guards.check_positions, [0.0]

    def strict(guards: Guards) -> None:
        look(guards)
        time = guards.model.state.time
        if time - begun[0] > 0.03:
            raise SimulationFailure("diverged", "too far at once")
        begun[0] = time

    scene = disc(**{"integrator": {"use": "newton", "steps": 10}, "supports.1.uy": {"ramp": "linear", "to": -0.01}})
    expected = simulate(scene)
    monkeypatch.setattr(Guards, "check_positions", strict)
    results = simulate(scene)
    assert results.status == "finished"
    assert "too far at once" in taken_back(results)[0]
    assert results.summary["steps"] >= 40
    # without friction and history the way does not matter
    reactions = [np.array(run.summary["reactions"]["block.bottom"]) for run in (results, expected)]
    assert reactions[0] == pytest.approx(reactions[1], rel=1e-6, abs=1e-6 * np.abs(reactions[1]).max())


def test_a_guard_that_no_cut_contents_has_the_last_word(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(guards: Guards) -> None:
        raise SimulationFailure("diverged", "never content")

    monkeypatch.setattr(Guards, "check_positions", never)
    results = simulate(disc(**{"supports.1.uy.to": -0.01}))
    assert (results.status, results.reason) == ("diverged", "never content")
    assert len(taken_back(results)) == MOST


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({}, "more integrator.steps"),
        ({"time.step": 0.1}, "a smaller time.step"),
        ({"integrator": "central-difference"}, "a smaller time.fraction"),
        ({"integrator": "central-difference", "time.step": 1e-9}, "a smaller time.step"),
        ({"integrator": "implicit-dynamics", "time.end": 1e-3}, "more integrator.steps"),
    ],
)
def test_advice_names_a_key_of_this_run(changes: dict[str, Any], key: str) -> None:
    scene = disc(**changes)
    model = build(scene, scene.registry)
    run = prepare_run(model, scene, scene.registry, None, resume=False)
    model.state["displacement"][3] = np.nan
    with pytest.raises(SimulationFailure, match=key) as told:
        run.guards.check()
    for other in ("integrator.steps", "time.step", "time.fraction"):
        assert (other in told.value.reason) is (other in key)


def test_a_run_that_does_not_get_on_is_given_up_after_some_very_short_steps() -> None:
    """Each step of 1/1024 converges, and each attempt twice as long fails: a node over a vertex did so for ever."""
    scene = disc(**{"integrator": {"use": "newton", "steps": 10, "stabilised": False}})
    schedule = LoadSchedule(build(scene, scene.registry), scene)
    clock, accepted, left = schedule.state["clock"], 0, 1.0

    def go_on() -> None:
        nonlocal accepted, left
        while schedule.part > schedule.wished / 1000.0:
            left *= 0.99  # no attempt repeats the one before
            schedule.cut(attempt(1.0, left))
        clock[0] += schedule.dt
        schedule.every_step[0](attempt(0.1)._replace(iterations=2), schedule.dt)
        accepted += 1

    for _ in range(20):
        go_on()
    with pytest.raises(SimulationFailure, match="after 20 steps below 1/256 of the load increment"):
        go_on()
    assert accepted == 20


def test_what_comes_free_by_and_by_is_saved_and_restored() -> None:
    """A step that was cut frees multipliers at the pace of its length; the wished one, and the last, at once."""
    scene = disc(**{"time.end": 1.0, "integrator": {"use": "newton", "steps": 10}})
    schedule = LoadSchedule(build(scene, scene.registry), scene)
    pace = schedule.state["release_pace"]
    schedule.part = schedule.wished
    schedule._length()
    assert pace[0] == 1.0
    schedule.cut(attempt(0.5))
    assert pace[0] == pytest.approx(CUT)
    release = schedule.state["release"]
    release[:], pace[1] = np.linspace(0.0, 1.0, len(release)), CUT
    saved = {name: values.copy() for name, values in model_memory(schedule.model).items()}
    expected, release[:], pace[:] = release.copy(), 0.5, 1.0
    restore_model(schedule.model, saved)
    np.testing.assert_array_equal(pace, [CUT, CUT])
    np.testing.assert_array_equal(release, expected)
    schedule.state["clock"][0] = 1.0 - 1e-3
    schedule._length()
    assert pace[0] == 1.0
