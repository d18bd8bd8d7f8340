"""Every warning: named in the scene that needs the effect, gone when the line that it tells is written."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from contactlab.api import RunWarning
from contactlab.missing_effects.monitor import EffectMonitor
from contactlab.missing_effects.sides import WrongSide
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

ELASTIC = {"young": 1000.0, "poisson": 0.3, "density": 1e-9}
WAVE = 1e-6  # seconds that a wave takes through a body of these scenes: 1 mm at some 1e6 mm/s


def block(law: dict[str, Any], y: tuple[float, float] = (0.0, 1.0), cells: tuple[int, int] = (3, 3)) -> dict[str, Any]:
    """A scene with one body `low`."""
    return {
        "time": {"end": 10.0 * WAVE},
        "integrator": "central-difference",
        "materials": {"m": law},
        "bodies": {"low": body(y, cells)},
        "record": {"frames": 10, "recorders": []},
    }


def body(y: tuple[float, float], cells: tuple[int, int], x: tuple[float, float] = (0.0, 1.0)) -> dict[str, Any]:
    mesh = {"use": "rectangle", "x": list(x), "y": list(y), "cells": list(cells)}
    return {"element": "q1", "material": "m", "mesh": mesh}


def stretched(law: dict[str, Any], by: float) -> dict[str, Any]:
    scene = block(law)
    held = {"on": "low.bottom", "ux": 0.0, "uy": 0.0}
    return {**scene, "supports": [held, {"on": "low.top", "uy": {"ramp": "linear", "to": by}}]}


def colliding(contacts: bool, slave_cells: tuple[int, int] = (3, 3), **changes: Any) -> dict[str, Any]:
    """Two blocks that run into each other by 0.1 mm."""
    scene = block({"use": "neo-hookean", **ELASTIC})
    high = body((1.0, 2.0), slave_cells, (0.2, 0.8)) | {"velocity": [0.0, -0.1 / (10.0 * WAVE)]}
    scene["bodies"]["high"] = high | changes
    if contacts:
        scene["contacts"] = [{"slave": "high.bottom", "master": "low.top", "algorithm": "mortar-p0"}]
    return scene


def squeezed(ramp: float) -> dict[str, Any]:
    scene = stretched({"use": "neo-hookean", **ELASTIC}, -0.02)
    scene["time"] = {"end": "auto", "ramp": ramp, "hold": 0.0}
    scene["supports"][1]["uy"] = {"ramp": "parabola", "to": -0.02}
    return scene


def with_stiff_slave(algorithm: str = "node-on-segment") -> dict[str, Any]:
    scene = colliding(contacts=True, material="hard")
    scene["contacts"][0]["algorithm"] = algorithm
    scene["materials"]["hard"] = {"use": "neo-hookean", **ELASTIC, "young": 30_000.0}
    return scene


def with_coarse_slave() -> dict[str, Any]:
    scene = colliding(contacts=True, slave_cells=(1, 2))
    scene["contacts"][0]["algorithm"] = "node-on-segment"
    scene["bodies"]["low"] = body((0.0, 1.0), (5, 3))
    return scene


SMALL = {"use": "linear-elastic", **ELASTIC}
LIMITED = {"use": "neo-hookean", **ELASTIC, "yield_stress": 15.0}
PLASTIC = {"use": "linear-hardening", **ELASTIC, "yield_stress": 2.0}
SEEDED: dict[str, tuple[str, dict[str, Any], str]] = {
    "strain of a small-strain law": ("finite-strain", stretched(SMALL, 0.1), r"1[0-9] %"),
    "rotation of a small-strain law": (
        "finite-strain",
        block(SMALL) | {"bodies": {"low": body((0.0, 1.0), (3, 3)) | {"spin": 1e4}}},
        r"rotations reach [5-9]\.\d degrees",
    ),
    "yield stress that is not used": (
        "plasticity", stretched(LIMITED, 0.02), r"its yield stress is 15",
    ),
    "Poisson's ratio near one half": (
        "locking", stretched({"use": "neo-hookean", **ELASTIC, "poisson": 0.495}, 0.01), r"about [34]\d % too small",
    ),
    "plastic flow": ("locking", stretched(PLASTIC, 0.04), r"plastic strain.* reaches"),
    "a fast quasi-static run": ("slower-loading", squeezed(5.0 * WAVE), r"kinetic energy reaches"),
    "touch without contact": ("contact", colliding(contacts=False), r"body (high|low) runs into body (low|high)"),
    "a stiff slave": ("other-slave", with_stiff_slave(), r"30 times as stiff"),
    "a coarse slave": ("other-slave", with_coarse_slave(), r"3(\.\d+)? times as long"),
}  # fmt: skip
"""By what is seeded: the warning, the scene, and the number in it."""


def warnings_of(data: dict[str, Any]) -> list[RunWarning]:
    results = simulate(Scene.from_data(data))
    assert results.status in ("finished", "not-converged"), results.reason
    return results.warnings


@pytest.mark.parametrize("seed", SEEDED)
def test_what_is_needed_is_named_once_with_its_number(seed: str) -> None:
    name, data, number = SEEDED[seed]
    found = [warning for warning in warnings_of(data) if warning.code == name]
    assert len(found) == 1
    assert re.search(number, found[0].text), found[0].text
    assert found[0].value > found[0].limit


def test_a_cell_that_is_strained_evenly_does_not_lock() -> None:
    """Between smooth plates every point flows alike: elements with and without locking agree, and nothing is told."""
    scene = stretched(PLASTIC, -0.04) | {"time": {}, "integrator": {"use": "newton", "steps": 10}}
    scene["supports"] = [
        {"on": "low.bottom", "uy": 0.0}, {"on": "low.left", "ux": 0.0},
        {"on": "low.top", "uy": {"ramp": "linear", "to": -0.04}},
    ]  # fmt: skip
    results = [simulate(Scene.from_data(scene).with_({"bodies.low.element": element})) for element in ("q1", "q1-fbar")]
    assert [warning.code for warning in results[0].warnings] == []
    forces = [one.summary["reactions"]["low.top"][1] for one in results]
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)


@pytest.mark.parametrize("law", ["linear-elastic", "neo-hookean"])
def test_a_pulled_strip_whose_end_moves_aside_needs_a_law_for_rotations(law: str) -> None:
    """It pulls back with F d/L, as a string: a small-strain law gives its bending stiffness alone, and says so."""
    force, aside, length = 1.0, 0.2, 10.0
    scene = block({"use": law, **ELASTIC, "poisson": 0.0}) | {"time": {}, "integrator": "newton"}
    mesh = {"use": "rectangle", "x": [0.0, length], "y": [0.0, 0.1], "cells": [20, 1]}
    scene["bodies"] = {"low": {"element": "q2", "material": "m", "mesh": mesh}}
    end = {"on": "low.right", "uy": {"ramp": "linear", "to": aside}}
    scene["supports"] = [{"on": "low.left", "ux": 0.0, "uy": 0.0}, end]
    scene["loads"] = [{"on": "low.right", "tx": {"ramp": "linear", "to": force / 0.1}}]
    results = simulate(Scene.from_data(scene))
    back = results.summary["reactions"]["low.right"][1]
    if law == "neo-hookean":
        # 3 %: rotations that both ends hold over (EI/F)^(1/2), a hundredth of the length each
        assert back == pytest.approx(force * aside / length, rel=0.03)
        assert results.warnings == []
    else:
        assert back < 0.01 * force * aside / length
        assert [warning.code for warning in results.warnings] == ["finite-strain"]
        assert results.warnings[0].value == pytest.approx(aside / length, rel=0.01)  # the rotation


def test_mortars_are_not_advised_on_the_side_of_the_slave() -> None:
    assert "other-slave" not in [warning.code for warning in warnings_of(with_stiff_slave("mortar-p0"))]


@pytest.mark.parametrize("algorithm", ["mortar-p1", "midplane"])
def test_facets_of_an_arc_lean_to_and_fro(algorithm: str) -> None:
    """That takes less than 1 % of the force along the normal, and friction is no better with the other slave.

    Shear on mu p here: 1.25 on this mesh, 1.73 with the sides exchanged, 1.1 N/mm on a mesh of a quarter of its size.
    """
    arc = {"use": "ring", "radii": [0.3, 1.0], "angles": [180.0, 360.0], "cells": [16, 5]}
    pushed = {"ux": 0.0, "uy": {"ramp": "linear", "to": -0.05}}
    scene = block({"use": "neo-hookean", **ELASTIC}) | {"integrator": "newton", "time": {}}
    held = {"on": "low.bottom", "ux": 0.0, "uy": 0.0}
    scene["supports"] = [held, {"on": "high.start", **pushed}, {"on": "high.end", **pushed}]
    scene["bodies"] = {
        "low": body((-1.0, 0.0), (14, 6), (-1.0, 1.0)),
        "high": {"element": "q1", "material": "m", "mesh": arc, "shift": [0.0, 1.0]},
    }
    contact = {"slave": "high.outer", "master": "low.top", "algorithm": algorithm}
    for friction in ({}, {"friction": {"use": "coulomb", "mu": 0.2}}):
        found = [warning.code for warning in warnings_of(scene | {"contacts": [contact | friction]})]
        assert "other-slave" not in found, friction


@pytest.mark.parametrize("leaning", [0.0, 0.2, 0.5, 0.8, 1.0])
def test_no_contact_is_advised_to_exchange_its_sides_both_ways(leaning: float) -> None:
    """Forces lean in a share of the frames; exchanged, the same forces lean in the others."""
    advised = []
    for share in (leaning, 1.0 - leaning):
        pair = SimpleNamespace(name="contacts.0", method=SimpleNamespace(passes_patch_test=True))
        spec = SimpleNamespace(name=None, swap=False, friction=object())
        detector = WrongSide(pair, cast(Any, spec), cast(Any, None), 1.0)
        detector.worst[1:] = 1.0, share * 0.1, 0.1, (1.0 - share) * 0.1, 0.0, share * 0.1
        advised.append(detector.warning() is not None)
    assert not all(advised)
    assert any(advised) == (leaning != 0.5)


def test_a_run_that_nothing_resists_is_not_only_told_to_be_slower() -> None:
    scene = squeezed(50.0 * WAVE)
    scene["supports"] = scene["supports"][1:]  # nothing holds the other end: the block moves as a whole
    (found,) = [warning for warning in warnings_of(scene) if warning.code == "slower-loading"]
    assert "nothing resists" in found.text
    assert "contacts" in found.text


@pytest.mark.parametrize("seed", SEEDED)
def test_what_it_says_to_write_mends_it(seed: str) -> None:
    name, data, _ = SEEDED[seed]
    scene = Scene.from_data(data)
    told = next(warning for warning in warnings_of(data) if warning.code == name)
    left = [w.code for w in warnings_of(scene.with_(change(told.text, scene)).data)]
    assert name not in left


def change(told: str, scene: Scene) -> dict[str, Any]:
    """`write KEY = VALUE` as a change; a contact to add as a whole."""
    if "; add [[contacts]]" in told:
        slave, master = re.findall(r'"([^"]+)"', told)
        return {"contacts.0": {"slave": slave, "master": master, "algorithm": "node-on-segment"}}
    match = re.search(r"write ([\w.]+) = (\"?)([^\s\"]+)\2", told)
    assert match is not None, told
    key, quoted, value = match.groups()
    given = {"true": True, "false": False}.get(value, value if quoted else None)
    return {key: float(value) if given is None else given} | _yield_stress(key, scene)


def _yield_stress(key: str, scene: Scene) -> dict[str, Any]:
    """A yield stress that was written for an elastic law stays in the file when the law is changed there."""
    material = key.removesuffix(".use")
    written = scene.materials.get(material.removeprefix("materials."), {})
    return {f"{material}.yield_stress": written["yield_stress"]} if written.get("yield_stress") else {}


def test_a_sound_scene_has_no_warning() -> None:
    assert warnings_of(stretched(SMALL, 0.01)) == []
    # blocks of few cells: nothing is missing, and impacts take energy
    assert [warning.code for warning in warnings_of(colliding(contacts=True))] == ["impact-loss"]


# --- overlaps ---------------------------------------------------------------------------------------


def codes_of(data: dict[str, Any], displacement: Any) -> list[str]:
    """Codes of the warnings of a model in a state that no run has to reach."""
    scene = Scene.from_data(data)
    model = build(scene, default_registry())
    model.state["displacement"][:] = displacement(model.reference) - model.reference
    np.add(model.reference, model.state["displacement"], out=model.position)
    EffectMonitor(scene, model).examine_frame()
    return [warning.code for warning in model.warnings]


def coiled(turns: float) -> Any:
    """A strip of length 10 bent into an arc of so many turns, on a slight spiral or not."""

    def positions(x: Any) -> Any:
        angle = 2.0 * math.pi * turns * x[:, 0] / 10.0
        radius = 2.0 - x[:, 1]
        return np.stack([radius * np.sin(angle), 2.0 - radius * np.cos(angle)], axis=1)

    return positions


@pytest.mark.parametrize(("turns", "named"), [(0.9, False), (1.1, True)])
def test_a_body_that_runs_into_itself_is_named(turns: float, named: bool) -> None:
    strip = block({"use": "neo-hookean", **ELASTIC})
    strip["bodies"] = {"low": body((0.0, 0.5), (40, 2), (0.0, 10.0))}
    assert ("contact" in codes_of(strip, coiled(turns))) is named


@pytest.mark.parametrize(("depth", "named"), [(-0.5, False), (0.0, False), (0.001, False), (0.02, True), (0.9, True)])
def test_bodies_touch_where_one_lies_a_hundredth_of_an_edge_deep(depth: float, named: bool) -> None:
    def lowered(x: Any) -> Any:
        return x - np.where(np.arange(len(x)) >= 16, depth, 0.0)[:, None] * [0.0, 1.0]

    # edges of `high` are 0.2 mm long: and their corners' normals lean: nodes at 0.0014 mm are on the brink
    assert ("contact" in codes_of(colliding(contacts=False), lowered)) is named


def test_the_contact_to_add_joins_the_edges_that_met_first() -> None:
    """Also when the body has come nearer to the other one's far side since."""
    scene = Scene.from_data(colliding(contacts=False))
    model = build(scene, default_registry())
    monitor = EffectMonitor(scene, model)
    for depth in (0.05, 0.9):
        np.copyto(model.position, model.reference)
        model.position[16:, 1] -= depth
        monitor.examine_frame()
    (found,) = [warning for warning in model.warnings if warning.code == "contact"]
    assert set(re.findall(r'"([^"]+)"', found.text)) == {"high.bottom", "low.top"}


