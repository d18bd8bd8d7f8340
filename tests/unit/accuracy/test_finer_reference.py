"""A reference from finer and finer meshes: when it is good enough, what it costs, and what it is known to."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from contactlab.accuracy import finer_reference as finer
from contactlab.accuracy.finer_reference import LEVELS, Finer, finer_plan, mean_profile
from contactlab.accuracy.scene_case import may_be_exchanged
from contactlab.api import ContactCurve, Record
from contactlab.jobs.run import Run, here
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import load_scene
from contactlab.studies.profile import Profile, distance, norm

ANGLES = np.linspace(-np.pi / 2, np.pi / 2, 4001)
EXACT = Profile(np.sin(ANGLES), np.cos(ANGLES) ** 3)
"""Smooth enough for interpolants of second order."""
FIRST_ORDER = ("node-on-segment", "node-on-segment, exchanged", "mortar-p0", "mortar-p1")
"""As on a fine slave that is pressed against the kinks of a coarse master: only the exchanged mortars are better."""


class Runs:
    """Runs that give interpolants, those in FIRST_ORDER of first order; costs of h^-2. Records what was run."""

    def __init__(self) -> None:
        self.made: dict[tuple[str, int], float] = {}

    def __call__(self, run: Run) -> Record:
        name, level = run.name.removeprefix("disc-on-block "), run.scene.level
        x = np.linspace(-1.0, 1.0, 8 * level + 1)
        first = 0.1 / level if name in FIRST_ORDER else 0.0
        zero, state = np.zeros_like(x), np.zeros(len(x), np.int32)
        pressure = (1.0 + first) * EXACT(x)
        curve = ContactCurve(x, x, zero, pressure, zero, pressure, zero, state, state)
        cost = self.made[name, level] = 0.1 * level**2
        summary = {"cost": {"run_cpu_s": cost, "compile_s": 0.0}, "process_s": cost}
        return Record("finished", "", summary, curves={"contacts.0": [curve]})


def found_with(runs: Callable[[Run], Record], enough: float, budget: float, folder: Path) -> Finer:
    plan = finer_plan(load_scene("disc-on-block"), "newton", enough, budget, folder, default_registry(), str)
    found: Finer = here(plan, runs)
    return found


def test_it_is_refined_until_it_is_known_well_enough(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(finer, "with_root_edges", lambda profile: profile)  # its edges are none
    scene = load_scene("disc-on-block")
    for enough in (3e-2, 3e-3, 8e-4):
        runs = Runs()
        found = found_with(runs, enough, 1e3, tmp_path)
        assert found.reference is not None
        known = found.reference.pressure_uncertainty
        off = distance(found.reference.profile, EXACT) / norm(EXACT)
        finest = max(level for _, level in runs.made)
        assert known < enough or finest == LEVELS[-1]
        assert off < known < 10.0 * max(off, 1e-4)  # an upper bound, and of use
        # what changes most from level to level goes no further than the second one
        assert max(level for name, level in runs.made if name in FIRST_ORDER) <= LEVELS[1]
        assert found.spent == pytest.approx(sum(runs.made.values()))
        assert found.reference.mismatch(scene.data) == ""
        assert f"level {finest}" in found.reference.mismatch(scene.with_({"level": finest}).data)


def test_a_level_beyond_the_budget_is_not_begun(tmp_path: Path) -> None:
    # level 8 of two costs 2 x 6.4 s after 6 x (0.4 + 1.6) s of three algorithms with either slave
    for budget, finest in ((24.0, 4), (25.5, 8)):
        runs = Runs()
        found = found_with(runs, 1e-9, budget, tmp_path)
        assert max(level for _, level in runs.made) == finest
        assert found.spent <= budget


def test_without_a_run_there_is_no_reference(tmp_path: Path) -> None:
    found = found_with(lambda run: Record("diverged", "it blew up", {}), 0.1, 9.0, tmp_path)
    assert found.reference is None
    assert "no run at level 2 has a pressure at its end (mortar-p0: diverged" in found.why


def test_each_run_has_its_share_of_the_time(tmp_path: Path) -> None:
    """Three algorithms with either slave: a sixth of 0.3 s each, which they all use up."""
    limits: list[float] = []

    def stubborn(run: Run) -> Record:
        limits.append(run.cpu_limit)
        return Record("timed-out", "stopped", {"cpu_limit": run.cpu_limit})

    found = found_with(stubborn, 0.1, 0.3, tmp_path)
    assert limits == pytest.approx([0.05] * 6)
    assert found.reference is None
    assert found.spent == pytest.approx(0.3)


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
