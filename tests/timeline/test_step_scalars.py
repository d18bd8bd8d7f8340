"""What is told of contact in every step, whichever way its conditions were written."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene


@pytest.fixture(scope="module")
def both(small_scene: Callable[..., Scene], tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Results]:
    """The same frictionless run, with conditions as factored rows and as rows."""
    scene = small_scene({"contacts.0.algorithm": "mortar-p1"})
    solver = default_registry().part_class("enforcement", "forward-increment")
    with pytest.MonkeyPatch.context() as patch:
        factored = simulate(scene, tmp_path_factory.mktemp("factored") / "run")
        patch.setattr(solver, "factored", False)
        return factored, simulate(scene, tmp_path_factory.mktemp("rows") / "run")


@pytest.mark.full
def test_active_conditions_are_those_that_frames_show(both: tuple[Results, Results]) -> None:
    for run in both:
        states = np.array([frame.curves["contacts.0"].state for frame in run.frames])
        steps = [frame.step for frame in run.frames]
        told = dict(zip(run.steps["step"], run.steps["contacts.0.active"], strict=True))
        assert [told.get(step, 0.0) for step in steps] == (states > 0).sum(axis=1).tolist()
        assert run.steps["contacts.0.active"].max() >= 3


def test_both_ways_tell_the_same(both: tuple[Results, Results]) -> None:
    factored, rows = (run.steps for run in both)
    np.testing.assert_array_equal(factored["contacts.0.active"], rows["contacts.0.active"])
    # conditions hold within 1e-10 segment lengths (0.1 mm), positions within their round-off
    assert max(factored["contacts.0.penetration"].max(), rows["contacts.0.penetration"].max()) < 1e-10
