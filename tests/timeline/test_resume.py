"""A run that was stopped and taken up again is the run that was never stopped, to the last bit."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from stops import stopped_at
from tiers import some

import contactlab
from contactlab.errors import RequestError
from contactlab.results.results import Results
from contactlab.run.interruption import Interrupted
from contactlab.run.run import Run
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
Assert = Callable[[Any, Any], None]

COULOMB = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
PLASTIC = {f"materials.soft.{key}": value for key, value in {
    "use": "power-law", "strength": 348.0, "prestrain": 0.02, "exponent": 0.03,
}.items()}  # fmt: skip
RATE = {"materials.soft.use": "hypoelastic"}
CONSISTENT = {"use": "central-difference", "forces": "consistent"}
STATICS = {"integrator": {"use": "newton", "steps": 8}, "time.end": 1.0, "supports.1.uy.to": -0.02}
IMPLICIT = {"integrator": {"use": "implicit-dynamics", "steps": 12}, "supports.1.uy.to": -0.02}
THROWN = {
    "supports": [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}], "time.end": 1e-6,
    "bodies.disc.velocity": [0.0, -4e4], "bodies.disc.shift": [0.0, 0.01],
}  # fmt: skip
VARIANTS: dict[str, dict[str, Any]] = {
    "mortar-p0": {},
    "mortar-p1": {"contacts.0.algorithm": "mortar-p1"},
    "node-on-segment": {"contacts.0.algorithm": "node-on-segment"},
    "swapped": {"contacts.0.swap": True},
    "coulomb": COULOMB,
    "coulomb, node-on-segment": {**COULOMB, "contacts.0.algorithm": "node-on-segment"},
    "tresca": {"contacts.0.friction": {"use": "tresca", "stress": 200.0}},
    "linear-elastic": {"materials.soft.use": "linear-elastic"},
    "hypoelastic": {**RATE, **COULOMB},
    "power-law": {**PLASTIC, **COULOMB},
    "q1-fbar": {"bodies.block.element": "q1-fbar"},
    "q1-reduced": {"bodies.block.element": "q1-reduced"},
    "q2": {"bodies.disc.element": "q2", "bodies.block.element": "q2-lagrange"},
    "settling": {"time.end": "auto", "time.ramp": 3e-6, "record.frames": 7},
    "fixed step": {"time.step": 8e-9},
    "parts of the contact work": {"record.contact_work": True},
    "parts of the contact work, consistent": {"record.contact_work": True, "integrator": CONSISTENT},
    "newton": STATICS,
    "newton, friction": {**STATICS, **COULOMB},
    "newton, penalty": {**STATICS, "contacts.0.enforcement": "penalty"},
    "newton, augmented-lagrangian, friction": {**STATICS, **COULOMB, "contacts.0.enforcement": "augmented-lagrangian"},
    "implicit-dynamics, friction": {**IMPLICIT, **COULOMB},
    "implicit-dynamics, plasticity": {**IMPLICIT, **PLASTIC},
    "implicit-dynamics, hypoelastic, settling": {**IMPLICIT, **RATE, "time.end": "auto", "time.ramp": 3e-6},
    "newton, plasticity": {**STATICS, **PLASTIC},
}

ALWAYS = {"coulomb, node-on-segment", "power-law", "newton, friction"}


def run_with_stops(scene: Any, folder: Path, stops: list[int]) -> Results:
    """Run, stop after each of these steps, take up again."""
    for number, step in enumerate(stops):
        with stopped_at(step), pytest.raises(Interrupted) as stop:
            simulate(scene, folder, resume=number > 0)
        assert stop.value.results.status == "interrupted"
        assert stop.value.results.summary["steps"] == step
    return simulate(scene, folder, resume=True)


@pytest.mark.parametrize("name", some(VARIANTS, ALWAYS))
def test_resumed_run_is_bit_identical(
    name: str, small_scene: MakeScene, tmp_path: Path, assert_same_run: Assert, assert_same_files: Assert
) -> None:
    scene = small_scene(VARIANTS[name])  # 250 steps where they are explicit
    whole = simulate(scene, tmp_path / "whole")
    steps = whole.summary["steps"]
    # early, in mid-run, and at the last step
    stops = [min(17, steps // 4), steps // 2 + 3, steps]
    resumed = run_with_stops(scene, tmp_path / "stopped", stops)
    assert resumed.summary["resumed_at_steps"] == stops
    assert_same_run(whole, resumed)
    assert_same_files(tmp_path / "whole", tmp_path / "stopped")


@pytest.mark.full
def test_an_impact_is_taken_up_within_its_short_steps(
    small_scene: MakeScene, tmp_path: Path, assert_same_run: Assert, assert_same_files: Assert
) -> None:
    """In the first step, as the disc meets the block, in the contact, and before the end."""
    scene = small_scene({"integrator": {"use": "implicit-dynamics", "steps": 10}, **THROWN})
    whole = simulate(scene, tmp_path / "whole")
    steps = whole.summary["steps"]
    assert steps > 20
    stops = [1, 4, steps // 2, steps - 2]
    resumed = run_with_stops(scene, tmp_path / "stopped", stops)
    assert_same_run(whole, resumed)
    assert_same_files(tmp_path / "whole", tmp_path / "stopped")


@pytest.mark.full
def test_a_nested_run_is_taken_up_between_its_corners(
    small_scene: MakeScene, tmp_path: Path, assert_same_run: Assert, assert_same_files: Assert
) -> None:
    """Coarser levels are solved again where a leg of the loading is left, and say nothing twice."""
    uy = {"ramp": "table", "to": -0.02, "points": [[0.0, 0.0], [0.5, 1.0], [1.0, 0.5]]}
    scene = small_scene({"integrator": "newton", "time.end": 1.0, "level": 2, "supports.1.uy": uy})
    whole = simulate(scene, tmp_path / "whole")
    assert whole.summary["steps"] == 2
    resumed = run_with_stops(scene, tmp_path / "stopped", [1, 2])
    assert_same_run(whole, resumed)
    assert_same_files(tmp_path / "whole", tmp_path / "stopped")


@pytest.mark.full
def test_warnings_outlive_the_stop_and_are_told_once(small_scene: MakeScene, tmp_path: Path) -> None:
    scene = small_scene({"materials.soft.yield_stress": 1.0})
    whole = simulate(scene, tmp_path / "whole")
    resumed = run_with_stops(scene, tmp_path / "stopped", [100, whole.summary["steps"]])
    by_code = {warning.code: warning for warning in resumed.warnings}
    # on so coarse a mesh contact makes some per cent of all energy as well
    assert sorted(by_code) == ["contact-energy", "plasticity"]
    warning = by_code["plasticity"]
    assert warning.value > warning.limit == 1.0
    assert resumed.warnings == whole.warnings == contactlab.load_results(tmp_path / "stopped").warnings
    for warning in resumed.warnings:
        key = {"plasticity": "von Mises", "contact-energy": "contact has made"}[warning.code]
        assert len([event for event in resumed.events if key in event.text]) == 1


@pytest.mark.full
def test_a_run_killed_after_its_last_step_is_judged(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing of the end was saved but the state: conditions made again agree to what the last iteration moved."""
    scene = small_scene({**STATICS, "supports.1.uy.to": -0.06})  # so deep that facets matter
    whole = simulate(scene, tmp_path / "whole")
    with monkeypatch.context() as patch:
        patch.setattr(Run, "conclude", lambda _: None)
        with stopped_at(whole.summary["steps"]), pytest.raises(Interrupted):
            simulate(scene, tmp_path / "killed")
    resumed = simulate(scene, tmp_path / "killed", resume=True).warnings
    assert whole.warnings
    assert [w.code for w in resumed] == [w.code for w in whole.warnings]
    # distances that are kept are a hundredth of those that the last iteration moved by up to 1e-8
    assert [w.value for w in resumed] == pytest.approx([w.value for w in whole.warnings], rel=1e-6)
    assert [w.limit for w in resumed] == pytest.approx([w.limit for w in whole.warnings], rel=1e-2)


