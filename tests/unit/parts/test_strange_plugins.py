"""Plugins that work and still do harm: hooks that are generators, summaries that are written to, slow and loud imports,
groups that miss by a letter, laws that write to their inputs; and results whose plugin is gone."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactlab.api import Floats, Iteration, Material, Step, StepStatus
from contactlab.errors import PartError, WrongAnswer
from contactlab.model.bodies.build_bodies import refuse_writing_to_inputs
from contactlab.parts import loading
from contactlab.parts.loading import Origin, Plugin
from contactlab.parts.registry import Registry
from contactlab.run.load_steps import repeats
from contactlab.scene.scene import load_scene
from contactlab.testing.partners import partners, usual_algorithm

Install = Callable[..., None]
HEAD = "from contactlab.api.plugin import Part, hookimpl\n"
COULOMB = 'Part("friction", "stranger", "contactlab_friction.coulomb:Coulomb", "")'


def reasons(registry: Registry, distribution: str) -> list[str]:
    return [item.reason for item in registry.broken() if item.origin.distribution == distribution]


def test_a_hook_that_is_a_generator_may_yield_parts_and_may_raise(install: Install) -> None:
    install("yields", f"{HEAD}\n@hookimpl\ndef contactlab_parts():\n    yield {COULOMB}\n")
    install(
        "raises", f'{HEAD}\n@hookimpl\ndef contactlab_parts():\n    yield {COULOMB}\n    raise OSError("no disk")\n'
    )
    registry = Registry()
    assert reasons(registry, "raises") == ["contactlab_parts raised OSError: no disk"]
    assert registry.offer("friction", "stranger").origin.distribution == "yields"


def test_a_hook_that_gives_nothing_is_named(install: Install) -> None:
    install("forgets", f"{HEAD}\n@hookimpl\ndef contactlab_parts():\n    {COULOMB}\n")
    assert reasons(Registry(), "forgets") == ["contactlab_parts gave NoneType; allowed: a list of Part"]


def test_a_plugin_that_writes_to_the_summary_changes_its_own_copy(install: Install) -> None:
    spoil = f"{HEAD}\n@hookimpl\ndef contactlab_run_finished(summary, folder):\n"
    install("spoils", spoil + '    summary["energy"].clear()\n    summary["status"] = "failed"\n')
    install("spoils-too", spoil + '    assert summary["status"] == "finished" and summary["energy"]\n')
    summary: dict[str, Any] = {"status": "finished", "energy": {"work": 1.0}}
    assert Registry().run_finished(summary, None) == []
    assert summary == {"status": "finished", "energy": {"work": 1.0}}


def test_loud_and_slow_imports_work_and_are_named(capsys: pytest.CaptureFixture[str], monkeypatch: Any) -> None:
    def loud() -> Any:
        print("welcome")
        return type("Module", (), {"__name__": "loud"})

    monkeypatch.setattr(loading, "SLOW_CPU", -1.0)
    loaded = loading.load(Origin("loud", "loud"), loud)
    assert isinstance(loaded, Plugin)
    slow, printed = loaded.burdens
    assert "delays every command" in slow
    assert printed == "its import prints 'welcome'; it goes to stderr"
    out, err = capsys.readouterr()
    assert (out, err) == ("", "welcome\n")


def test_a_file_that_prints_leaves_stdout_to_the_program(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "loud_file.py"
    file.write_text(f"{HEAD}\nprint('welcome')\n\n\n@hookimpl\ndef contactlab_parts():\n    return [{COULOMB}]\n")
    (burden,) = (item for item in Registry(files=[file]).burdens() if item.origin.distribution == str(file))
    assert "its import prints 'welcome'" in burden.reason
    assert capsys.readouterr() == ("", "welcome\n")


def test_a_quiet_and_quick_import_has_no_burden(install: Install) -> None:
    install("quiet", f"{HEAD}\n@hookimpl\ndef contactlab_parts():\n    return [{COULOMB}]\n")
    assert not [item for item in Registry().burdens() if item.origin.distribution == "quiet"]


def test_an_entry_point_in_a_group_that_misses_by_a_letter_is_named(install: Install, tmp_path: Path) -> None:
    install("misses", f"{HEAD}\n@hookimpl\ndef contactlab_parts():\n    return [{COULOMB}]\n")
    (found,) = tmp_path.rglob("misses-*/entry_points.txt")
    found.write_text("[contactlabs]\nmisses = misses\n[console_scripts]\nmisses = misses:main\n")
    assert reasons(Registry(), "misses") == ['its entry point is in the group "contactlabs"; allowed: "contactlab"']


def test_attempts_without_a_trace_repeat_nothing() -> None:
    silent = Step(status=StepStatus.not_converged)
    told = silent._replace(trace=(Iteration(0.5, 0.1, 1, 0, 0, 1.0),))
    assert not repeats(silent, silent)
    assert repeats(silent._replace(reason="singular"), silent._replace(reason="singular"))
    assert repeats(told, told)
    assert not repeats(told, silent)


def test_a_part_of_a_stranger_is_no_partner(install: Install) -> None:
    part = 'Part("contact", "a", "contactlab_mortar.mortar:MortarP1", "")'
    install("stranger", f"{HEAD}\n@hookimpl\ndef contactlab_parts():\n    return [{part}]\n")
    registry = Registry()
    assert "a" in registry.names("contact")
    assert "a" not in partners(registry, "contact")
    assert usual_algorithm(registry) == "mortar-dual"


@dataclass(frozen=True)
class Law(Material):
    """Shear alone; `spoils` names the input that it writes to."""

    density: float = 1.0
    spoils: str = ""
    kinematics = "small"
    history_size, history_names = 1, ("slip",)

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        shear = 0.5 * (gradient[1] + gradient[2])
        if self.spoils == "gradient":
            gradient[1] = shear
        if self.spoils == "history":
            history[0] += shear
        stress[:] = np.stack([gradient[0], gradient[3], 0.0 * shear, shear])
        new_history[:] = history


def test_a_law_that_writes_to_its_inputs_is_refused_before_the_run() -> None:
    refuse_writing_to_inputs(Law())
    for name in ("gradient", "history"):
        with pytest.raises(WrongAnswer, match=f"Law: stress gave other values to `{name}`"):
            refuse_writing_to_inputs(Law(spoils=name))


def test_the_scene_of_a_stored_run_names_the_distribution_that_is_missing(tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(load_scene("disc-on-block").toml().replace('"mortar-p0"', '"away"'))
    with pytest.raises(PartError) as plain:
        load_scene(scene)
    assert "away-contact" not in str(plain.value)
    parts = {"contacts.0.algorithm": "away (away-contact 1.2)", "integrator": "leapfrog (contactlab-dynamics 1.0)"}
    (tmp_path / "summary.json").write_text(json.dumps({"parts": parts}))
    for changes in ({}, {"integrator": "newton"}):  # another part that is set does not hide it
        with pytest.raises(PartError) as told:
            load_scene(scene, changes=changes)
        assert "the run had it from away-contact 1.2: install that" in str(told.value)


@pytest.mark.parametrize(
    ("line", "now"),
    [
        ("from contactlab.api.late import late", "contactlab.api.compiled.late"),
        ("from contactlab.api import PieceSlopes", "PieceDerivatives"),
    ],
)
def test_what_has_moved_since_version_1_is_named(line: str, now: str, install: Install, tmp_path: Path) -> None:
    install("older", f"{line}\n")
    (reason,) = reasons(Registry(), "older")
    assert reason.endswith(f"; in version 2 of the contract it is {now}")
    file = tmp_path / "older_file.py"
    file.write_text(f"{line}\n")
    with pytest.raises(PartError, match=f"it is {now}"):
        Registry(files=[file]).parts()
