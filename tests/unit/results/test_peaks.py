"""Peaks: largest values with their step, whatever the order in which frames and steps come."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.results.peaks import Peaks, peak_force, peak_pressure

LAYOUT: Any = SimpleNamespace(
    steps=("step", "time", "top.fx", "top.fy"), supports=("top",), contacts=(SimpleNamespace(name="contacts.0"),)
)


def frame(step: int, fy: float, pressure: float) -> dict[str, float]:
    own = {"contacts.0.fx": 0.0, "contacts.0.fy": -fy, "contacts.0.max_pressure": pressure}
    return {"step": step, "time": 0.1 * step, "top.fx": 3.0, "top.fy": fy} | own


def record(steps: list[int], pressures: list[float]) -> dict[str, np.ndarray]:
    rows = np.zeros(len(steps), [("step", "i8"), ("time", "f8"), ("pressure", "f4", (2,))])
    rows["step"], rows["time"], rows["pressure"][:, 1] = steps, 0.1 * np.array(steps), pressures
    return {"contacts.0": rows}


def follow(frames_first: bool) -> dict[str, Any]:
    peaks = Peaks(LAYOUT, explicit=False)
    frames = [frame(1, -1.0, 7.0), frame(3, -4.0, 9.0), frame(4, -4.0, 9.0)]
    blocks = [np.array([[1.0, 0.1, 3.0, -1.0], [2.0, 0.2, 3.0, -4.0]]), np.array([[3.0, 0.3, 3.0, -4.0]])]
    for one in frames if frames_first else ():
        peaks.frame(one)
    for block in blocks:
        peaks.steps(block)
    peaks.contact_steps(record([1, 2, 3], [7.0, 20.0, 9.0000001]))
    for one in () if frames_first else frames:
        peaks.frame(one)
    return peaks.as_data(lambda time: time / 0.4)


def test_a_peak_between_frames_is_found_and_the_first_of_equal_ones_counts() -> None:
    data = follow(frames_first=True)
    at_two = {"step": 2, "time": 0.2, "share": 0.5}
    assert data["reactions"]["top"] == {"value": 5.0, "vector": [3.0, -4.0], **at_two}
    assert data["contacts"]["contacts.0"]["pressure"] == {"value": 20.0, **at_two}


def test_a_resumed_run_which_sees_its_frames_first_finds_the_same() -> None:
    assert follow(frames_first=True) == follow(frames_first=False)


def test_single_precision_of_the_record_makes_no_peak_of_its_own() -> None:
    peaks = Peaks(LAYOUT, explicit=True)
    peaks.frame(frame(4, -4.0, 0.1))
    peaks.contact_steps(record([3, 4], [0.0, 0.1]))
    assert peaks.as_data(float)["contacts"]["contacts.0"]["pressure"]["value"] == 0.1


def test_explicit_reactions_are_taken_from_frames() -> None:
    peaks = Peaks(LAYOUT, explicit=True)
    peaks.steps(np.array([[1.0, 0.1, 0.0, -800.0]]))
    peaks.frame(frame(2, -4.0, 1.0))
    assert peaks.as_data(float)["reactions"]["top"]["value"] == 5.0


def test_before_the_only_state_in_equilibrium_nothing_counts() -> None:
    summary = {
        "status": "finished", "steps": 9, "history": {"curve": "the end only"}, "reactions": {"top": [3.0, 4.0]},
        "contacts": {"contacts.0": {"max_pressure": 2.0}},
        "peaks": {"reactions": {"top": {"value": 99.0, "step": 1}},
                  "contacts": {"contacts.0": {"pressure": {"value": 77.0, "step": 1}}}},
    }  # fmt: skip
    force, pressure = peak_force(summary, "top"), peak_pressure(summary, "contacts.0")
    assert force is not None
    assert pressure is not None
    assert (force["value"], force["step"], pressure["value"]) == (5.0, 9, 2.0)
    summary["status"] = "diverged"
    force = peak_force(summary, "top")
    assert force is not None
    assert force["value"] == 99.0


@pytest.mark.full
def test_a_static_run_has_the_peaks_of_its_own_curve(tmp_path: Path) -> None:
    """Pressed down to half of the load and lifted again: the peak is the corner, whose force the curve has."""
    there_and_back = {"ramp": "table", "points": [[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]], "to": -0.02}
    changes = {"integrator": "newton", "integrator.steps": 8, "time.end": 1.0, "time.history": True,
               "supports.1.uy": there_and_back}  # fmt: skip
    results = contactlab.simulate(contactlab.load_scene("disc-on-block").with_(changes), out=tmp_path / "run")
    assert results.status == "finished"
    force = np.hypot(results.history["disc.top.fx"], results.history["disc.top.fy"])
    peak = results.summary["peaks"]["reactions"]["disc.top"]
    assert peak["value"] == pytest.approx(force.max(), rel=4e-16)  # hypot of arrays and of numbers may differ by a bit
    assert peak["time"] == results.history["time"][np.argmax(force)] == 0.5
    assert peak["share"] == pytest.approx(0.5, abs=1e-6)
    assert results.summary["reached"] == pytest.approx({"time": 1.0, "share": 1.0, "of": "load"})
    assert json.loads((tmp_path / "run/summary.json").read_text())["peaks"] == results.summary["peaks"]
