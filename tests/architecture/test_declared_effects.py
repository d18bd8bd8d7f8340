"""Only what a scene declares is imported, allocated and called, and `explain` says exactly that."""

from __future__ import annotations

import gc
import json
import re
import subprocess
import sys
import tracemalloc
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactlab.explanation.explain import explain
from contactlab.model.build import build
from contactlab.model.held_arrays import held_arrays
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene, load_scene

TANGENTIAL = re.compile(
    r"contact\.(rows\.(tangent_weight|slip|bound)|pairs\.\d+\.(points\.)?sliding\.(bound|before|began\..*))"
)
COULOMB = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
PLASTIC = {"materials.soft": {"use": "linear-hardening", "young": 7000.0, "poisson": 0.3, "density": 2.7e-9,
                              "yield_stress": 100.0, "hardening": 50.0}}  # fmt: skip


def scene(changes: dict[str, Any] | None = None) -> Scene:
    return load_scene("disc-on-block").with_(changes or {})


def without_contact() -> Scene:
    data = scene().data
    data["contacts"] = []
    return Scene.from_data(data)


def names(scene: Scene) -> list[str]:
    """Arrays with anything in them."""
    return [array.name for array in held_arrays(build(scene, default_registry())) if array.bytes]


def tangential(found: Iterable[str]) -> set[str]:
    return {name for name in found if TANGENTIAL.fullmatch(name)}


def declared(scene: Scene) -> dict[str, bool]:
    return {effect.effect: effect.called_for for effect in explain(scene, default_registry()).effects}


# --- what explain says ------------------------------------------------------------------------------


def test_frictionless_elastic_scene_lists_nothing_tangential_and_no_history() -> None:
    found = explain(scene(), default_registry())
    listed = [array.name for array in found.arrays if array.bytes]
    assert tangential(listed) == set()
    assert [name for name in listed if "history" in name] == []
    multipliers = next(array for array in found.arrays if array.name == "state.multipliers")
    assert multipliers.shape == "1 x 62"  # one row: normal forces alone, of 25 nodes of the arc, and 37 of the block
    assert declared(scene()) | {"friction": False, "material history": False, "contact": True} == declared(scene())


@pytest.mark.parametrize(
    ("changes", "effects"),
    [
        (COULOMB, {"friction"}),
        (PLASTIC, {"material history", "plasticity"}),
        ({"bodies.disc.velocity": [0.0, -1.0]}, {"initial velocity"}),
    ],
)
def test_a_key_calls_for_its_effects_and_no_other(changes: dict[str, Any], effects: set[str]) -> None:
    before, after = declared(scene()), declared(scene(changes))
    assert {name for name in before if before[name] != after[name]} == effects
    assert all(after[effect] for effect in effects)


def test_friction_brings_its_arrays() -> None:
    way = {"time.history": True}  # friction asks for it by itself
    plain, rough = set(names(scene(way))), set(names(scene(COULOMB)))
    # conditions without friction need no rows: they are solved as columns and coupling
    factored = {name for name in plain if name.startswith("contact.factored.")}
    assert factored
    assert not factored & rough
    plain -= factored
    assert plain < rough
    assert {"contact.rows.tangent_weight", "contact.rows.slip", "contact.rows.bound"} <= rough - plain
    assert tangential(rough) == rough - plain


def test_history_is_as_large_as_the_law_says() -> None:
    model = build(scene(PLASTIC), default_registry())
    law = model.bodies[1].material
    assert law.history_size > 0
    cells = len(model.bodies[1].cells)
    assert model.state["history.block"].size == law.history_size * 4 * cells
    assert "history.disc" not in model.state


def test_without_contacts_nothing_of_contact_is_held_or_called() -> None:
    bare = without_contact()
    found = explain(bare, default_registry())
    assert [name for name in names(bare) if name.startswith("contact") or "multipliers" in name] == []
    assert [call for call in found.calls if "contact" in call.call] == []
    assert build(bare, default_registry()).contact is None
    assert "contactlab_mortar" not in {row.package for row in found.modules}


