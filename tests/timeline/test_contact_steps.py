"""The record of every step: what each slave node feels, held against frames of each step, and what is kept of it."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.api.contact_steps import NO_SEGMENT
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
COULOMB = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
SHORT = {"time.end": 2e-6, "record.frames": 1_000_000}  # about 130 steps, each of them a frame
STATICS = {"integrator": {"use": "newton", "steps": 5}, "time.end": 1.0, "supports.1.uy.to": -0.02}
VARIANTS: dict[str, dict[str, Any]] = {
    "mortar-p0": {},
    "friction": COULOMB,
    "node-on-segment, friction, swapped": {
        **COULOMB, "contacts.0.algorithm": "node-on-segment", "contacts.0.swap": True,
    },
    "nodes without multipliers": {"bodies.disc.element": "q2", "bodies.block.element": "q2-lagrange"},
    "overlap that is pushed out": {
        "bodies.disc.shift": [0.0, -0.002], "contacts.0.start": {"overlap": "ramp", "duration": 1.8e-6},
    },
    "statics, friction": {**STATICS, **COULOMB},
}  # fmt: skip


@pytest.mark.parametrize("name", some(VARIANTS, ["node-on-segment, friction, swapped", "statics, friction"]))
def test_every_step_is_what_a_frame_of_it_shows(name: str, small_scene: MakeScene, tmp_path: Path) -> None:
    run = simulate(small_scene({**SHORT, **VARIANTS[name]}), tmp_path / "run")
    steps, frames = run.contact["contacts.0"].steps, [frame for frame in run.frames if frame.step]
    assert steps["step"].tolist() == [frame.step for frame in frames]
    assert steps["time"].tolist() == [frame.time for frame in frames]
    columns = ["gap", "pressure", "state", *(["shear"] if "shear" in (steps.dtype.names or ()) else [])]
    for name in columns:
        shown = np.array([getattr(frame.curves["contacts.0"], name) for frame in frames])
        # to the last bit of the precision in which it is stored
        np.testing.assert_array_equal(steps[name], shown.astype(steps[name].dtype), err_msg=name)
    assert steps["state"].any()


def test_segments_face_their_nodes(recorded: Results) -> None:
    """The nearest master segment, or its neighbour: mortars weigh what lies around a node."""
    steps, contact = recorded.contact["contacts.0"].steps, recorded.layout.contacts[0]
    frame, row = recorded.frames[-1], steps[-1]
    at = recorded.nodes + frame.displacement
    middles = at[contact.master_nodes][contact.master_segments].mean(axis=1)
    away = np.hypot(*(at[contact.slave_nodes][:, None] - middles[None]).transpose(2, 0, 1))
    facing = row["segment"] != NO_SEGMENT
    assert facing.sum() >= 5
    assert (np.abs(away.argmin(axis=1)[facing].astype(int) - row["segment"][facing]) <= 1).all()


def test_a_window_and_a_stride_are_kept(small_scene: MakeScene, tmp_path: Path) -> None:
    scene = small_scene({"record.from": 50, "record.to": 100, "record.every": 7})
    run = simulate(scene, tmp_path / "run")
    assert run.contact["contacts.0"].steps["step"].tolist() == list(range(50, 101, 7))
    with pytest.raises(contactlab.errors.RequestError, match="from"):
        small_scene({"record.from": 100, "record.to": 99})


def test_a_record_beyond_its_budget_is_thinned_and_says_so(small_scene: MakeScene, tmp_path: Path) -> None:
    run = simulate(small_scene({"record.budget": 0.01}), tmp_path / "run")
    steps = run.contact["contacts.0"].steps
    assert 0.4 * 0.01e6 < steps.nbytes <= 0.01e6
    kept, thinning = steps["step"], run.thinned["contact"]
    until, stride = thinning.until, thinning.stride
    assert stride > 1
    assert set(range(until + 1, int(run.summary["steps"]) + 1)) <= set(kept.tolist())
    assert set(range(stride, until + 1, stride)) <= set(kept.tolist())
    assert any(f"of the contact record every {stride}th of the steps" in event.text for event in run.events)


def test_a_run_of_a_comparison_keeps_its_budget_where_it_is_taken_up_by_itself(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from contactlab.run.interruption import Interrupted
    from contactlab.studies import plan

    assert plan.make_plan(small_scene(), {"level": [1]}).jobs[0].scene.record.budget == plan.RECORD
    monkeypatch.setattr(plan, "RECORD", 0.02)
    (job,) = plan.make_plan(small_scene(), {"level": [1]}).jobs
    with pytest.raises(Interrupted):
        simulate(job.scene, tmp_path / "run", progress=lambda *_: signal.raise_signal(signal.SIGINT))
    resumed = simulate(tmp_path / "run/scene.toml", tmp_path / "run", resume=True)
    assert resumed.summary["resumed_at_steps"]
    assert 0 < resumed.contact["contacts.0"].steps.nbytes <= 0.02e6
    named = small_scene({"record.budget": 7.0})
    assert plan.make_plan(named, {"level": [1]}).jobs[0].scene.record.budget == 7.0


def test_no_record_without_a_budget_or_contact(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("contactlab.results.contact_sampler.ContactSampler", lambda *_: pytest.fail("was sampled"))
    run = simulate(small_scene({"record.budget": 0, "time.end": 1e-6}), tmp_path / "run")
    assert len(run.contact["contacts.0"].steps) == 0
    assert simulate(small_scene({"time.end": 1e-6, "record.recorders": []}), tmp_path / "none").status == "finished"


def test_damaged_rows_are_not_given_as_numbers(small_scene: MakeScene, tmp_path: Path) -> None:
    import h5py

    simulate(small_scene({"time.end": 2e-6}), tmp_path / "run")
    with h5py.File(tmp_path / "run/results.vtkhdf", "r+") as file:
        table = file["contactlab/contacts/contacts.0/steps"]
        row = table[10]
        row["pressure"][3] += 1.0
        table[10] = row
    with pytest.raises(contactlab.errors.RequestError, match=r"1 of .* rows of contacts/contacts.0/steps are damaged"):
        _ = contactlab.load_results(tmp_path / "run").contact["contacts.0"].steps
    whole = contactlab.load_results(tmp_path / "run", salvage=True).contact["contacts.0"].steps
    assert 11 not in whole["step"]
    assert len(whole) == json.loads((tmp_path / "run/summary.json").read_text())["steps"] - 1
