"""What a run is advised whose impacts last few steps."""

from __future__ import annotations

import pytest

from contactlab.model.build import build
from contactlab.run.contact_times import SHORTEST, ContactTimes
from contactlab.scene.scene import load_scene


@pytest.mark.parametrize("impacts", [True, False])
def test_steps_are_to_be_cut_at_impacts_only_where_they_are_not(impacts: bool) -> None:
    """A contact of three steps in which none was cut: too weak an impact to be cut, or cutting is not wished."""
    scene = load_scene("two-bars").with_(integrator={"use": "implicit-dynamics", "impacts": impacts})
    times = ContactTimes(build(scene, scene.registry), 1e-6)
    times.numbers[SHORTEST] = 3e-6
    (warning,) = times.warnings("integrator.steps", 100.0)
    assert ("set integrator.impacts = true" in warning.text) is not impacts
    assert warning.text.endswith("take steps of 7.5e-08 s")
