"""Where the error of a run sits: knobs of scenes, and parts from changes that are known."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from inline import runs_inline

import contactlab
from contactlab.accuracy import error_budget as budgets
from contactlab.accuracy.error_budget import ErrorBudget, Knob, Share, knobs_of
from contactlab.accuracy.judged import Judge, forces_of
from contactlab.api import ContactCurve, Record
from contactlab.cli import main
from contactlab.commands import error_budget as showing
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene, load_scene

RESOLVED = {"resolved": {"ramp": 2e-6, "hold": 1e-5, "damping": 4e6, "relaxation": 0.0}, "steps": 7}


@pytest.fixture(autouse=True, scope="module")
def inline() -> Iterator[None]:
    with runs_inline():
        yield


def scene(**changes: Any) -> Scene:
    return load_scene("disc-on-block").with_({key.replace("__", "."): value for key, value in changes.items()})


def names(one: Scene, summary: dict[str, Any] = RESOLVED) -> list[str]:
    return [knob.name for knob in knobs_of(one, summary, default_registry())]


OTHERS = ["element q1-fbar", "element q2", "slave of contacts.0"]


def test_knobs_are_those_that_the_scene_has() -> None:
    assert names(scene()) == ["mesh", "time step", "ramp", "hold", *OTHERS]
    assert names(scene(time__end=1e-5)) == ["mesh", "time step", *OTHERS]
    assert names(scene(time__end=1e-5, time__damping=1.0)) == ["mesh", "time step", "damping", *OTHERS]
    assert names(scene(integrator="newton")) == ["mesh", "tolerance", *OTHERS]
    assert names(scene(integrator="newton"), RESOLVED | {"history": {"matters": True}})[1] == "load steps"
    assert names(scene(integrator="implicit-dynamics"))[1] == "load steps"
    tool = names(scene(integrator="newton", contacts=[{
        "name": "tool", "slave": "disc.arc", "master": "block.top", "algorithm": "mortar-p0", "enforcement": "penalty",
    }]))  # fmt: skip
    assert "stiffness of tool" in tool
    assert tool[-1] == "slave of tool"
    assert "finite strain of soft" in names(scene(materials__soft__use="linear-elastic"))
    # a rigid surface is no slave, and there is nothing beyond a quadratic element
    assert names(load_scene("tresca-block").with_({"bodies.block.element": "q2"}))[-1] == "finite strain of metal"


def test_a_knob_turns_one_thing_alone() -> None:
    """What the run found for itself stands beside it: a ramp that is given would change the damping, too."""
    knobs = {knob.name: knob.settings for knob in knobs_of(scene(), RESOLVED, default_registry())}
    found = {"time.ramp": 2e-6, "time.damping": 4e6, "time.relaxation": 0.0}
    assert knobs["ramp"] == found | {"time.ramp": 4e-6}
    assert knobs["hold"] == found | {"time.hold": 2e-5}  # half the damping would settle less
    assert knobs["time step"] == {"time.fraction": 0.45}


def outcome(error: float, cost: float) -> Record:
    """A parabola of pressure and a force, both too large by `error`."""
    x = np.linspace(-1.0, 1.0, 41)
    columns: dict[str, Any] = {name: np.zeros(41) for name in ContactCurve.COLUMNS}
    columns |= {"x": x, "pressure": (1.0 - x**2) * (1.0 + error)}
    summary = {"cost": {"run_cpu_s": cost, "compile_s": 0.0}, "contacts": {"a": {"resultant": [0.0, 1.0 + error]}}}
    return Record("finished", "", summary | RESOLVED, curves={"contacts.0": [ContactCurve(**columns)]})


def test_parts_are_those_of_richardson() -> None:
    """Errors of 1 % that halve (first order) and fall to a quarter (second order)."""
    for order in (1.0, 2.0):
        knob = Knob("mesh", {}, order)
        share = budgets._share(knob, outcome(0.01, 1.0), outcome(0.01 * 0.5**order, 3.0), Judge())
        # over the finer result, which is itself off by half or a quarter of a per cent
        assert share.pressure == pytest.approx(0.01 / (1.0 + 0.01 * 0.5**order), rel=1e-9)
        assert share.force == pytest.approx(share.pressure, rel=1e-9)
        assert share.extra == pytest.approx(2.0)
        assert share.gain == pytest.approx(share.pressure * (1.0 - 0.5**order) / 2.0)


def share(name: str, pressure: float, extra: float) -> Share:
    return Share(Knob(name, {}, 1.0), "finished", "", pressure, pressure, 1.0 + extra, extra)


def test_the_next_knob_takes_off_most_for_its_time() -> None:
    dear, cheap = share("mesh", 0.04, 10.0), share("ramp", 0.01, 1.0)
    assert ErrorBudget("finished", "", 1.0, [dear, cheap]).cheapest is cheap
    assert ErrorBudget("finished", "", 1.0, [dear, share("step", 0.001, -0.1)]).cheapest.knob.name == "step"  # type: ignore[union-attr]
    assert ErrorBudget("finished", "", 1.0, [share("step", math.nan, 1.0)]).cheapest is None


def test_a_knob_that_changes_next_to_nothing_is_not_next_because_its_run_was_faster() -> None:
    mesh, damping = share("mesh", 0.03, 1.2), share("damping", 3e-5, -0.07)
    assert ErrorBudget("finished", "", 1.0, [mesh, damping]).cheapest is mesh


def test_what_is_not_resolved_is_no_part_and_sides_are_no_cure() -> None:
    assert not share("mesh", 1.25, 1.0).resolved
    assert share("mesh", 0.2, 1.0).resolved
    assert share("mesh", math.nan, 1.0).resolved  # nothing is known of it
    side = Share(Knob("slave of contacts.0", {}, 30.0, (0,)), "finished", "", 0.2, 0.2, 1.0, 0.0)
    mesh = share("mesh", 0.01, 10.0)
    assert ErrorBudget("finished", "", 1.0, [side, mesh]).cheapest is mesh


@pytest.mark.full
def test_parts_are_told_with_what_to_refine_and_found_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Statics of a coarse disc: its mesh is off by per cents, its tolerance by nothing that anyone could see."""
    changes = {"bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "integrator": "newton"}
    made = contactlab.error_budget(load_scene("disc-on-block").with_(changes), out=tmp_path / "out", jobs=1)
    assert made.status == "finished"
    capsys.readouterr()
    words = [word for key, value in changes.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    words += ["--jobs", "1", "--out", str(tmp_path / "out"), "--resume", "--json"]
    assert main(["error-budget", "disc-on-block", *words]) == 0
    told = json.loads(capsys.readouterr().out)
    parts = {one["knob"]["name"]: one["pressure"] for one in told["shares"]}
    assert 0.005 < parts["mesh"] < 0.2
    assert parts["tolerance"] < 1e-6
    assert parts == {share.knob.name: share.pressure for share in made.shares}
    assert told["next"] in ("mesh", "element q2", "element q1-fbar")


def test_the_table_says_what_is_not_resolved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "160")  # keys are folded in narrow columns
    element = Share(Knob("element q2", {"bodies.a.element": "q2"}, 30.0), "finished", "", 0.7, 0.1, 2.0, 1.0)
    side = Share(Knob("slave of contacts.0", {"contacts.0.swap": True}, 30.0, (0,)), "finished", "", 0.1, 0.1, 1.0, 0.0)
    showing.show(ErrorBudget("finished", "", 1.0, [element, side, share("mesh", 0.01, 3.0)]), tmp_path)
    told = capsys.readouterr().out
    assert "contacts.0.swap=true" in told
    assert "not resolved" in told
    assert "next: element q2, not resolved yet" in told


def test_forces_of_exchanged_sides_act_on_the_same_body() -> None:
    """A slave and its master have opposite forces: exchanged, the same contact force is no change."""
    exchanged = outcome(0.0, 1.0)
    exchanged.summary["contacts"]["a"]["resultant"] = [0.0, -1.0]
    found = budgets._share(Knob("slave of a", {}, 30.0, (0,)), outcome(0.0, 1.0), exchanged, Judge())
    assert found.force == 0.0
    np.testing.assert_array_equal(forces_of(exchanged, (0,)), forces_of(outcome(0.0, 1.0)))


def test_an_element_that_leads_away_from_the_finer_mesh_is_no_cure() -> None:
    base, mesh = outcome(0.04, 1.0), outcome(0.02, 4.0)
    knob = Knob("element", {}, 30.0, element=True)
    assert budgets._away(knob, base, outcome(0.05, 1.0), mesh, Judge())
    assert not budgets._away(knob, base, outcome(0.01, 1.0), mesh, Judge())
    worse = Share(knob, "finished", "", 0.2, 0.2, 1.0, 0.1, away=True)
    assert ErrorBudget("finished", "", 1.0, [worse, share("mesh", 0.1, 3.0)]).cheapest is not worse


def test_without_pressure_forces_name_the_cure() -> None:
    mesh = Share(Knob("mesh", {}, 1.0), "finished", "", math.nan, 0.1, 2.0, 1.0)
    assert ErrorBudget("finished", "", 1.0, [mesh]).cheapest is mesh
