"""Scenes that come with the project: each runs to its end and lacks no effect."""

from __future__ import annotations

import pytest

from contactlab.run.simulation import simulate
from contactlab.scene.scene import bundled_scenes, load_scene

MEANT = {
    # the closed form of a bouncing bar is that of a linear one, at strains that rubber would not stand linearly
    "bouncing-bar": {"finite-strain"},
    # each bounce of a block of few cells takes some of its energy, until it rests
    "dropped-block": {"impact-loss"},
    # bounces bend a disc of few cells, which q1 is 6 % too stiff for: its energy is what the scene is about
    "disc-in-box": {"locking"},
    # the load of a corner on a corner is a point's; pressed on a plane by as much, q1 is 13 % stiffer than q2
    "vertex-to-vertex": {"locking"},
}
"""Warnings that a scene deserves and is meant to have."""
TO_THE_END = {"disc-in-box": {"impact-loss"}}  # over all of its bounces
SHORTER = {
    # the weight is all there at 0.03 s: it slides half as long as it was put down
    "block-on-incline": {"time.end": 0.045},
    "bouncing-bar": {"time.end": 7.0},  # a period and a half: 16/3 s from top to top
    "disc-in-box": {"time.end": 1.25e-3},  # three bounces, at both pairs of walls
    "dropped-block": {"time.end": 0.2},  # some bounces
    "spinning-pair": {"time.end": 3e-3},  # a quarter of a turn
    "stack": {"time.end": 0.03, "effects.0.ramp": 0.025},  # a wave is 1.2 ms on its way through all blocks
}
"""Ends after which nothing new happens; `make test FULL=1` follows these scenes to their own."""
ELSEWHERE = {
    "three-body-forging",  # case forging of the quick matrix runs it on cells twice as long
    "corner-slide",  # test_leaning_forces.py runs it, and asks that it ends and warns of nothing
    "initial-overlap",  # so does test_even_compression.py
}


@pytest.mark.parametrize(
    ("name", "changes"),
    [(name, SHORTER.get(name, {})) for name in sorted({*bundled_scenes()} - ELSEWHERE)]
    + [pytest.param(name, {}, marks=pytest.mark.full) for name in SHORTER],
)
def test_it_ends_and_has_the_effects_that_it_needs(name: str, changes: dict[str, float]) -> None:
    results = simulate(load_scene(name).with_(changes))
    assert results.status == "finished", results.reason
    warned = {warning.code: warning.text for warning in results.warnings}
    meant = MEANT.get(name, set()) | (set() if changes else TO_THE_END.get(name, set()))
    assert warned.keys() == meant, warned
