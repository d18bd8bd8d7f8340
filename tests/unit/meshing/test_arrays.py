"""Meshes from arrays, grids and gmsh models: the same as from a file, and kept in the scene."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contactlab_quads.q1 import Q1

import contactlab
from contactlab.errors import RequestError
from contactlab.meshing import MeshArrays
from contactlab.scene.scene import load_scene


def block(nx: int = 4, ny: int = 2, width: float = 1.8, bottom: float = -0.3) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.meshgrid(np.linspace(-0.5 * width, 0.5 * width, nx + 1), np.linspace(bottom, 0.0, ny + 1))
    first = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    return np.column_stack([x.ravel(), y.ravel()]), np.column_stack([first, first + 1, first + nx + 2, first + nx + 1])


def made(spec: dict[str, Any], level: int = 1) -> Any:
    return MeshArrays(spec["content"]).mesh(Q1(), level)


@pytest.mark.parametrize("level", [1, 2])
def test_edge_sets_however_they_are_given(level: int) -> None:
    points, cells = block()
    top = [[10 + k, 11 + k] for k in range(4)]
    mask = points[:, 1] > -1e-9
    sets = {"edges": top, "numbers": [10, 11, 12, 13, 14], "mask": mask, "function": lambda p: p[:, 1] >= 0.0}
    mesh = made(contactlab.mesh(points, cells, sets), level)
    for name in sets:
        assert sorted(map(tuple, mesh.nodes[mesh.edges[name]].reshape(-1, 4))) == sorted(
            map(tuple, mesh.nodes[mesh.edges["edges"]].reshape(-1, 4))
        )
        assert len(mesh.edges[name]) == 4 * level
    assert len(mesh.cells) == 8 * level**2
    assert len(mesh.edges["boundary"]) == 12 * level


def test_a_run_needs_no_file_and_its_scene_reproduces_it(tmp_path: Path) -> None:
    points, cells = block(12, 2)
    mesh = contactlab.mesh(points, cells, {"top": points[:, 1] >= 0.0, "bottom": lambda p: p[:, 1] < -0.299})
    same = {"bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "supports.1.uy.to": -0.01,
            "integrator": "newton"}  # fmt: skip
    scene = load_scene("disc-on-block").with_(same, level=1)
    own = scene.with_({"bodies.block.mesh": mesh})
    first = contactlab.simulate(own, out=tmp_path / "one")
    assert first.status == "finished"
    again = contactlab.simulate(tmp_path / "one/scene.toml", out=tmp_path / "two")
    assert np.array_equal(again.displacement, first.displacement)
    force = contactlab.simulate(scene).summary["reactions"]["disc.top"][1]
    assert first.summary["reactions"]["disc.top"][1] == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"cells": None}, "cells are needed"),
        ({"cells": [[0, 1, 6]]}, "triangle"),
        ({"cells": [[0, 1, 99, 98]]}, "node 99"),
        ({"sets": {"top": [99]}}, "node 99"),
        ({"sets": {"top": [True, False]}}, "a mask of shape"),
        ({"sets": {"top": np.zeros((2, 2, 2), int)}}, "edges \\(k, 2\\) or nodes"),
        ({"cells": [[0, 1]]}, "cells of shape"),
        ({"cells": [[0, 1, 4, 3, 0, 0, 0, 0]]}, "mesh: got node 0 twice in cell 0"),
        ({"points": np.full((6, 2), np.nan)}, "not finite"),
        ({"sets": {"top": lambda x: x[:, 1] > 99.0}}, 'edge set "top" holds no side'),
        ({"sets": {"top": [[0, 4]]}}, 'edge set "top" holds no side'),
    ],
)
def test_what_is_wrong_is_said(arguments: dict[str, Any], said: str) -> None:
    points, cells = block()
    with pytest.raises(RequestError, match=said):
        contactlab.mesh(**{"points": points, "cells": cells, **arguments})


def test_content_that_is_no_mesh() -> None:
    with pytest.raises(ValueError, match=r"contactlab\.mesh writes"):
        MeshArrays("AAAA")


def test_a_grid_of_pyvista() -> None:
    pyvista = pytest.importorskip("pyvista")
    points, cells = block()
    grid = pyvista.UnstructuredGrid({pyvista.CellType.QUAD: cells}, np.column_stack([points, np.zeros(len(points))]))
    mesh = made(contactlab.mesh(grid, sets={"top": lambda p: p[:, 1] >= 0.0}))
    assert len(mesh.cells) == 8
    assert len(mesh.edges["top"]) == 4


class Model:
    """What is asked of a gmsh model: two squares beside each other, the right one named "right", tags from 11."""

    def __init__(self) -> None:
        self.mesh = SimpleNamespace(getNodes=self._nodes, getElements=self._elements)

    def _nodes(self) -> Any:
        x = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)]
        return np.arange(11, 17), np.array([[*p, 0] for p in x], float).ravel(), []

    def _elements(self, dimension: int, entity: int) -> Any:
        if dimension == 2:
            return [3], [np.array([entity])], [np.array([[11, 12, 13, 14], [12, 15, 16, 13]][entity - 1])]
        return [1], [np.array([9])], [np.array([13, 16])]

    def getPhysicalGroups(self, dimension: int) -> list[tuple[int, int]]:
        return [(2, 5)] if dimension == 2 else [(1, 7)]

    def getPhysicalName(self, dimension: int, tag: int) -> str:
        return {5: "right", 7: "lid"}[tag]

    def getEntitiesForPhysicalGroup(self, dimension: int, tag: int) -> list[int]:
        return [2] if dimension == 2 else [3]

    def getEntities(self, dimension: int) -> list[tuple[int, int]]:
        return [(2, 1), (2, 2)]


def test_the_module_of_gmsh_stands_for_its_model() -> None:
    assert contactlab.mesh(SimpleNamespace(model=Model()), "right") == contactlab.mesh(Model(), "right")


def test_the_name_of_a_file_is_answered_with_the_key_of_a_scene() -> None:
    with pytest.raises(RequestError, match=r'mesh = \{ use = "file", path = "clip\.msh" \}'):
        contactlab.mesh("clip.msh")


def test_a_model_of_gmsh() -> None:
    mesh = made(contactlab.mesh(Model(), "right"))
    assert len(mesh.cells) == 1
    assert mesh.nodes[mesh.edges["lid"]].tolist() == [[[2.0, 1.0], [1.0, 1.0]]]
    whole = made(contactlab.mesh(Model()))
    assert len(whole.cells) == 2
    with pytest.raises(RequestError, match='did you mean "right"'):
        contactlab.mesh(Model(), "rigth")


def test_a_refusal_shows_the_edge_sets_as_they_were_given() -> None:
    points, cells = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, np.nan]], [[0, 1, 2, 3]]
    sets = {"bottom": [True, True, False, False]}
    with pytest.raises(RequestError) as refused:
        contactlab.mesh(points, cells, sets)
    assert refused.value.got == [points, cells, sets]