def test_stored_frames_do_not_change_the_run(small_scene: MakeScene) -> None:
    """Looking at contacts makes and restores near lists; the run must not notice."""
    few = simulate(small_scene({**COULOMB, "record.frames": 1}))
    many = simulate(small_scene({**COULOMB, "record.frames": 60}))
    assert (few.displacement == many.displacement).all()
    assert few.contact["contacts.0"].last == many.contact["contacts.0"].last


def test_interrupted_run_says_so_everywhere(small_scene: MakeScene, tmp_path: Path) -> None:
    with stopped_at(40), pytest.raises(Interrupted) as stop:
        simulate(small_scene(), tmp_path)
    for summary in (stop.value.results.summary, json.loads((tmp_path / "summary.json").read_text())):
        assert summary["status"] == "interrupted"
        assert "SIGINT after step 40; its state is saved" in summary["reason"]
    assert contactlab.load_results(tmp_path) == stop.value.results


def test_interrupt_without_folder_still_gives_results(small_scene: MakeScene) -> None:
    with stopped_at(40), pytest.raises(KeyboardInterrupt) as stop:
        simulate(small_scene())
    assert stop.value.results.summary["steps"] == 40
    assert "nothing was written" in stop.value.results.reason


def test_signal_handlers_are_given_back(small_scene: MakeScene) -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    simulate(small_scene({"time.end": 1e-7}))
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_finished_run_is_read_and_not_repeated(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = simulate(small_scene(), tmp_path)
    monkeypatch.setattr("contactlab.run.simulation.build", lambda *_: pytest.fail("the run was repeated"))
    assert simulate(small_scene(), tmp_path, resume=True) == whole


def test_resume_begins_where_nothing_was_begun(small_scene: MakeScene, tmp_path: Path) -> None:
    assert simulate(small_scene(), tmp_path / "new", resume=True).status == "finished"


def test_another_scene_is_refused_by_key(small_scene: MakeScene, tmp_path: Path) -> None:
    with stopped_at(40), pytest.raises(Interrupted):
        simulate(small_scene(), tmp_path)
    with pytest.raises(RequestError) as error:
        simulate(small_scene({"materials.soft.young": 8000.0}), tmp_path, resume=True)
    assert "materials.soft.young was 7000.0, now 8000.0" in str(error.value)
    # and the run itself is still there to be taken up
    assert simulate(small_scene(), tmp_path, resume=True).status == "finished"


def test_run_without_a_saved_state_cannot_be_taken_up(small_scene: MakeScene, tmp_path: Path) -> None:
    simulate(small_scene({"record.recorders": [], "time.end": 1e-7}), tmp_path)
    with pytest.raises(RequestError, match="no run that could be resumed"):
        simulate(small_scene({"record.recorders": [], "time.end": 1e-7}), tmp_path, resume=True)
