"""The steps before a failure and before a first warning are stored whole, as if each had been a frame."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactlab.results.load import load_results
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
LONG = {"time.end": 8e-6}  # fails after more steps than a small run has
FRICTION = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
STATICS = {"integrator": {"use": "newton", "steps": 6, "iterations": 2}, "time.end": 1.0, "supports.1.uy.to": -0.3}


def failing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Surfaces may lie in each other by a hundredth of what they do in this scene: it fails at a look at the model."""
    monkeypatch.setattr("contactlab.run.contact_guard.TOO_DEEP", 5e-3)


def assert_same_frames(run: Results, frames: Any) -> None:
    """Are these frames those of a run with a frame in every step?"""
    every = {frame.step: frame for frame in run.frames}
    for frame in frames:
        other = every[frame.step]
        assert frame.time == other.time
        np.testing.assert_array_equal(frame.displacement, other.displacement)
        np.testing.assert_array_equal(frame.velocity, other.velocity)
        assert frame.curves == other.curves
        assert frame.scalars == other.scalars
        for body, fields in frame.cells.items():
            for name, values in fields.items():
                np.testing.assert_array_equal(values, other.cells[body][name], err_msg=name)


@pytest.mark.full
def test_steps_before_a_failure_are_those_of_a_run_with_a_frame_in_each(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch)
    run = simulate(small_scene({**FRICTION, **LONG, "record.last": 80}), tmp_path / "run")
    assert run.status == "diverged"
    end, frames = run.summary["steps"], run.last_steps["failure"]
    assert [frame.step for frame in frames] == list(range(end - 79, end + 1))
    slow = simulate(small_scene({**FRICTION, **LONG, "record.frames": 1_000_000}), tmp_path / "slow")
    assert end - 70 < slow.summary["steps"] <= end, "a frame is a look at the model"
    assert slow.last_steps == {}
    assert not (tmp_path / "slow" / "last-steps").exists()
    assert_same_frames(slow, [frame for frame in frames if frame.step < slow.summary["steps"]])
    assert load_results(tmp_path / "run" / "last-steps" / "failure").frames[0].step == end - 79


def test_steps_before_the_first_warning_of_a_guard(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("contactlab.run.energy_guard.MADE", -1.0)  # all that contact makes is too much
    run = simulate(small_scene({"record.last": 30}), tmp_path / "run")
    assert (run.status, "contact-energy" in {warning.code for warning in run.warnings}) == ("finished", True)
    first = next(event for event in run.events if "contact has made" in event.text)
    steps = [frame.step for frame in run.last_steps["warning"]]
    assert len(steps) == min(30, steps[-1])
    assert steps[-1] <= first.step
    assert "failure" not in run.last_steps


@pytest.mark.full
def test_steps_before_a_warning_that_is_judged_at_the_end(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only where the scene asks for it; they are those of a run with a frame in each."""
    monkeypatch.setattr("contactlab.run.energy_guard.MADE", 1e9)  # no guard warns
    changes = {"record.last": 30, "contacts.0.algorithm": "node-on-segment"}
    plain = simulate(small_scene(changes), tmp_path / "plain")
    assert plain.warnings
    assert not plain.last_steps, "none of its warnings is one of a guard"
    run = simulate(small_scene({**changes, "record.warnings": "all"}), tmp_path / "run")
    frames, told = run.last_steps["warning"], [e.step for e in run.events if e.level == "warning" and e.step]
    assert len(frames) == 30
    assert frames[-1].step == told[0]
    slow = simulate(small_scene({**changes, "record.frames": 1_000_000}), tmp_path / "slow")
    assert_same_frames(slow, frames)


def test_a_part_that_remembers_is_told_of(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Steps that come out otherwise when they are repeated are no evidence."""
    failing(monkeypatch)
    monkeypatch.setattr("contactlab.run.kept_states.KeptState.is_that_of", lambda state, model: False)
    run = simulate(small_scene({**LONG, "record.last": 200}), tmp_path / "run")
    assert run.status == "diverged"
    assert run.last_steps == {}
    assert any("differ from the original steps" in event.text for event in run.events)


@pytest.mark.full
def test_implicit_runs_keep_each_of_their_steps(small_scene: MakeScene, tmp_path: Path) -> None:
    """Two iterations are too few once contact has spread."""
    run = simulate(small_scene({**STATICS, "record.frames": 2, "record.last": 50}), tmp_path / "run")
    assert run.status == "not-converged"
    end = run.summary["steps"]
    assert [frame.step for frame in run.last_steps["failure"]] == list(range(max(1, end - 49), end + 1))
