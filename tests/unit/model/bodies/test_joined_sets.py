"""Which sides of a body a contact joins to each other, so that they may lie on each other."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from contactlab.model.bodies.build_bodies import _joined_sets
from contactlab.scene.keys import Contact


def scene(*sides: tuple[Any, Any]) -> Any:
    return SimpleNamespace(contacts=[Contact(slave=a, master=b, algorithm=SimpleNamespace()) for a, b in sides])


def test_only_sides_of_one_body_are_joined() -> None:
    found = _joined_sets(scene(("ring.upper", "ring.lower"), ("block.top", "ring.outer"), ("ring.inner", "floor")))
    assert found == {"ring": [(["upper"], ["lower"])]}


def test_lists_of_edge_sets_are_joined_body_by_body() -> None:
    slave, master = ("a.left", "ring.x", "ring.z"), ("ring.y", "a.right", "b.top")
    assert _joined_sets(scene((slave, master))) == {"a": [(["left"], ["right"])], "ring": [(["x", "z"], ["y"])]}


def test_a_stack_of_blocks_joins_nothing_within_a_block() -> None:
    """What is looked at for each body does not grow with the number of bodies."""
    assert _joined_sets(scene(*[(f"b{k + 1}.bottom", f"b{k}.top") for k in range(50)])) == {}
