"""Folders of `integrator = "auto"`: the run that was taken, attempts before it, and what a stopped one goes on with."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stops import stopped_at
from tiers import some

import contactlab
from contactlab.errors import RequestError
from contactlab.run.interruption import Interrupted
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

HARD = {"use": "newton", "iterations": 1, "stabilised": False}
"""No step converges in one iteration."""
HARDER = {**HARD, "tolerance": 1e-9}
DYNAMICS = {"use": "implicit-dynamics", "steps": 20}
BLOCK: dict[str, Any] = {
    "name": "block", "integrator": {"use": "auto", "order": [HARD, DYNAMICS]},
    "materials": {"m": {"use": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": 1e-9}},
    "bodies": {"block": {
        "element": "q1", "material": "m",
        "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [2, 2]},
    }},
    "supports": [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
    "loads": [{"on": "block.top", "ty": {"ramp": "linear", "to": -1.0}}],
    "time": {"end": 1e-5},
    "record": {"recorders": ["vtkhdf"], "frames": 5, "last": 0},
}  # fmt: skip
FILES = {"contact.csv", "history.csv", "iterations.csv", "results.vtkhdf", "scene.toml", "summary.json"}

Assert = Callable[[Any, Any], None]


def block(*order: Any) -> Scene:
    return Scene.from_data(BLOCK).with_({"integrator": {"use": "auto", "order": list(order)}} if order else {})


def chosen(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "summary.json").read_text())["resolved"]["integrator"]
    return found


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_the_folder_is_that_of_the_run_that_was_taken_with_attempts_below(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    results = simulate(block(), tmp_path)
    assert results.status == "finished"
    assert names(tmp_path) == {*FILES, "attempts", "notes.txt"}
    assert names(tmp_path / "attempts") == {"1-newton"}
    assert names(tmp_path / "attempts" / "1-newton") == FILES
    found = chosen(tmp_path)
    assert found["use"] == "implicit-dynamics"
    assert [one["use"] for one in found["order"]] == ["newton", "implicit-dynamics"]
    (attempt,) = found["tried"]
    assert attempt["folder"] == "attempts/1-newton"
    before = contactlab.load_results(tmp_path / attempt["folder"])
    assert (before.status, before.reason) == (attempt["status"], attempt["reason"])
    assert before.summary["cost"]["run_cpu_s"] == attempt["cpu_s"] < results.summary["cost"]["run_cpu_s"]
    # the scene of the folder is what was run: the same again, without an attempt
    scene = load_scene(tmp_path / "scene.toml")
    assert scene.integrator["use"] == "implicit-dynamics"
    np.testing.assert_array_equal(simulate(scene).displacement, results.displacement)


@pytest.mark.full
@pytest.mark.parametrize("scene_of_the_folder", some([False, True], [True]))
def test_a_run_stopped_in_its_second_attempt_goes_on_there(
    scene_of_the_folder: bool, tmp_path: Path, assert_same_run: Assert
) -> None:
    whole = simulate(block(), tmp_path / "whole")
    with stopped_at(10), pytest.raises(Interrupted):
        simulate(block(), tmp_path / "stopped")
    assert chosen(tmp_path / "stopped")["use"] == "implicit-dynamics"
    stamp = (tmp_path / "stopped" / "attempts" / "1-newton" / "summary.json").stat().st_mtime_ns
    scene = load_scene(tmp_path / "stopped" / "scene.toml") if scene_of_the_folder else block()
    results = simulate(scene, tmp_path / "stopped", resume=True)
    assert results.summary["resumed_at_steps"] == [10]
    np.testing.assert_array_equal(results.displacement, whole.displacement)
    assert [event.text for event in results.events][1:] == [event.text for event in whole.events][1:]
    assert (tmp_path / "stopped" / "attempts" / "1-newton" / "summary.json").stat().st_mtime_ns == stamp
    assert [one["reason"] for one in chosen(tmp_path / "stopped")["tried"]] == [
        one["reason"] for one in chosen(tmp_path / "whole")["tried"]
    ]
    # a run that is over is read back
    again = simulate(block(), tmp_path / "stopped", resume=True)
    assert again.summary == results.summary


@pytest.mark.full
def test_a_run_stopped_in_its_first_attempt_goes_on_to_the_second(tmp_path: Path) -> None:
    """Also with the scene of its folder, which names the first integrator alone."""
    first = {**DYNAMICS, "steps": 40, "iterations": 2, "tolerance": 1e-10}
    order = [{**first, "impacts": False}, DYNAMICS]
    with stopped_at(5), pytest.raises(Interrupted):
        simulate(block(*order), tmp_path)
    assert chosen(tmp_path)["tried"] == []
    scene = load_scene(tmp_path / "scene.toml")
    results = simulate(scene, tmp_path, resume=True)
    assert results.status == "finished"
    assert chosen(tmp_path)["order"] == [dict(spec) for spec in block(*order).integrator["order"]]


MOVED = [*(("dynamics", count) for count in range(6)), *(("harder", count) for count in range(11, 18))]


@pytest.mark.full
@pytest.mark.parametrize(("second", "killed_after"), some(MOVED, [("dynamics", 4), ("harder", 15)]))
def test_results_that_were_half_moved_when_the_process_was_killed_are_moved_on(
    second: str, killed_after: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Six files go to the place of an attempt; if both come short, six more do, and six come back."""
    order = (HARD, DYNAMICS if second == "dynamics" else HARDER)
    rename, left = Path.rename, iter(range(killed_after))

    def dies(self: Path, target: Path) -> Path:
        if "attempts" in (*self.parts, *target.parts) and next(left, None) is None:
            raise KeyboardInterrupt
        return rename(self, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "rename", dies)
        with pytest.raises(KeyboardInterrupt):
            simulate(block(*order), tmp_path)
    results = simulate(block(*order), tmp_path, resume=True)
    assert names(tmp_path) == {*FILES, "attempts"}
    (attempt,) = chosen(tmp_path)["tried"]
    assert names(tmp_path / "attempts") == {attempt["folder"].partition("/")[2]}
    assert names(tmp_path / attempt["folder"]) == FILES
    if order[1] == DYNAMICS:
        assert (results.status, attempt["use"]) == ("finished", "newton")
    else:
        assert (results.status, attempt["folder"]) == ("not-converged", "attempts/2-newton")


