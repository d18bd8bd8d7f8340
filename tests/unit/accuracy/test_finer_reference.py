"""A reference from finer and finer meshes: when it is good enough, what it costs, and what it is known to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from contactlab.accuracy import finer_reference as finer
from contactlab.accuracy.finer_reference import LEVELS, finer_reference, mean_profile
from contactlab.accuracy.scene_case import may_be_exchanged
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import load_scene
from contactlab.studies.call import Call
from contactlab.studies.profile import Profile, distance, norm

ANGLES = np.linspace(-np.pi / 2, np.pi / 2, 4001)
EXACT = Profile(np.sin(ANGLES), np.cos(ANGLES) ** 3)
"""Smooth enough for interpolants of second order."""
FIRST_ORDER = ("node-on-segment", "node-on-segment, exchanged", "mortar-p0", "mortar-p1")
"""As on a fine slave that is pressed against the kinks of a coarse master: only the exchanged mortars are better."""


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> dict[tuple[str, int], float]:
    """Runs that give interpolants, those in FIRST_ORDER of first order; costs of h^-2. Records what was run."""
    made: dict[tuple[str, int], float] = {}

    def make(self: finer._Runs, ladders: Sequence[finer._Ladder], level: int, budget: float) -> None:
        for ladder in ladders:
            name = ladder.name
            x = np.linspace(-1.0, 1.0, 8 * level + 1)
            first = 0.1 / level if name in FIRST_ORDER else 0.0
            ladder.curves[level] = Profile(x, (1.0 + first) * EXACT(x))
            ladder.costs[level] = made[name, level] = 0.1 * level**2
            self.spent += ladder.costs[level]

    monkeypatch.setattr(finer._Runs, "make", make)
    return made


def test_it_is_refined_until_it_is_known_well_enough(runs: dict[tuple[str, int], float], tmp_path: Path) -> None:
    scene, registry = load_scene("disc-on-block"), default_registry()
    for enough in (3e-2, 3e-3, 8e-4):
        runs.clear()
        found = finer_reference(scene, "newton", enough, 1e3, tmp_path, registry, 1, str)
        assert found.reference is not None
        known = found.reference.pressure_uncertainty
        off = distance(found.reference.profile, EXACT) / norm(EXACT)
        finest = max(level for _, level in runs)
        assert known < enough or finest == LEVELS[-1]
        assert off < known < 10.0 * max(off, 1e-4)  # an upper bound, and of use
        # what changes most from level to level goes no further than the second one
        assert max(level for name, level in runs if name in FIRST_ORDER) <= LEVELS[1]
        assert found.spent == pytest.approx(sum(runs.values()))
        assert found.reference.mismatch(scene.data) == ""
        assert f"level {finest}" in found.reference.mismatch(scene.with_({"level": finest}).data)


def test_a_level_beyond_the_budget_is_not_begun(runs: dict[tuple[str, int], float], tmp_path: Path) -> None:
    # level 8 of two costs 2 x 6.4 s after 6 x (0.4 + 1.6) s of three algorithms with either slave
    scene, registry = load_scene("disc-on-block"), default_registry()
    for budget, finest in ((24.0, 4), (25.5, 8)):
        runs.clear()
        found = finer_reference(scene, "newton", 1e-9, budget, tmp_path, registry, 1, str)
        assert max(level for _, level in runs) == finest
        assert found.spent <= budget


def test_without_a_run_there_is_no_reference(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def make(self: finer._Runs, *rest: object) -> None:
        self.last = {"mortar-p0": "mortar-p0: diverged"}

    monkeypatch.setattr(finer._Runs, "make", make)
    found = finer_reference(load_scene("disc-on-block"), "newton", 0.1, 9.0, tmp_path, default_registry(), 1, str)
    assert found.reference is None
    assert "no run at level 2 came to its end (mortar-p0: diverged)" in found.why


def test_a_rigid_surface_is_no_slave() -> None:
    contact = {"slave": "block.top", "master": "tool"}
    assert may_be_exchanged({"contacts": [contact]})
    assert not may_be_exchanged({"contacts": [contact], "rigid": {"tool": {}}})
    assert not may_be_exchanged(
        {"contacts": [{"slave": "tool", "master": "block.top", "swap": True}], "rigid": {"tool": {}}}
    )


def test_a_pressure_up_to_the_end_of_a_body_is_not_halved_there() -> None:
    # two runs whose last nodes lie 1e-7 apart, and their mirror images: the mean is as high at the ends as each of them
    x = np.linspace(-1.0, 1.0, 9)
    runs = [Profile(x * (1.0 + off), np.full(9, 2.0)) for off in (0.0, 1e-7)]
    mean = mean_profile([*runs, *(run.mirrored() for run in runs)])
    np.testing.assert_array_equal(mean.value, 2.0)
    assert distance(mean, runs[0]) < 1e-3 * norm(runs[0])  # a jump over 1e-7: (1e-7)^(1/2)
    # one that ends a segment earlier does not press beyond
    short = mean_profile([runs[0], Profile(x[:-1], np.full(8, 2.0))])
    assert short(np.array([1.0]))[0] == 1.0


def test_a_stubborn_run_takes_no_more_than_its_share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # three algorithms with either slave: a sixth of 0.3 s each, within which none of them ends level 8
    made: list[float] = []
    whole = finer._Runs._call

    def call(self: finer._Runs, ladder: finer._Ladder, level: int, share: float) -> Call:
        made.append(share)
        return whole(self, ladder, level, share)

    monkeypatch.setattr(finer._Runs, "_call", call)
    found = finer_reference(
        load_scene("disc-on-block"), "newton", 0.1, 0.3, tmp_path, default_registry(), 1, str, levels=(8,)
    )
    assert made == pytest.approx([0.05] * 6)
    assert found.reference is None
    assert found.spent == pytest.approx(0.3)
