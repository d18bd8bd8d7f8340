"""What `contactlab explain` lists of packages that are neither the project's nor libraries."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rich.console import Console

from contactlab.commands.explain import _lines, overview, together
from contactlab.explanation.explain import explain
from contactlab.explanation.trial_run import run_trial
from contactlab.parts.registry import Registry
from contactlab.scene.scene import load_scene

PLUGIN = """
from contactlab.api.plugin import Part, hookimpl

@hookimpl
def contactlab_parts():
    return [Part("mesh", "outside-strip", "outside_strip.strip:Strip", "for tests")]
"""
STRIP = """
from dataclasses import dataclass
from contactlab.meshing import Rectangle
from outside_strip.inner.sizes import HEIGHT

@dataclass(frozen=True)
class Strip(Rectangle):
    def mesh(self, element, level):
        assert HEIGHT == 0.2
        return super().mesh(element, level)
"""


@pytest.fixture
def strip(install: Callable[..., None], tmp_path: Path) -> Iterator[None]:
    """A package with a mesh in one module, which imports another one of three, in a distribution of another name."""
    install("strip-maker", "from outside_strip.plugin import contactlab_parts\n", version="0.3")
    files = {"__init__": "", "plugin": PLUGIN, "strip": STRIP, "unused": ""}
    files |= {"inner/__init__": "", "inner/sizes": "HEIGHT = 0.2"}
    (tmp_path / "site" / "outside_strip" / "inner").mkdir(parents=True)
    for name, source in files.items():
        (tmp_path / "site" / "outside_strip" / f"{name}.py").write_text(source)
    yield
    for name in [name for name in sys.modules if name.partition(".")[0] == "outside_strip"]:
        del sys.modules[name]


@pytest.mark.full
def test_modules_of_outside_packages_are_listed_with_their_plugin(strip: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("contactlab.reports.run_details.why_apart", lambda cpu, wall: "")  # told on a busy machine
    registry = Registry()
    changes = {f"bodies.{body}.mesh.use": "outside-strip" for body in ("right", "left")}
    scene = load_scene("two-bars", registry).with_(changes)
    said = explain(scene, registry, run_trial(scene))
    rows = {row.package: row for row in said.modules}
    assert rows["outside_strip"].modules == "inner, inner.sizes, plugin, strip"
    assert rows["outside_strip"].plugin == rows["strip_maker"].plugin == "strip-maker 0.3"
    assert rows["contactlab_quads"].plugin.startswith("contactlab-quads ")
    assert rows["numpy"].plugin == ""
    libraries = sum(not row.plugin for row in said.modules)
    lines = dict(_lines(said, []))
    assert lines["imports"].startswith(f"{libraries} libraries")
    assert "outside_strip (inner, inner.sizes, plugin, strip)" in lines["of plugins"]
    assert {cost.what for cost in said.costs} == {"law", "element", "search", "integration", "solution"}
    # stopped clocks are parts of one that ran on; elements and law are shared out of theirs
    assert 0.0 < sum(cost.seconds for cost in said.costs) < said.scene.wall_seconds_per_step
    assert "element: q1" in lines["of a step"]
    out = Console(file=io.StringIO(), width=80)
    out.print(overview(said, ["damping"], "two-bars", {"price": "9 s"}))
    assert "9 s" in out.file.getvalue()  # type: ignore[attr-defined]
    shown = out.file.getvalue()  # type: ignore[attr-defined]
    assert len(shown.splitlines()) <= 30  # a screen
    for word in ("effects", "can be left out", "needs", "contactlab-dynamics", "contact (contacts.0", "MiB", "--all"):
        assert word in " ".join(shown.split())


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ("bodies.anvil.material, bodies.punch.material", "bodies.{anvil,punch}.material"),
        ("contacts.0, contacts.2, contacts.2.friction", "contacts.{0,2}, contacts.2.friction"),
        ("the usual ones, in runs with a folder", "the usual ones, in runs with a folder"),
        (
            "none: the end does not depend on the path (key time.history)",
            "none: the end does not depend on the path (key time.history)",
        ),
    ],
)
def test_keys_that_differ_in_one_name_are_told_together(keys: str, told: str) -> None:
    assert together(keys) == told


@pytest.mark.full
def test_steps_that_effects_shorten_are_told() -> None:
    def steps(name: str, **changes: object) -> str:
        scene = load_scene(name).with_(changes)
        return dict(_lines(explain(scene, scene.registry, run_trial(scene)), ()))["steps"]

    coarse = steps("block-on-incline", **{"bodies.block.mesh.cells": [2, 1]})  # strongly damped for its size
    assert " s by effects or contact pressures, " in coarse
    assert coarse.endswith(" s without)")
    assert "effects" not in steps("disc-on-block")