@pytest.mark.full
def test_if_all_come_short_the_furthest_results_are_kept_with_every_reason(tmp_path: Path) -> None:
    # friction holds half of the pull; the other two integrators stop at their first step
    far = {"use": "newton", "stabilised": False, "steps": 2}
    hard = {**DYNAMICS, "iterations": 1, "tolerance": 1e-13}
    scene = block(HARD, far, hard).with_({
        "bodies.block.mesh.cells": [1, 1], "supports": [], "rigid": {"floor": {"line": [[5.0, 0.0], [-5.0, 0.0]]}},
        "contacts": [{
            "slave": "block.bottom", "master": "floor", "algorithm": "mortar-p0",
            "friction": {"use": "coulomb", "mu": 0.2},
        }],
        "loads": [{"on": "block.top", "ty": {"ramp": "constant", "to": -1.0}},
                  {"on": "block.left", "tx": {"ramp": "linear", "to": 0.4}}],
    })  # fmt: skip
    results = simulate(scene, tmp_path)
    assert results.status == "not-converged"
    found = chosen(tmp_path)
    assert found["use"] == "newton"
    assert [one["folder"] for one in found["tried"]] == ["attempts/1-newton", "attempts/3-implicit-dynamics"]
    assert names(tmp_path / "attempts") == {"1-newton", "3-implicit-dynamics"}
    assert names(tmp_path) == {*FILES, "attempts"}
    reached = results.summary["reached"]["share"]
    assert 0.45 < reached <= 0.5
    assert all(reached > one["reached"]["share"] for one in found["tried"])
    assert results.reason.startswith("newton, which got furthest: stopped at ")
    assert "; the others: newton not-converged: " in results.reason
    assert "implicit-dynamics not-converged: " in results.reason
    assert load_scene(tmp_path / "scene.toml").integrator["iterations"] == 25
    stored = contactlab.load_results(tmp_path)
    assert stored.summary == results.summary == json.loads((tmp_path / "summary.json").read_text())
    np.testing.assert_array_equal(stored.displacement, results.displacement)
    cost = results.summary["cost"]
    assert cost["failed_attempts_s"] == sum(one["cpu_s"] for one in found["tried"]) < cost["run_cpu_s"]
    # without files the same, and with --resume nothing is run again
    assert simulate(scene).reason.partition(": ")[0] == results.reason.partition(": ")[0]
    assert simulate(scene, tmp_path, resume=True).summary == results.summary


