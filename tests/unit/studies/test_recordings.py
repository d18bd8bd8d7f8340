"""Titles of runs side by side on one timeline."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from contactlab.scene.scene import load_scene
from contactlab.studies.recordings import SHOWN, side_by_side, titled_runs

FRICTION = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}


def run(changes: dict[str, Any]) -> Any:
    scene = load_scene("disc-on-block").with_(changes)
    contacts = [SimpleNamespace(algorithm=c.algorithm["use"], slave=c.sides[0]) for c in scene.contacts]
    return SimpleNamespace(layout=SimpleNamespace(scene=scene.toml(), contacts=contacts, title=scene.name))


def test_runs_with_and_without_contact_stand_side_by_side() -> None:
    runs = {"a": run(FRICTION), "b": run({"contacts": []}), "c": run({})}
    titles = list(titled_runs(runs))
    assert titles[1] == "no contact"
    assert titles[0].startswith("mortar-p0")
    assert "coulomb" in titles[0]
    assert len(set(titles)) == 3


def test_sides_are_named_where_they_are_exchanged() -> None:
    titles = list(titled_runs({"a": run({}), "b": run({"contacts.0.swap": True})}))
    assert titles == ["mortar-p0, slave disc", "mortar-p0, slave block"]


def test_of_many_runs_the_first_of_each_algorithm_is_shown() -> None:
    few = {str(n): "mortar-p0" for n in range(SHOWN)}
    assert side_by_side(few) == list(few)
    many = {f"{n}-{name}": name for n in range(5) for name in ("mortar-p0", "mortar-p1", "node-on-segment")}
    assert side_by_side(many) == ["0-mortar-p0", "0-mortar-p1", "0-node-on-segment"]
    assert len(side_by_side({str(n): f"algorithm-{n}" for n in range(2 * SHOWN)})) == SHOWN
