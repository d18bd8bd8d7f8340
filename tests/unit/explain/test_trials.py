"""Costs are foreseen from trials, and a trial that is kept is not made again."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import contactlab
from contactlab.cli import main
from contactlab.commands.effect_costs import effect_costs
from contactlab.commands.explain import price_lines
from contactlab.explanation import trial_run
from contactlab.explanation.estimate import Estimate, estimate
from contactlab.explanation.kept import kept, trials, tried
from contactlab.explanation.trial_run import CUT, Begin, TrialRun
from contactlab.model.build import build
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

STATIC = {"integrator": "newton", "integrator.steps": 10}


def trial(*begin: Any) -> TrialRun:
    return TrialRun([], [], [], 0.5, 0.25, 0.1, 1e-3, 1e-3, [], 40, Begin(*begin) if begin else None)


def foreseen(scene: Scene, *begin: Any) -> Estimate:
    return estimate(scene, build(scene, scene.registry), trial(*begin))


@pytest.fixture
def scene() -> Scene:
    return load_scene("two-bars").with_({"record.recorders": []})


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache for trials alone; kernels stay where they are."""
    monkeypatch.setattr("contactlab.explanation.kept.cache_root", lambda: tmp_path / "cache")
    return tmp_path / "cache"


def test_a_whole_run_costs_what_it_cost(scene: Scene) -> None:
    found = foreseen(scene, "finished", "", 700, 0, 2.0, 0.5, 1.0, 90.0)
    assert (found.cpu_s, found.steps, found.done, found.memory_mib) == (2.0, 700, 1.0, 90.0)
    assert found.least_s < 2.0 < found.most_s
    assert found.start_s == 0.75


@pytest.mark.full
def test_what_the_trial_misses_is_said_before_the_run(own_cache: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Strains of half: with a law for small ones the run would warn, and `explain` says so beforehand."""
    settings = ["integrator=newton", "materials.soft.use=linear-elastic", "bodies.disc.mesh.cells=[8, 2]"]
    settings += ["bodies.block.mesh.cells=[12, 2]", "record.recorders=[]"]
    assert main(["explain", "disc-on-block", "--json", *(word for text in settings for word in ("--set", text))]) == 0
    (told,) = json.loads(capsys.readouterr().out)["missing"]
    assert "body block: strains reach" in told
    assert "its law is for small strains" in told


def test_of_an_explicit_begin_steps_are_multiplied_and_the_rest_is_not(scene: Scene) -> None:
    steps = foreseen(scene).steps
    made = steps / 4.0
    found = foreseen(scene, CUT, "", made, 0, 1.5, 0.5, 0.25, 90.0)
    assert found.cpu_s == pytest.approx(0.5 + 4.0 * 1.0)
    assert found.steps == steps
    assert found.done == pytest.approx(0.25)
    assert found.least_s < found.cpu_s < found.most_s


def test_of_load_steps_the_share_of_the_loading_counts() -> None:
    scene = load_scene("disc-on-block").with_(STATIC)
    found = foreseen(scene, CUT, "", 2, 12, 1.5, 0.5, 0.2, 90.0)
    assert found.cpu_s == pytest.approx(0.5 + 1.0 / 0.2)
    assert (found.steps, found.iterations) == (10.0, 60.0)
    nothing_done = foreseen(scene, CUT, "", 0, 4, 1.0, 0.0, 0.0, 90.0)
    assert nothing_done.least_s < nothing_done.cpu_s < nothing_done.most_s


def test_a_trial_that_failed_is_no_cost(scene: Scene) -> None:
    found = foreseen(scene, "diverged", "it flew", 3, 0, 0.1, 0.0, 0.1, 90.0)
    assert found.reason == "diverged: it flew"
    assert dict(price_lines(found, []))["cost estimate"] == "its trial ended diverged: it flew"


def test_a_trial_is_made_once_and_foresees_the_run(
    scene: Scene, own_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command, in words and as data, and the function need one process among them."""
    scene = scene.with_({"contacts.0.algorithm": "mortar-p1"})
    settings = ["--set", "record.recorders=[]", "--set", "contacts.0.algorithm=mortar-p1"]
    assert main(["explain", "two-bars", *settings, "--json"]) == 0
    price = json.loads(capsys.readouterr().out)["price"]
    monkeypatch.setattr(trial_run, "subprocess", None)  # no process any more
    assert main(["explain", "two-bars", *settings, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["price"] == price
    assert main(["explain", "two-bars", *settings, "--all"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["friction", "no", "not", "declared"] in rows
    assert ["contact", "yes", "contacts.0"] in rows
    assert any(row[:2] == ["contacts.0.algorithm", "mortar-p1"] for row in rows)
    assert not any("tangent" in word for row in rows for word in row)
    found = contactlab.explain(scene)
    assert found.price is not None
    assert found.price.least_s <= found.price.cpu_s <= found.price.most_s
    assert {effect.effect for effect in found.effects if effect.called_for} >= {"inertia", "contact"}
    results = simulate(scene, out=tmp_path / "run")
    assert price["steps"] == pytest.approx(results.summary["steps"], rel=0.05)
    assert 0.0 < price["least_s"] < price["cpu_s"] < price["most_s"]
    assert (own_cache / "trials.sqlite").exists()


def test_a_scene_that_is_changed_by_a_digit_has_no_trial(
    scene: Scene, own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = trial("finished", "", 40, 0, 1.0, 0.0, 1.0, 9.0)
    monkeypatch.setattr("contactlab.explanation.kept.run_trial", lambda *_: made)
    with trials() as archive:
        tried(scene, archive)
        assert kept(scene, archive) is not None
        assert kept(scene.with_({"record.frames": 7}), archive) is None


def test_a_damaged_archive_of_trials_is_replaced(scene: Scene, own_cache: Path) -> None:
    own_cache.mkdir()
    (own_cache / "trials.sqlite").write_bytes(b"SQLite format 3\0" + bytes(range(256)) * 20)
    with trials() as archive:
        assert archive is not None
        assert kept(scene, archive) is None


def test_an_effect_costs_what_its_trials_differ_by() -> None:
    """Iterations that it adds are counted; what has no trial is not told."""
    scene = load_scene("disc-on-block").with_({**STATIC, "contacts.0.friction": {"use": "coulomb", "mu": 0.2}})

    def answer(changed: Scene) -> TrialRun | None:
        rubs = any(contact.friction for contact in changed.contacts)
        if rubs or not changed.contacts:
            return None
        return trial("finished", "", 10, 40, 1.0, 0.0, 1.0, 80.0)

    whole = foreseen(scene, "finished", "", 10, 100, 4.0, 0.0, 1.0, 90.0)
    told: Callable[[Scene], TrialRun | None] = answer
    costs = {cost.effect: cost for cost in effect_costs(scene, whole, told)}
    rubbing = costs["friction"]
    assert (rubbing.cpu_s, rubbing.iterations, rubbing.memory_mib) == (3.0, 60.0, 10.0)
    assert rubbing.least_s < 3.0 < rubbing.most_s
    assert "contact" not in costs
    lines = dict(price_lines(whole, list(costs.values())))
    assert "friction: +3 s, +75 %, +60 iterations" in lines["of that"]
    assert lines["known from"] == "a trial of the whole run"
