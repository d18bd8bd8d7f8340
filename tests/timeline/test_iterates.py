"""Displacements and gaps after Newton's iterations are those of the iteration itself, number by number."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from contactlab.errors import RequestError
from contactlab.implicit.iteration import NewtonIteration
from contactlab.results.iterate_sampler import IterateSampler
from contactlab.results.load import load_results
from contactlab.results.precision import PLACES
from contactlab.results.record_plan import IteratePlan, iterate_bytes
from contactlab.results.result_file import FILE
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
STATICS = {"integrator": {"use": "newton", "steps": 6}, "time.end": 1.0, "supports.1.uy.to": -0.05}
# two iterations are too few once contact has spread: attempts are taken back
CUT = STATICS | {
    "integrator": {"use": "newton", "steps": 6, "iterations": 2},
    "supports.1.uy.to": -0.15,
    "record.frames": 20,
}
STORED = 2.0**-20  # of the largest displacement: half of the last place that is kept
SINGLE = 2.0**-24  # of each number


@pytest.fixture(scope="module")
def followed(small_scene: MakeScene, tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, list[Any]]:
    """A run with cut steps, read from its file, and what its iterations found, copied where each of them ends."""
    seen, record = [], NewtonIteration._record

    def copied(self: NewtonIteration, *row: Any) -> Any:
        contact: Any = self.trial.contact
        gap = np.where(contact.conditions.present, contact.conditions.gap, np.nan)
        seen.append((self.trial.u.copy(), gap[contact.pairs[0].own]))
        return record(self, *row)

    folder = tmp_path_factory.mktemp("followed") / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(NewtonIteration, "_record", copied)
        simulate(small_scene(CUT), folder)
    return load_results(folder), seen


@pytest.mark.full
def test_every_iteration_is_stored_as_it_was(followed: tuple[Results, list[Any]]) -> None:
    run, seen = followed
    assert max(row.attempt for row in run.iterations) > 1, "no step was taken back"
    assert [one.number for one in run.iterates] == list(range(1, len(run.iterations) + 1))
    assert len(seen) == len(run.iterations)
    for one, (displacement, gap) in zip(run.iterates, seen, strict=True):
        assert np.abs(one.displacement - displacement).max() <= STORED * np.abs(displacement).max()
        np.testing.assert_allclose(one.gap, gap, rtol=SINGLE, atol=1e-38)
        assert len(one.gap) == len(run.iterations[one.number - 1].active_set)


def test_the_last_iteration_of_a_step_is_its_frame(followed: tuple[Results, list[Any]]) -> None:
    run, _ = followed
    last = {row.step: number for number, row in enumerate(run.iterations)}
    compared = [frame for frame in run.frames if frame.step]
    assert compared
    for frame in compared:
        found = run.iterates[last[frame.step]].displacement
        assert np.abs(found - frame.displacement).max() <= 2.0 * 2.0**-PLACES * np.abs(frame.displacement).max()


@pytest.mark.full
def test_a_run_that_is_taken_up_has_the_same(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A budget for some iterations alone: which of them are kept does not depend on where the run was stopped."""
    whole = simulate(small_scene(STATICS), tmp_path / "every")
    size = iterate_bytes(whole.layout, len(whole.iterations[0].active_set))
    some = STATICS | {"record.budget": 12.5 * size / 1e6}
    once = simulate(small_scene(some), tmp_path / "once")
    assert len(once.iterates) < len(once.iterations)
    assert any("displacements of some iterations are left out" in event.text for event in once.events)
    monkeypatch.setattr("contactlab.run.restart.RESUMABLE", ("timed-out",))
    monkeypatch.setattr("contactlab.results.vtkhdf.RESUMABLE", ("timed-out",))
    begun = simulate(small_scene(some), tmp_path / "twice", work=9)
    assert begun.status == "timed-out"
    twice = simulate(small_scene(some), tmp_path / "twice", resume=True)
    assert [one.number for one in twice.iterates] == [one.number for one in once.iterates]
    for a, b in zip(twice.iterates, once.iterates, strict=True):
        assert np.array_equal(a.displacement, b.displacement)
        assert np.array_equal(a.gap, b.gap, equal_nan=True)
        assert np.array_equal(a.displacement, whole.iterates[a.number - 1].displacement)
    assert list(twice.events) == list(once.events)


def test_nothing_is_copied_that_nobody_records(
    small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "contactlab.results.iterate_sampler.placed", lambda *_: pytest.fail("displacements were copied")
    )
    for name, changes in (("none", {"record.recorders": []}), ("budget", {"record.budget": 0})):
        run = simulate(small_scene(STATICS | changes), tmp_path / name)
        assert run.iterations
        assert not len(run.iterates)


def test_a_damaged_row_is_told_and_left_out(followed: tuple[Results, list[Any]], tmp_path: Path) -> None:
    run, _ = followed
    assert run.folder is not None
    (tmp_path / FILE).write_bytes((run.folder / FILE).read_bytes())
    with h5py.File(tmp_path / FILE, "r+") as file:
        table = file["contactlab/iterates/displacement"]
        values = table[2]
        values[0, 0] += 1e-3
        table[2] = values
    left = load_results(tmp_path, salvage=True)
    assert [one.number for one in left.iterates] == [n for n in range(1, len(run.iterations) + 1) if n != 3]
    with pytest.raises(RequestError, match="damaged"):
        list(load_results(tmp_path).iterates)


class StillModel:
    """A model that iterates without moving."""

    contact = None

    def __init__(self) -> None:
        self.state = type("State", (dict,), {"step": 4})(displacement=np.ones((2, 2)))


def test_the_window_is_that_of_steps() -> None:
    plan = IteratePlan(100)
    for first, last, expected in ((1, np.inf, 1), (5, 5, 1), (1, 4, 0), (6, np.inf, 0)):
        sampler = IterateSampler(StillModel(), plan, first, last, 0)  # type: ignore[arg-type]
        sampler.seen()
        assert len(sampler.take(1)) == expected


def test_an_integrator_that_tells_of_too_few_leaves_nothing_false() -> None:
    """Numbers would belong to other iterations: what cannot be told apart is not recorded."""
    sampler = IterateSampler(StillModel(), IteratePlan(100), 1, np.inf, 0)  # type: ignore[arg-type]
    sampler.seen()
    assert sampler.take(3) == []
    for _ in range(2):
        sampler.seen()
    assert [one.number for one in sampler.take(5)] == [4, 5]