# --- what is really there ---------------------------------------------------------------------------


@pytest.mark.parametrize("changes", [{}, COULOMB, PLASTIC])
def test_no_array_escapes_the_list(changes: dict[str, Any]) -> None:
    """NumPy's own allocations that outlive `build` are, to the byte, those that are listed."""
    build(scene(changes), default_registry())  # compiles kernels, whose constants are no arrays of a model
    wanted = scene(changes)
    gc.collect()
    tracemalloc.start(8)
    try:
        model = build(wanted, default_registry())
        gc.collect()
        traced = tracemalloc.take_snapshot().filter_traces([tracemalloc.DomainFilter(True, np.lib.tracemalloc_domain)])
    finally:
        tracemalloc.stop()
    really = sum(trace.size for trace in traced.traces)
    listed = sum(array.bytes for array in held_arrays(model))
    # scalars that NumPy keeps for itself, and tables of a handful of numbers inside parts
    assert abs(really - listed) <= 0.02 * really, f"{really} bytes are held, {listed} are listed"


PROBE = """
import json, sys
import contactlab
from contactlab.scene.scene import Scene
for data in json.loads(sys.argv[1]):
    results = contactlab.simulate(Scene.from_data(data), *sys.argv[2:])
    assert results.status == "finished", results.reason
    print(json.dumps(sorted(sys.modules)))
"""

# The push does work of 0.11 N mm per mm of depth. Contact makes another 0.0021 in the first step, however small
# the push is: more than the guard on energy allows a disc that stands almost still.
SHORT = {
    "time.end": 2e-7,
    "supports.1.uy.to": -1e-3,
    "bodies.disc.mesh.cells": [8, 2],
    "bodies.block.mesh.cells": [12, 2],
}


def imported(*scenes: Scene, out: Iterable[str] = ()) -> list[set[str]]:
    """Modules of a fresh process after it has run each of the scenes for a few steps, into the folder `out` if any."""
    data = json.dumps([scene.data for scene in scenes])
    done = subprocess.run([sys.executable, "-c", PROBE, data, *out], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [set(json.loads(line)) for line in done.stdout.splitlines()[-len(scenes) :]]


def working(modules: Iterable[str]) -> set[str]:
    """Plugin packages of which more than the light entry point was imported."""
    return {
        name.partition(".")[0]
        for name in modules
        if name.startswith("contactlab_") and "." in name and not name.endswith(".plugin")
    }


NODES = {"contacts.0.algorithm": "node-on-segment"}


@pytest.mark.full
@pytest.mark.parametrize("changes", [{}, NODES, COULOMB])
def test_a_run_imports_the_packages_that_explain_lists(changes: dict[str, Any]) -> None:
    wanted = scene(SHORT | changes)
    packages = {row.package for row in explain(wanted, default_registry()).modules}
    listed = {package for package in packages if package.startswith("contactlab_")}
    assert [working(found) for found in imported(wanted)] == [listed]


@pytest.mark.full
def test_a_run_without_contact_that_records_imports_no_contact(tmp_path: Path) -> None:
    (found,) = imported(without_contact().with_(SHORT), out=[str(tmp_path / "run")])
    assert "contactlab_rerun" in working(found)
    assert not {"contactlab.contact.pair", "contactlab.kernels.contact"} & found


def test_runs_import_no_contact_no_report_and_no_solvers_of_scipy_that_they_do_not_need() -> None:
    """A run without contact, and then a small explicit one: solvers take a fifth of a second to be imported.

    Neither for its pace nor for its kernels nor to judge its end.
    """
    small = scene({"bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2]})
    found, modules = imported(without_contact().with_(SHORT), small)
    assert working(found) == {"contactlab_dynamics", "contactlab_quads", "contactlab_solids"}
    for heavy in ("matplotlib", "rich", "rerun", "meshio"):
        assert heavy not in found, f"{heavy} was imported by a run that draws nothing"
    assert not {"scipy.sparse", "scipy.spatial", "scipy.special"} & modules  # numba takes scipy.linalg for its BLAS
