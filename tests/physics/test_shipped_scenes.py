"""Scenes that come with the project, as they are: each runs to its end and lacks no effect."""

from __future__ import annotations

import pytest

from contactlab.run.simulation import simulate
from contactlab.scene.scene import bundled_scenes, load_scene

MEANT = {
    # the closed form of a bouncing bar is that of a linear one, at strains that rubber would not stand linearly
    "bouncing-bar": {"finite-strain"},
    # forces that are not conjugate to the gaps make 5 % of the largest energy on the way over the edge
    "corner-slide": {"contact-energy"},
    # the ramp of "auto" is twice as fast as its warnings ask for: damping takes 6 % of the work, contact makes
    # 1.3 % of the energy; the billet's edges end within segments of the punch, 0.002 mm beyond nodes; the pressure on
    # the anvil keeps teeth of 2 % that load steps do not have: vibrations that plastic flow and friction froze
    "three-body-forging": {
        "contact-energy",
        "damped-work",
        "unbalanced-reactions",
        "pressure-integral",
        "pressure-saw",
    },
}
"""Warnings that a scene deserves and is meant to have."""


@pytest.mark.parametrize("name", bundled_scenes())
def test_it_ends_and_has_the_effects_that_it_needs(name: str) -> None:
    results = simulate(load_scene(name).with_({"record.recorders": []}))
    assert results.status == "finished", results.reason
    warned = {warning.code: warning.text for warning in results.warnings}
    assert warned.keys() == MEANT.get(name, set()), warned