@pytest.mark.full
def test_a_last_integrator_that_got_furthest_is_told_once(tmp_path: Path) -> None:
    short = {**DYNAMICS, "steps": 2, "iterations": 1, "tolerance": 1e-13}
    results = simulate(block(short, HARD), tmp_path)
    last = simulate(block("newton", short).with_({"bodies.block.velocity": [1.0, 0.0]}), tmp_path / "last")
    for folder, found in ((tmp_path, results), (tmp_path / "last", last)):
        assert found.reason.count("which got furthest") == 1
        again = simulate(load_scene(folder / "scene.toml"), folder, resume=True)
        assert again.summary == found.summary


@pytest.mark.full
def test_a_plain_run_goes_on_as_the_first_of_an_order(tmp_path: Path) -> None:
    plain = block().with_({"integrator": HARD})
    assert simulate(plain, tmp_path).status == "not-converged"
    results = simulate(block(), tmp_path, resume=True)
    assert results.status == "finished"
    assert [one["folder"] for one in chosen(tmp_path)["tried"]] == ["attempts/1-newton"]


def test_an_integrator_that_refuses_the_scene_is_left_out_and_the_first_error_is_that_of_all(tmp_path: Path) -> None:
    thrown = block("newton", DYNAMICS).with_({"bodies.block.velocity": [1.0, 0.0]})
    results = simulate(thrown, tmp_path / "thrown")
    assert names(tmp_path / "thrown") == FILES
    (attempt,) = chosen(tmp_path / "thrown")["tried"]
    assert (attempt["status"], attempt["folder"], attempt["steps"]) == ("refused", "", 0)
    assert "nothing moves by itself in statics" in attempt["reason"]
    assert results.summary["resolved"]["integrator"]["use"] == "implicit-dynamics"
    with pytest.raises(RequestError, match="nothing moves by itself"):
        simulate(block("newton", HARD).with_({"bodies.block.velocity": [1.0, 0.0]}), tmp_path / "none")


def test_a_folder_of_another_scene_is_refused(tmp_path: Path) -> None:
    simulate(block(DYNAMICS), tmp_path)
    with pytest.raises(RequestError, match="another scene"):
        simulate(block(DYNAMICS).with_({"loads.0.ty.to": -2.0}), tmp_path, resume=True)
    with pytest.raises(RequestError, match="results already"):
        simulate(block(), tmp_path)


def test_the_limit_of_work_is_that_of_all_attempts() -> None:
    free = simulate(block())
    (attempt,) = free.summary["resolved"]["integrator"]["tried"]
    spent = attempt["steps"] + attempt["iterations"]
    assert spent > 5
    stopped = simulate(block(), work=spent + 5)
    assert stopped.status == "timed-out"
    assert stopped.summary["steps"] + stopped.summary["iterations"] <= 5 + 10
