"""Steps that follow their error: a cell on its support swings, u = v0/w sin(w t)."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.api import StepControl
from contactlab.parts.registry import Registry
from contactlab.run.interruption import Interrupted
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene
from contactlab.testing.check_part import check_part
from contactlab.testing.subject import Subject

REGISTRY = Registry(files=[Path(__file__).with_name("adaptive.py")])
FREQUENCY, SPEED = 1.0, 1e-3
END = 5.0
SCENE = """
format = 1
name = "cell"
[time]
end = 5.0
[integrator]
use = "adaptive-leapfrog"
[materials.soft]
use = "linear-elastic"
young = 0.5
poisson = 0.0
density = 1.0
[bodies.cell]
element = "q1"
material = "soft"
mesh = { use = "rectangle", x = [0.0, 1.0], y = [0.0, 1.0], cells = [1, 1] }
velocity = [0.0, 1e-3]
[[supports]]
on = "cell.bottom"
ux = 0.0
uy = 0.0
[record]
frames = 7
"""


@pytest.fixture
def swing(tmp_path: Path) -> Any:
    (tmp_path / "cell.toml").write_text(SCENE)
    scene = load_scene(tmp_path / "cell.toml", registry=REGISTRY)
    return lambda changes=(), **more: simulate(scene.with_(dict(changes)), registry=REGISTRY, **more)


def uses(use: str, allowed: float) -> dict[str, Any]:
    return {"integrator": {"use": use, "allowed": allowed}}


@pytest.mark.parametrize("use", ["adaptive-leapfrog", "adaptive-midpoint"])
def test_steps_follow_the_tolerance_and_meet_frames_and_the_end(swing: Any, use: str) -> None:
    coarse, fine = (swing(uses(use, allowed)) for allowed in (8e-9, 1e-9))
    for results in (coarse, fine):
        assert results.status == "finished", results.reason
        # frames are met by steps that end there: round-off of sums of times
        assert np.allclose(results.history["time"], np.linspace(0.0, END, 8), rtol=1e-12, atol=0.0)
        assert 0.0 < results.history["step_error"][1:].max() <= 1.0
    # an error of third order: an eighth of the tolerance takes twice the steps, but for those cut at the 7 frames
    assert 1.7 < fine.summary["steps"] / coarse.summary["steps"] < 2.2
    if use == "adaptive-midpoint":  # implicit steps are not those that the scene wishes
        assert fine.summary["steps"] < 500


def test_frames_are_met_by_fewer_steps_than_there_are_frames(swing: Any) -> None:
    """Three wished steps, an error that allows the whole at once: each of the 7 frames is the end of a step."""
    results = swing({"integrator": {"use": "adaptive-midpoint", "allowed": 1.0, "steps": 3}})
    assert results.status == "finished", results.reason
    assert np.allclose(results.history["time"], np.linspace(0.0, END, 8), rtol=1e-12, atol=0.0)
    assert results.summary["steps"] == 7


def test_the_error_of_the_end_falls_with_the_tolerance(swing: Any) -> None:
    errors = []
    for allowed in (8e-9, 1e-9):
        results = swing(uses("adaptive-leapfrog", allowed))
        errors.append(abs(results.displacement[-1, 1] - SPEED / FREQUENCY * np.sin(FREQUENCY * END)))
    # second order in the step, which halves
    assert 2.5 < errors[0] / errors[1] < 6.0


def test_steps_stay_below_the_stable_one(swing: Any) -> None:
    loose, plain = swing(uses("adaptive-leapfrog", 1e3)), swing({"integrator": "central-difference"})
    assert loose.status == "finished", loose.reason
    # as long as those without control, but for one cut more at each of the 7 frames
    assert plain.summary["steps"] <= loose.summary["steps"] <= plain.summary["steps"] + 14


def test_rejected_steps_leave_no_trace_but_events(swing: Any) -> None:
    results = swing(uses("adaptive-leapfrog", 1e-12))
    told = [event.text for event in results.events if "rejected: its error is" in event.text]
    assert told, "the first step, of the stable length, is too long"
    assert results.status == "finished", results.reason
    assert results.history["energy.error"].max() < 1e-9


@pytest.mark.full
@pytest.mark.parametrize("use", some(["adaptive-leapfrog", "adaptive-midpoint"], ["adaptive-leapfrog"]))
def test_a_resumed_run_takes_the_same_steps(swing: Any, tmp_path: Path, use: str) -> None:
    changes = uses(use, 1e-9)
    whole = swing(changes)
    with pytest.raises(Interrupted):
        swing(changes, out=tmp_path / "cut", progress=lambda *_: signal.raise_signal(signal.SIGINT))
    resumed = swing(changes, out=tmp_path / "cut", resume=True)
    assert resumed.summary["resumed_at_steps"]
    assert resumed.summary["steps"] == whole.summary["steps"]
    assert np.array_equal(resumed.displacement, whole.displacement)
    assert np.array_equal(resumed.history["step_error"], whole.history["step_error"])


def test_an_integrator_that_asks_for_control_reports_errors(swing: Any) -> None:
    results = swing({"integrator": "silent"})
    assert results.status == "failed"
    assert "Silent: its step gave error None, needed: a number of at least 0" in results.reason


@pytest.mark.parametrize(
    ("error", "before", "ratio"), [(1.0, 1.0, 0.9), (8.0, 1.0, 0.45), (1e9, 1.0, 0.2), (0.0, 1.0, 2.0)]
)
def test_the_controller_has_limits(error: float, before: float, ratio: float) -> None:
    assert StepControl(order=3).ratio(error, before) == pytest.approx(ratio, rel=1e-14)


@pytest.mark.full
def test_an_integrator_with_control_is_not_refused() -> None:
    report = check_part(Subject(REGISTRY, "integrator", "adaptive-leapfrog", {}), until_failure=True)
    assert [(o.check, o.reason) for o in report.outcomes if o.status == "failed"] == []
