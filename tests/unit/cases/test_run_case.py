"""Jobs of cases: run, watched, limited, kept as bytes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from contactlab.api import Floats, Job, Memory, StepView, Watch
from contactlab.cases.run_case import run_job, scene_of
from contactlab.jobs.record import from_bytes, to_bytes
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

SMALL = {"bodies.left.mesh.cells": [6, 1], "bodies.right.mesh.cells": [6, 1], "time.step": 1e-3, "time.end": 0.06}
JOB = Job("hit", "two-bars", SMALL, fields=True)


def test_a_record_survives_as_bytes() -> None:
    record = run_job(replace(JOB, watch=({"use": "series", "quantities": ["time", "energy"]},)), scene_of(JOB))
    again = from_bytes(to_bytes(record))
    assert (again.status, again.summary["steps"], again.events) == ("finished", 60, record.events)
    assert np.array_equal(again.displacement, record.displacement)
    assert np.array_equal(again.watched["series"]["energy"], record.watched["series"]["energy"])
    assert again.curve() == record.curve()
    assert {name: cells.tolist() for name, cells in again.cells.items()} == {
        name: cells.tolist() for name, cells in record.cells.items()
    }
    assert to_bytes(again) == to_bytes(record)


def test_work_is_counted_and_ends_a_run_at_the_same_step() -> None:
    records = [run_job(replace(JOB, work=17), scene_of(JOB)) for _ in range(2)]
    assert {record.status for record in records} == {"timed-out"}
    assert {record.summary["steps"] for record in records} == {18}
    assert "17" in records[0].reason


def test_iterations_count_as_work() -> None:
    scene = load_scene("tresca-block").with_({"level": 1, "record.recorders": []})
    whole = simulate(scene).summary
    assert simulate(scene, work=whole["steps"] + whole["iterations"] - 1).status == "timed-out"
    assert simulate(scene, work=whole["steps"] + whole["iterations"]).status == "finished"


def test_what_cannot_begin_is_a_record() -> None:
    wrong = replace(JOB, watch=("no-such-watch",))
    record = run_job(wrong, scene_of(wrong))
    assert record.status == "refused"
    assert "no-such-watch" in record.reason
    body = replace(JOB, watch=({"use": "series", "quantities": ["force.nobody.x"]},))
    assert "nobody" in run_job(body, scene_of(body)).reason


def test_guards_can_be_left_out() -> None:
    """In flight the waves of a bouncing bar move faster than sound: a guard stops it, and it runs on without."""
    held = {"supports": [{"on": "bar", "ux": 0.0}], "time.end": 4.0}
    cells = {"bodies.bar.mesh.cells": [1, 100], "time.step": 1.0 / 300.0}
    bar = Job("bar", "bouncing-bar", held | cells)
    assert run_job(bar, scene_of(bar)).status == "diverged"
    record = run_job(replace(bar, guards=False), scene_of(bar))
    assert (record.status, record.summary["guards"]) == ("finished", False)


@dataclass(frozen=True)
class Prying(Watch):
    """Tries to change what it sees."""

    def begin(self, view: StepView) -> Memory:
        return {"caught": np.zeros(1)}

    def step(self, view: StepView, memory: Memory) -> None:
        for values in (view.field("velocity"), view.position, view.mass):
            with pytest.raises(ValueError, match="read-only"):
                values[...] = 0.0
        memory["caught"] += 1.0


def test_a_watch_cannot_touch_the_run() -> None:
    results = simulate(scene_of(JOB), watch={"prying": Prying()})
    assert results.watched["prying"]["caught"][0] == results.summary["steps"]


@dataclass(frozen=True)
class Steps(Watch):
    """Sums times."""

    def begin(self, view: StepView) -> Memory:
        return {"sum": np.zeros(1)}

    def step(self, view: StepView, memory: Memory) -> None:
        memory["sum"] += view.time

    def end(self, memory: Mapping[str, Floats]) -> Mapping[str, Floats]:
        return {"doubled": 2.0 * memory["sum"]}


@pytest.mark.full
def test_memory_is_in_the_checkpoint(tmp_path: Any) -> None:
    """A run that was stopped by its limit and is taken up with its watch finds what an undisturbed one finds."""
    scene = load_scene("two-bars").with_(SMALL | {"record.recorders": ["vtkhdf"]})
    request: dict[str, Any] = {"watch": {"steps": Steps()}}
    whole = simulate(scene, **request)
    stopped = simulate(scene, out=tmp_path / "run", work=0.5 * whole.summary["steps"], **request)
    assert stopped.status == "timed-out"
    taken_up = simulate(scene, out=tmp_path / "run", resume=True, **request)
    assert taken_up.watched["steps"]["doubled"] == whole.watched["steps"]["doubled"] > 0.0
