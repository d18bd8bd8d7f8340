"""The breakdown: what can be taken out of a scene, and effects of runs whose costs and answers are known."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from contactlab.api import Record
from contactlab.comparison import compare
from contactlab.errors import RequestError
from contactlab.reports.breakdown_table import by_cost, render_breakdown
from contactlab.results.results import ContactCurve
from contactlab.scene.scene import Scene, load_scene
from contactlab.studies.cost_breakdown import BreakdownPlan, breakdown_of, plan_breakdown
from contactlab.studies.removable import variants

COULOMB = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
GRAVITY = {"effects": [{"use": "gravity", "acceleration": [0.0, -9810.0]}]}
ELASTIC = {"young": 7000.0, "poisson": 0.3, "density": 2.7e-9}
PLASTIC = {"use": "linear-hardening", **ELASTIC, "yield_stress": 9.0}
FOLLOWING = {"loads": [{"on": "block.left", "pressure": 1.0}]}

# what disc-on-block has and lacks: friction and gravity are not among it
USUAL = {
    "without contact", "without damping", "without recording", "without inertia", "without finite strain",
    "with quadratic shape functions", "with freedom from locking",
}  # fmt: skip


def scene(changes: dict[str, Any] | None = None) -> Scene:
    return load_scene("disc-on-block").with_(changes or {})


def labels(changes: dict[str, Any]) -> set[str]:
    return {variant.label for variant in variants(scene(changes))}


# --- what can be taken out --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "more", "less"),
    [
        ({}, set(), set()),
        (COULOMB, {"without friction"}, set()),
        (GRAVITY, {"without gravity"}, set()),
        (FOLLOWING, {"without loads that follow"}, set()),
        ({"record.recorders": []}, set(), {"without recording"}),
        ({"time.end": 1e-6}, set(), {"without damping"}),
        ({"time.end": 1e-6, "time.damping": 1.0}, set(), set()),
        ({"integrator": "newton"}, set(), {"without inertia", "without damping"}),
        ({"bodies.block.element": "q2"}, {"without quadratic shape functions"}, {"with quadratic shape functions"}),
        ({"bodies.disc.element": "q1-fbar"}, {"without freedom from locking"}, {"with freedom from locking"}),
        (
            {"materials.soft": {"use": "linear-hardening", **ELASTIC, "yield_stress": 9.0}},
            {"without plasticity"},
            set(),
        ),
        ({"materials.soft": {"use": "neo-hookean", **ELASTIC, "yield_stress": 9.0}}, {"with plasticity"}, set()),
        (
            {"materials.soft.use": "linear-elastic", "materials.steel.use": "linear-elastic"},
            {"with finite strain"},
            {"without finite strain"},
        ),
    ],
)
def test_a_scene_is_broken_down_by_what_it_declares(changes: dict[str, Any], more: set[str], less: set[str]) -> None:
    assert labels(changes) == USUAL - less | more


@pytest.mark.parametrize("changes", [COULOMB, GRAVITY, {"bodies.block.element": "q2"}])
def test_a_variant_differs_in_its_effect_alone(changes: dict[str, Any]) -> None:
    """Taking out what was put in gives the scene that never had it, to the last key."""
    name = next(iter(labels(changes) - USUAL))
    variant = next(v for v in variants(scene(changes)) if v.label == name)
    left = scene(changes).with_(variant.changes).data
    assert {k: v for k, v in left.items() if v != []} == {k: v for k, v in scene().data.items() if v != []}


def test_constants_are_kept_when_a_law_is_changed() -> None:
    variant = next(v for v in variants(scene({"materials.soft": PLASTIC})) if v.label == "without plasticity")
    elastic = scene({"materials.soft": PLASTIC}).with_(variant.changes).materials["soft"]
    assert elastic == {"use": "neo-hookean", **ELASTIC, "yield_stress": 9.0}


# --- effects -----------------------------------------------------------------------------------------


def outcome(
    cpu: float, force: float = 1.0, curve: ContactCurve | None = None, status: str = "finished", steps: int = 100
) -> Record:
    """A run whose force grows in proportion to time, and its energy with the square."""
    time = np.linspace(0.0, 2.0, 11)
    summary = {
        "steps": steps, "iterations": 0, "resolved": {"ramp": 1.0}, "reactions": {"disc.top": [0.0, force]},
        "cost": {"run_cpu_s": cpu + 0.5, "compile_s": 0.5, "arrays_mib": 2.0 * cpu},
    }  # fmt: skip
    history = {
        "time": time, "disc.top.fx": 0.0 * time, "disc.top.fy": force * np.minimum(time, 1.0),
        "energy.internal": force * np.minimum(time, 1.0) ** 2,
    }  # fmt: skip
    curves = {"contacts.0": [curve]} if curve is not None else {}
    return Record(status, "" if status == "finished" else "so it was", summary, history, curves=curves)


@pytest.fixture
def triangle(curve_of: Callable[..., ContactCurve]) -> Callable[[float], ContactCurve]:
    return lambda peak: curve_of(np.linspace(-1.0, 1.0, 21), peak * (1.0 - np.abs(np.linspace(-1.0, 1.0, 21))))


def plan() -> BreakdownPlan:
    return plan_breakdown(scene(COULOMB))


def named(plan: BreakdownPlan, label: str) -> str:
    return next(name for name, variant in plan.shown.items() if variant.label == label)


def test_the_cost_of_an_effect_is_the_difference_of_two_runs(triangle: Callable[[float], ContactCurve]) -> None:
    wished = plan()
    runs = {job.name: outcome(1.0, curve=triangle(1.0)) for job in wished.jobs}
    runs[named(wished, "without friction")] = outcome(0.75, force=0.9, curve=triangle(0.8))
    runs[named(wished, "with quadratic shape functions")] = outcome(3.0, force=1.25, curve=triangle(1.0))
    runs[named(wished, "without contact")] = outcome(0.5, force=0.0, curve=None)
    effects = {cost.effect: cost for cost in breakdown_of(wished, runs).effects}
    friction, quadratic, contact = (effects[n] for n in ("friction", "quadratic shape functions", "contact"))
    assert (friction.step_s, friction.run_s, friction.memory_mib) == pytest.approx((0.0025, 0.25, 0.5))
    # relative to the run that has the effect: forces and energies 0.9 of it, pressures 0.8
    assert (friction.reaction, friction.energy, friction.pressure) == pytest.approx((0.1, 0.1, 0.2))
    assert friction.error == pytest.approx(0.2)
    # not declared: the run with it costs more, and is what the scene is measured by
    assert not quadratic.declared
    assert (quadratic.run_s, quadratic.reaction, quadratic.pressure) == pytest.approx((2.0, 0.2, 0.0))
    assert (contact.reaction, contact.pressure, contact.energy) == pytest.approx((1.0, 1.0, 1.0))


def test_runs_that_fail_are_kept_with_their_reason() -> None:
    wished = plan()
    runs = {job.name: outcome(1.0) for job in wished.jobs}
    runs[named(wished, "without damping")] = outcome(1.0, status="not-converged")
    runs[named(wished, "without contact")] = outcome(0.1, status="diverged")
    runs[named(wished, "without inertia")] = Record("refused", "a body would drift", {})
    effects = {cost.effect: cost for cost in breakdown_of(wished, runs).effects}
    assert effects["damping"].status == "not-converged"
    assert effects["damping"].reaction == 0.0  # it carried the load to its end
    assert (effects["contact"].status, effects["contact"].reason) == ("diverged", "so it was")
    assert math.isnan(effects["contact"].error)
    assert effects["contact"].step_s == pytest.approx(0.009)
    assert math.isnan(effects["inertia"].run_s)
    assert "a body would drift" in effects["inertia"].reason


def test_runs_without_a_common_loading_are_compared_at_its_end() -> None:
    """Half of the force on the way, all of it at the end.

    What a run that is right at its end alone, or that takes load steps, does before tells nothing.
    """
    wished = plan()
    runs = {job.name: outcome(1.0) for job in wished.jobs}
    fast = runs[named(wished, "without friction")]
    fast.history["disc.top.fy"] = np.where(fast.history["time"] < 1.5, 0.5, 1.0) * fast.history["disc.top.fy"]
    (way,) = [cost for cost in breakdown_of(wished, runs).effects if cost.effect == "friction"]
    assert way.reaction == pytest.approx(0.5)
    for change in ({"history": {"curve": "the end only"}}, {"iterations": 5}):
        runs[named(wished, "without friction")] = replace(fast, summary=fast.summary | change)
        (end,) = [cost for cost in breakdown_of(wished, runs).effects if cost.effect == "friction"]
        assert end.reaction == 0.0, change


def test_effects_and_variations_do_not_go_together() -> None:
    with pytest.raises(RequestError, match="no keys are varied"):
        compare("disc-on-block", {"level": [1, 2]}, effects=True)


# --- what is shown ----------------------------------------------------------------------------------


def test_the_dearest_effect_comes_first_and_reasons_below() -> None:
    wished = plan()
    runs = {job.name: outcome(1.0) for job in wished.jobs}
    runs[named(wished, "without friction")] = outcome(0.75)
    runs[named(wished, "without contact")] = outcome(0.1, status="diverged")
    breakdown = breakdown_of(wished, runs)
    assert by_cost(breakdown)[0].effect == "friction"
    console = Console(width=200, record=True)
    console.print(render_breakdown(breakdown, "title"))
    shown = console.export_text()
    assert "without contact: diverged: so it was" in shown
    row = next(line.split() for line in shown.splitlines() if line.split()[:1] == ["friction"])
    # 2500 us of 10000 per step, 0.25 s of the run, and it changes nothing here
    assert row[:5] == ["friction", "yes", "2500", "25", "0.25"]
    assert "friction" in shown[shown.index("Can be switched off") :]


@pytest.mark.full
@pytest.mark.usefixtures("fake_runs")
def test_a_cost_breakdown_is_one_table_one_plot_and_a_page(tmp_path: Path) -> None:
    table = compare(scene(COULOMB), out=tmp_path / "out", jobs=2, effects=True)
    assert table.breakdown is not None
    # the stand-in for a run looks at the first contact: without one it fails, and the row stays
    gone = next(cost for cost in table.breakdown.effects if cost.effect == "contact")
    assert (gone.status, "IndexError" in gone.reason) == ("failed", True)
    rows = list(csv.DictReader((tmp_path / "out" / "bill.csv").open()))
    assert [row["effect"] for row in rows] == [cost.effect for cost in table.breakdown.effects]
    kept = json.loads((tmp_path / "out" / "table.json").read_text())
    assert len(kept["bill"]["prices"]) == len(rows)
    assert len(kept["rows"]) == len(rows) + 1
    page = (tmp_path / "out" / "report.html").read_text()
    for cost in table.breakdown.effects:
        assert cost.effect in page
    assert page.count("<svg") == 1
    assert (tmp_path / "out" / "bill.png").stat().st_size > 10_000
