"""Meshes from files: what is written is what is read, with names, levels and other elements."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from contactlab_quads.q1 import Q1
from contactlab_quads.q2 import Q2
from contactlab_quads.q2_lagrange import Q2Lagrange

from contactlab.api import Mesh
from contactlab.errors import SceneError
from contactlab.meshing import Disc, MeshFile, QuadBlock, room
from contactlab.meshing.mesh import nodal_measure
from contactlab.scene.scene import load_scene
from contactlab.scene.toml_text import write_toml
from contactlab.testing.mesh import CHECKS

DISC = Disc(2.0, (4, 3))


def physical(mesh: Mesh, names: dict[str, int]) -> dict:
    """Arguments of a Gmsh file: quads of the group disc, lines of groups named like the edge sets."""
    blocks = [("quad", mesh.cells), *(("line", mesh.edges[name][:, :2]) for name in names)]
    tags = [np.full(len(mesh.cells), 9), *(np.full(len(mesh.edges[n]), tag) for n, tag in names.items())]
    fields = {"disc": np.array([9, 2]), **{name: np.array([tag, 1]) for name, tag in names.items()}}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    return {"cells": blocks, "cell_data": data, "field_data": fields}


def flat(nodes: np.ndarray) -> np.ndarray:
    return np.column_stack([nodes, np.zeros(len(nodes))])


@pytest.fixture
def gmsh(tmp_path: Path) -> Path:
    mesh = DISC.mesh(Q1(), 1)
    path = tmp_path / "disc.msh"
    written = meshio.Mesh(flat(mesh.nodes), **physical(mesh, {"right": 1, "top": 2}))
    meshio.write(path, written, file_format="gmsh22")
    return path


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_a_mesh_from_a_file_is_sound(gmsh: Path, check) -> None:
    check(MeshFile(gmsh))


def places(mesh: Mesh, name: str) -> set[tuple[float, ...]]:
    ends = mesh.nodes[mesh.edges[name][:, :2]].reshape(-1, 4)
    return {tuple(row) for row in ends.round(9).tolist()}


def test_names_of_physical_groups_are_edge_sets(gmsh: Path) -> None:
    read, made = MeshFile(gmsh, cells="disc").mesh(Q1(), 1), DISC.mesh(Q1(), 1)
    assert set(read.edges) == {"boundary", "right", "top"}
    for name, twin in (("right", "right"), ("top", "top"), ("boundary", "arc")):
        assert places(read, name) == places(made, twin)


def test_lines_written_backwards_have_the_body_on_their_left(tmp_path: Path) -> None:
    mesh = DISC.mesh(Q1(), 1)
    turned = Mesh(mesh.nodes, mesh.cells[:, ::-1], {"right": mesh.edges["right"][:, ::-1]})
    path = tmp_path / "turned.msh"
    meshio.write(path, meshio.Mesh(flat(turned.nodes), **physical(turned, {"right": 1})), file_format="gmsh22")
    assert places(MeshFile(path).mesh(Q1(), 1), "right") == places(mesh, "right")


@pytest.mark.parametrize(("kind", "element"), [("quad8", Q2()), ("quad9", Q2Lagrange())])
def test_curved_cells_stay_curved_at_every_level(tmp_path: Path, kind: str, element) -> None:
    """Halving a parabola gives the same parabola: the area does not change with the level."""
    mesh = QuadBlock(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)), (3, 2), (0.3, 0.0, 0.2, 0.0)).mesh(element, 1)
    path = tmp_path / "curved.vtu"
    meshio.write(path, meshio.Mesh(flat(mesh.nodes), [(kind, mesh.cells)]))
    areas = [nodal_measure(MeshFile(path).mesh(Q2Lagrange(), level), Q2Lagrange()).sum() for level in (1, 2, 3)]
    assert areas == pytest.approx([areas[0]] * 3, rel=1e-12)
    assert areas[0] == pytest.approx(nodal_measure(mesh, element).sum(), rel=1e-12)


def test_sets_of_points_hold_sides(tmp_path: Path) -> None:
    mesh = QuadBlock(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)), (3, 2)).mesh(Q1(), 1)
    path = tmp_path / "sets.inp"
    held = np.unique(mesh.edges["top"])
    meshio.write(path, meshio.Mesh(flat(mesh.nodes), [("quad", mesh.cells)], point_sets={"lid": held}))
    assert places(MeshFile(path, scale=2.0).mesh(Q1(), 1), "lid") == {
        tuple(row) for row in (2.0 * mesh.nodes[mesh.edges["top"][:, :2]].reshape(-1, 4)).round(9).tolist()
    }


def test_what_is_no_plane_mesh_of_quadrilaterals_is_refused(tmp_path: Path, gmsh: Path) -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]])
    meshio.write(tmp_path / "t.vtu", meshio.Mesh(points * [1.0, 1.0, 0.0], [("triangle", np.array([[0, 1, 2]]))]))
    meshio.write(tmp_path / "z.vtu", meshio.Mesh(points, [("quad", np.array([[0, 1, 2, 3]]))]))
    (tmp_path / "x.foo").write_text("no mesh")
    for path, group, word in (
        (tmp_path / "t.vtu", "", "recombine"),
        (tmp_path / "z.vtu", "", "not plane"),
        (tmp_path / "x.foo", "", "cannot read"),
        (gmsh, "ring", "disc"),
    ):
        with pytest.raises(ValueError, match=word):
            MeshFile(path, cells=group).mesh(Q1(), 1)


def test_paths_start_from_the_folder_of_the_scene(gmsh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = gmsh.parent / "scene.toml"
    data = load_scene("disc-on-block").with_({"contacts": []}).data
    data["bodies"]["disc"]["mesh"] = {"use": "file", "path": "disc.msh"}
    file.write_text(write_toml(data))
    monkeypatch.chdir("/")
    assert load_scene(file).data["bodies"]["disc"]["mesh"]["path"] == str(gmsh)
    data["bodies"]["disc"]["mesh"]["path"] = "other.msh"
    file.write_text(write_toml(data))
    with pytest.raises(SceneError, match="not allowed") as caught:
        load_scene(file)
    assert "bodies.disc.mesh.path" in str(caught.value)
    assert "other.msh" in str(caught.value)


@pytest.mark.parametrize("node", [-1, 15, 10**9])
def test_cells_of_nodes_that_are_not_there_are_refused(tmp_path: Path, node: int) -> None:
    """A negative number used to be counted from the end, in silence."""
    mesh = QuadBlock(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)), (4, 2)).mesh(Q1(), 1)
    cells = mesh.cells.copy()
    cells[3, 1] = node
    meshio.write(tmp_path / "lost.vtu", meshio.Mesh(flat(mesh.nodes), [("quad", cells)]))
    with pytest.raises(ValueError, match="in cell 3, allowed: the 15 nodes"):
        MeshFile(tmp_path / "lost.vtu").mesh(Q1(), 1)


def test_a_file_too_large_for_the_machine_is_refused_before_it_is_cut(
    gmsh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ValueError, match=r"64 cells at level 1000000, 6.4e.13 cells: about .* GiB, allowed: what fits"):
        MeshFile(gmsh).mesh(Q1(), 1_000_000)
    monkeypatch.setattr(room, "machine_memory", lambda: 1000.0)
    with pytest.raises(ValueError, match=r"path: got disc.msh: about .* allowed: what fits"):
        MeshFile(gmsh).mesh(Q1(), 1)


def test_what_is_wrong_with_a_file_is_told_at_its_key(gmsh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from contactlab.model.build import build

    monkeypatch.setattr(room, "machine_memory", lambda: 1000.0)
    scene = load_scene("disc-on-block").with_({"bodies.disc.mesh": {"use": "file", "path": str(gmsh)}})
    with pytest.raises(SceneError) as caught:
        build(scene, scene.registry)
    assert "bodies.disc.mesh.path" in str(caught.value)
    assert caught.value.allowed.startswith("what fits")
