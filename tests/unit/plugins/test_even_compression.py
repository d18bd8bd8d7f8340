"""The exact pressure of two layers, as a reference: it holds where it says, for loads, ways and overlaps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from contactlab_cases.even_compression import EvenCompression

import contactlab
from contactlab.api import Setup
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene, load_scene
from contactlab.studies.find_reference import matching_reference

REFERENCE = EvenCompression()


def layers(of: str = "few-cells", **fields: Any) -> Scene:
    case = default_registry().make("case", {"use": of, **fields})
    (job,) = case.plan(Setup("mortar-p1", element="q1", integrator="newton"), {})
    return Scene.from_data(job.scene)


def test_a_load_passes_whatever_the_moduli() -> None:
    found = matching_reference(layers(stiff=10.0).data)
    assert found is not None
    assert found.name == "even-compression"
    np.testing.assert_allclose(found.profile.value, 1e-3)
    assert found.scalar("reaction") == pytest.approx(1e-3)


def test_a_way_presses_layers_in_series() -> None:
    """Held sideways, M = E (1 - nu)/((1 + nu)(1 - 2 nu)); heights of 1 mm and moduli 10:1 share the way as 1:10."""
    push = {"loads": None, "supports.5": {"on": "upper.top", "uy": {"ramp": "linear", "to": -0.011}}}
    pressure = REFERENCE.solution(layers(stiff=10.0).with_(push).data).pressure
    np.testing.assert_allclose(pressure, 0.01 * 1000.0 * 0.7 / (1.3 * 0.4))


def test_a_bundled_scene_has_an_exact_pressure() -> None:
    """initial-overlap: E (d + overlap)/H = 12.5 MPa, and a run by mortars has it."""
    scene = load_scene("initial-overlap")
    assert REFERENCE.mismatch(scene.data) == ""
    np.testing.assert_allclose(REFERENCE.solution(scene.data).pressure, 12.5)
    results = contactlab.simulate(scene.with_({"record.recorders": []}))
    assert results.status == "finished", results.reason
    assert not results.warnings
    np.testing.assert_allclose(results.contact["contacts.0"].last.pressure, 12.5, rtol=1e-6)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"materials.lower.use": "neo-hookean"}, "law of body lower"),
        ({"supports.3": None}, "body lower bulges"),
        ({"supports.0.ux": 0.1}, "moves sideways"),
        ({"bodies.upper.rotate": 1.0}, "rotated"),
        ({"bodies.upper.shift": [0.1, 0.0]}, "equally wide"),
        ({"bodies.lower.mesh.x": [0.0, 2.0]}, "equally wide"),
        ({"contacts.0.start.gap": "zero"}, "adjusted"),
        ({"effects": [{"use": "gravity", "acceleration": [0.0, -1.0]}]}, "gravity"),
        ({"loads.0.pressure": -1.0}, "nothing is pressed"),
        ({"loads.0.on": "upper.left"}, "load on upper.left"),
        ({"supports.4.on": "lower.left"}, "holds the body along y"),
    ],
)
def test_it_holds_for_no_other_scene(changes: Mapping[str, Any], words: str) -> None:
    assert words in REFERENCE.mismatch(layers().with_(changes).data)


@pytest.mark.parametrize("name", ["disc-on-block", "two-bars", "three-body-forging", "tresca-block", "corner-slide"])
def test_other_bundled_scenes_have_other_pressures(name: str) -> None:
    assert REFERENCE.mismatch(load_scene(name).data)


def test_cases_of_even_layers_measure_by_it() -> None:
    case = default_registry().make("case", "few-cells")
    (pressure, *_) = case.measures(Setup("mortar-p1", element="q1", integrator="newton"))
    assert pressure.answer.value == pytest.approx(1e-3)
    assert pressure.answer.kind == "exact"
    assert pressure.answer.origin == REFERENCE.origin
    assert REFERENCE.mismatch(layers("patch").data) == ""
    assert "rotated" in REFERENCE.mismatch(layers("patch", turn=30.0).data)