def test_surfaces_with_a_contact_may_press_into_each_other() -> None:
    def lowered(x: Any) -> Any:
        return x - np.where(np.arange(len(x)) >= 16, 0.02, 0.0)[:, None] * [0.0, 1.0]

    # high's bottom corners belong to the contact; its sides do not, and stay out
    assert "contact" not in codes_of(colliding(contacts=True), lowered)


@pytest.mark.parametrize(("depth", "named"), [(-0.5, False), (0.001, False), (0.1, True)])
def test_a_rigid_surface_is_passed_where_no_contact_holds_a_body(depth: float, named: bool) -> None:
    """Its right side alone is joined to the floor under it; with its lower side joined, too, nothing is told."""
    scene = block({"use": "neo-hookean", **ELASTIC})
    scene["rigid"] = {"floor": {"line": [[9.0, 0.0], [-9.0, 0.0], [-9.0, 5.0]]}}
    scene["contacts"] = [{"slave": "low.left", "master": "floor", "algorithm": "mortar-p0"}]

    def lowered(x: Any) -> Any:
        return x - np.where(np.arange(len(x)) < 16, depth, 0.0)[:, None] * [0.0, 1.0]

    assert ("contact" in codes_of(scene, lowered)) is named
    scene["rigid"]["wall"] = {"line": [[-20.0, 0.0], [-20.0, 5.0]]}
    scene["contacts"][0]["master"] = ["wall", "floor"]
    assert ("contact" in codes_of(scene, lowered)) is named
    scene["contacts"][0]["slave"] = ["low.left", "low.bottom"]
    assert "contact" not in codes_of(scene, lowered)


@pytest.mark.parametrize(("beyond", "named"), [(0.0, False), (0.1, True)])
def test_a_body_flush_with_the_end_of_a_rigid_surface_does_not_pass_it(beyond: float, named: bool) -> None:
    """The right side of a body begins where a floor for another one does; moved to the right it is cut by the floor."""
    scene = block({"use": "neo-hookean", **ELASTIC})
    scene["bodies"]["high"] = body((1.0, 2.0), (3, 3), (1.0, 2.0))
    scene["rigid"] = {"floor": {"line": [[9.0, 1.0], [1.0, 1.0]]}}
    scene["contacts"] = [{"slave": "high.bottom", "master": "floor", "algorithm": "mortar-p0"}]

    def moved(x: Any) -> Any:
        return x + np.where(np.arange(len(x)) < 16, beyond, 0.0)[:, None] * [1.0, 1.0]

    assert ("contact" in codes_of(scene, moved)) is named
