"""Every check of mesh sources catches a planted defect."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from contactlab.api import Element, Mesh
from contactlab.meshing import Rectangle
from contactlab.testing import checks_for, mesh
from contactlab.testing.assertions import Check
from contactlab.testing.run import run_check, run_checks


@dataclass(frozen=True)
class Flawed(Rectangle):
    """A rectangle with one named flaw, or none.

    x  [mm] from and to
    y  [mm] from and to
    """

    x: tuple[float, float] = (0.0, 2.0)
    y: tuple[float, float] = (0.0, 1.0)
    cells: tuple[int, int] = (3, 2)
    flaw: str = ""
    calls: ClassVar[Any] = itertools.count()

    def mesh(self, element: Element, level: int) -> Mesh:
        right = super().mesh(element, 2 if self.flaw == "level ignored" else level)
        edges = dict(right.edges)
        if self.flaw == "clockwise":
            return replace(right, cells=np.ascontiguousarray(right.cells[:, ::-1]))
        if self.flaw == "a node too many":
            return replace(right, nodes=np.concatenate([right.nodes, [[9.0, 9.0]]]))
        if self.flaw == "top turned round":
            edges["top"] = edges["top"][:, ::-1]
        if self.flaw == "an edge inside":
            edges["middle"] = right.cells[:1, 1:3]
        if self.flaw == "left has no name":
            del edges["left"]
        if self.flaw == "no names":
            edges = {}
        shift = 1e-9 * next(self.calls) if self.flaw == "creeps" else 0.0
        shift += 0.01 if self.flaw == "has a length of its own" else 0.0
        return replace(right, nodes=right.nodes + shift, edges=edges)


@dataclass(frozen=True)
class Half(Flawed):
    """Is moved along y alone."""

    at: tuple[float, float] = (1.0, 1.0)

    def mesh(self, element: Element, level: int) -> Mesh:
        right = super().mesh(element, level)
        return replace(right, nodes=right.nodes + np.array([0.0, self.at[1]]))


@pytest.mark.parametrize("check", mesh.CHECKS)
def test_a_right_mesh_passes(check: Check) -> None:
    check(Flawed())


WRONG: list[tuple[Check, Flawed]] = [
    (mesh.cells_are_sound, Flawed(flaw="clockwise")),
    (mesh.cells_are_sound, Flawed(flaw="a node too many")),
    (mesh.edges_are_the_boundary, Flawed(flaw="top turned round")),
    (mesh.edges_are_the_boundary, Flawed(flaw="an edge inside")),
    (mesh.edges_are_the_boundary, Flawed(flaw="no names")),
    (mesh.level_multiplies_cells, Flawed(flaw="level ignored")),
    (mesh.the_boundary_is_named, Flawed(flaw="left has no name")),
    (mesh.points_move_as_a_whole, Half()),
    (mesh.same_mesh_twice, Flawed(flaw="creeps")),
    (mesh.units_do_not_matter, Flawed(flaw="has a length of its own")),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
def test_wrong_meshes_are_caught(caught: Any, check: Check, part: Flawed) -> None:
    caught(check, part)


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} == set(mesh.CHECKS)


class TestOutcomes:
    """What a report of checks is made of."""

    def test_all_checks_of_a_right_part_pass(self) -> None:
        outcomes = run_checks("mesh", Flawed())
        assert [o.status for o in outcomes] == ["passed"] * len(mesh.CHECKS)
        assert [o.reason for o in outcomes] == [""] * len(mesh.CHECKS)

    def test_a_part_that_raises_has_failed(self) -> None:
        outcome = run_check(mesh.cells_are_sound, object())
        assert outcome.status == "failed"
        assert "AttributeError" in outcome.reason

    def test_kinds_without_checks_have_none(self) -> None:
        assert checks_for("viewer") == ()
