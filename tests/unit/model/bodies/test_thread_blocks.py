"""Blocks side by side: no two at a time on one node, and the same bits from any number of threads."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

from contactlab.model.bodies import body as body_module
from contactlab.model.bodies.thread_blocks import Threads, colours, in_order, threads_of_blocks
from contactlab.model.build import build
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

SMALL = 97  # cells of a block: a small mesh then has a dozen of them


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(body_module, "block_size", lambda cells: SMALL)


def scene(**changes: Any) -> Scene:
    return load_scene("disc-on-block").with_(
        {"level": 2, "supports.1.uy.to": -0.002, "time.end": 2e-7, "time.damping": 0.0, **changes}
    )


def test_blocks_of_one_colour_share_no_node() -> None:
    rng = np.random.default_rng(3)
    blocks = [rng.integers(0, 4000, (4, 5)) for _ in range(60)]
    found = colours(blocks, 4000)
    assert len(set(found)) < 20
    for colour in set(found):
        nodes = np.concatenate([np.unique(b) for b, c in zip(blocks, found, strict=True) if c == colour])
        assert len(nodes) == len(np.unique(nodes))


def test_more_neighbours_than_bits_of_an_integer_are_done_one_by_one() -> None:
    blocks = [np.zeros((4, 2), np.int32) for _ in range(70)]
    assert len(set(colours(blocks, 1))) == 70


def _note(made: list[int], number: int, dt: float) -> None:
    made.append(number)


def test_every_update_is_made_once_whatever_the_number_of_threads() -> None:
    for threads in (1, 2, 3, 5):
        made: list[int] = []
        updates = [partial(_note, made, number) for number in range(11)]
        found = [0, 1, 0, 1, 2, 0, 1, 0, 2, 66, 67]
        calls = in_order(updates, found, threads_of_blocks(found, threads, first=1), threads)
        for call in calls:
            call(0.0)
        assert sorted(made) == list(range(11))
        assert [found[number] for number in made] == sorted(found)


def test_a_failing_lane_is_heard_after_all_lanes_have_ended() -> None:
    ended: list[int] = []

    def fails(dt: float) -> None:
        raise ValueError("no stress")

    update = Threads(3).together([[fails], [ended.append], [ended.append]])  # type: ignore[list-item]
    with pytest.raises(ValueError, match="no stress"):
        update(0.5)
    assert ended == [0.5, 0.5]
    with pytest.raises(ValueError, match="no stress"):
        Threads(2).together([[ended.append], [fails]])(0.5)  # type: ignore[list-item]


FULL = pytest.mark.full


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}, marks=FULL),
        pytest.param({"bodies.block.element": "q1-fbar", "bodies.disc.element": "q1-reduced"}, marks=FULL),
        pytest.param({"bodies.block.element": "q2", "materials.soft.use": "hypoelastic"}, marks=FULL),
        pytest.param(
            {
                "materials.soft": {
                    "use": "power-law", "young": 7000.0, "poisson": 0.3, "density": 2.7e-9, "strength": 3.0,
                    "prestrain": 0.02, "exponent": 0.1,
                }
            },
            marks=FULL,
        ),
        {
            "integrator": "newton", "level": 1, "bodies.disc.mesh.cells": [40, 6], "time.damping": None,
            "record.frames": 2,
        },
    ],
    ids=["friction", "stabilised", "quadratic and rate", "plastic", "static"],
)  # fmt: skip
def test_any_number_of_threads_gives_the_same_bits(changes: dict[str, Any]) -> None:
    runs = [simulate(scene(**changes, threads=threads)) for threads in (1, 2, 3)]
    one = runs[0]
    assert one.status == "finished", one.reason
    assert np.abs(one.displacement).max() > 0.0
    for other in runs[1:]:
        assert other.summary["steps"] == one.summary["steps"]
        np.testing.assert_array_equal(other.displacement, one.displacement)
        np.testing.assert_array_equal(other.velocity, one.velocity)
        np.testing.assert_array_equal(
            other.contact["contacts.0"].last.pressure, one.contact["contacts.0"].last.pressure
        )
        for body, stress in one.stress.items():
            np.testing.assert_array_equal(other.stress[body], stress)


def test_threads_work_side_by_side_and_one_thread_starts_none() -> None:
    """Two block_threads that wait for each other come to an end only if both run at once."""
    from threading import Barrier

    meet = Barrier(2, timeout=30.0)
    Threads(2).together([[lambda dt: meet.wait()], [lambda dt: meet.wait()]])(0.0)  # type: ignore[list-item]
    model = build(scene(threads=1), scene().registry)
    assert len(model.updates) == sum(len(forces.blocks) for forces in model.forces)
    several = build(scene(threads=2), scene().registry)
    assert len(several.updates) == len({colour for forces in several.forces for colour in forces.colours})
    # no two block_threads of a body share scratch
    for forces in several.forces:
        owners: dict[int, set[int]] = {}
        for scratch, thread in zip(forces.scratch, forces.block_threads, strict=True):
            owners.setdefault(id(scratch), set()).add(thread)
        assert all(len(block_threads) == 1 for block_threads in owners.values())
        assert set(forces.block_threads) == {0, 1}
