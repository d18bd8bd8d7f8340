"""Open meshes are refused with their place, slits that are meant are not, and thin bodies are no slits."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from contactlab_quads.q1 import Q1

from contactlab.api import Element, Mesh
from contactlab.api.meshing import structured
from contactlab.errors import SceneError
from contactlab.meshing.mesh import outer_sides
from contactlab.meshing.slits import check_closed, points_in_boxes
from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

WHERE = "bodies.b.mesh"
Place = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@pytest.fixture(params=["q1", "q2"])
def element(request: pytest.FixtureRequest) -> Element:
    made: Element = default_registry().make("element", request.param)
    return made


def block(element: Element, cells: tuple[int, int], x: tuple[float, float], place: Place | None = None) -> Mesh:
    """A structured block with y from 0 to 1; `place` bends it."""

    def at(s: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        along = x[0] + s * (x[1] - x[0])
        return place(along, t) if place else (along, t)

    return structured(element, cells, at)


def beside(left: Mesh, right: Mesh, digits: int = 12, joined: str = "ends") -> Mesh:
    """Two blocks as one mesh; of nodes on each other those named are one node: `ends` of the line, `all` or none."""
    nodes = np.round(np.concatenate([left.nodes, right.nodes]), digits)
    first = len(left.nodes)
    cells = np.concatenate([left.cells, right.cells + first])
    edges = {
        f"{side} {name}": e + shift
        for side, m, shift in (("l", left, 0), ("r", right, first))
        for name, e in m.edges.items()
    }
    line, other = np.unique(edges["l right"]), np.unique(edges["r left"])
    apart = np.hypot(*(nodes[line][:, None] - nodes[other]).transpose(2, 0, 1))
    pairs = [(line[i], other[j]) for i, j in np.argwhere(apart < 0.5 * 10.0**-digits)]
    ends = line[[nodes[line, 1].argmin(), nodes[line, 1].argmax()]]
    number = np.arange(len(nodes))
    for kept, gone in pairs:
        if joined == "all" or (joined == "ends" and kept in ends):
            number[gone] = kept
    return Mesh(nodes, number[cells], {name: number[e] for name, e in edges.items()})


def test_a_closed_mesh_is_closed(element: Element) -> None:
    whole = beside(block(element, (3, 4), (0.0, 1.0)), block(element, (2, 4), (1.0, 2.0)), joined="all")
    check_closed(whole, element, [], WHERE)


def test_nodes_on_nodes_are_refused_with_their_number_and_place(element: Element) -> None:
    doubled = beside(block(element, (4, 4), (0.0, 1.0)), block(element, (4, 4), (1.0, 2.0)))
    count = 2 * (len(np.unique(doubled.edges["l right"])) - 2)  # both nodes of each place but the ends
    with pytest.raises(SceneError) as refused:
        check_closed(doubled, element, [], WHERE)
    first = 2.0 / (count + 2)
    for word in (
        WHERE,
        f"{count} coincide with other nodes",
        f"from (1, {first}) to (1, {1 - first})",
        "removeDuplicateNodes",
    ):
        assert word in str(refused.value)


def test_a_single_doubled_node_is_found(element: Element) -> None:
    """Cells on its right use a copy of one corner in the middle of a block."""
    whole = block(element, (4, 4), (0.0, 1.0))
    at = int(np.flatnonzero((np.abs(whole.nodes - (0.5, 0.5)) < 1e-9).all(axis=1))[0])
    cells = whole.cells.copy()
    right = whole.nodes[cells].mean(axis=1)[:, 0] > 0.5
    cells[right[:, None] & (cells == at)] = len(whole.nodes)
    opened = Mesh(np.vstack([whole.nodes, whole.nodes[at]]), cells, whole.edges)
    with pytest.raises(SceneError, match=r"2 coincide with other nodes, from \(0.5, 0.5\) to \(0.5, 0.5\)"):
        check_closed(opened, element, [], WHERE)


@pytest.mark.parametrize("ratio", [(4, 8), (4, 12), (3, 4)], ids=str)
@pytest.mark.parametrize("digits", [3, 4, 12])
def test_hanging_nodes_are_refused(element: Element, ratio: tuple[int, int], digits: int) -> None:
    """Also where coordinates were written with few digits, and where divisions have nothing in common."""
    mesh = beside(block(element, (2, ratio[0]), (0.0, 1.0)), block(element, (2, ratio[1]), (1.0, 2.0)), digits, "all")
    with pytest.raises(SceneError, match="hanging nodes on sides"):
        check_closed(mesh, element, [], WHERE)


@pytest.mark.parametrize("degrees", [10.0, 40.0, 80.0])
def test_hanging_nodes_on_a_curve_are_refused(element: Element, degrees: float) -> None:
    """They lie beside the sides of the coarse cells by the depth of its facets: 4 cells on so many degrees."""

    def bent(radius: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        angle = np.radians(degrees) * t
        return radius * np.cos(angle), radius * np.sin(angle)

    size = np.radians(degrees) / 4.0  # square cells
    for ratio in (8, 6, 4):
        coarse = block(element, (2, 4), (1.0 - 2.0 * size, 1.0), bent)
        fine = block(element, (2, ratio), (1.0, 1.0 + size), bent)
        with pytest.raises(SceneError):
            check_closed(beside(coarse, fine), element, [], WHERE)


def test_a_slit_that_a_contact_joins_is_meant(element: Element) -> None:
    """From either side; other sets of the same body do not help."""
    mesh = beside(block(element, (4, 4), (0.0, 1.0)), block(element, (4, 8), (1.0, 2.0)))
    for pair in ((["l right"], ["r left"]), (["r left", "r top"], ["l top", "l right"])):
        check_closed(mesh, element, [pair], WHERE)
    for pair in ((["l right"], ["l right"]), (["l right"], ["r top"]), (["l right"], []), (["l right"], ["none"])):
        with pytest.raises(SceneError):
            check_closed(mesh, element, [pair], WHERE)


def test_a_gap_is_no_slit(element: Element) -> None:
    """3 % of a cell wide, joined at nothing but a bridge."""
    left, right = block(element, (4, 4), (0.0, 1.0)), block(element, (4, 4), (1.0075, 2.0))
    check_closed(beside(left, right), element, [], WHERE)


@pytest.mark.parametrize("thickness", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("layers", [1, 2, 5])
@pytest.mark.parametrize("degrees", [0.0, 60.0, 300.0])
def test_thin_bodies_are_no_slits(element: Element, thickness: float, layers: int, degrees: float) -> None:
    """Sheets and shells, coarse along the curve, a hundred thousand times as long as they are thick."""

    def bent(along: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if degrees == 0.0:
            return along, thickness * t
        angle = np.radians(degrees) * (1.0 - along)
        return (1.0 + thickness * t) * np.cos(angle), (1.0 + thickness * t) * np.sin(angle)

    check_closed(block(element, (10, layers), (0.0, 1.0), bent), element, [], WHERE)


def test_a_sharp_notch_and_a_sharp_edge_are_no_slits(element: Element) -> None:
    """A wedge of 2 degrees, and the space of 4 degrees between two halves joined at a point."""
    slope = np.tan(np.radians(2.0))
    check_closed(block(element, (6, 2), (0.02, 1.0), lambda x, t: (x, slope * x * t)), element, [], WHERE)
    left = block(element, (4, 4), (0.0, 1.0), lambda x, t: (x - slope * t * x, t))
    right = block(element, (4, 4), (1.0, 2.0), lambda x, t: (x + slope * t * (2.0 - x), t))
    mesh = beside(left, right)
    assert len(np.unique(mesh.cells)) == len(left.nodes) + len(right.nodes) - 1  # it does share the node of the notch
    check_closed(mesh, element, [], WHERE)


def test_points_in_boxes_are_those_of_comparing_all() -> None:
    random = np.random.default_rng(3)
    points = random.random((400, 2)) * (5.0, 0.1)
    low = random.random((300, 2)) * (5.0, 0.1) - 0.05
    high = low + 10.0 ** random.uniform(-6.0, 0.5, (300, 2))
    point, box = points_in_boxes(points, low, high)
    inside = ((points[:, None] >= low) & (points[:, None] <= high)).all(axis=2)
    assert {*zip(point.tolist(), box.tolist(), strict=True)} == {*map(tuple, np.argwhere(inside).tolist())}
    assert len(point) == inside.sum() > 500


def test_pairs_looked_at_grow_with_the_sides_alone() -> None:
    """A straight side of many cells: each middle meets its own side and its two neighbours, whatever their number."""
    for cells in (100, 10_000):
        x = np.linspace(0.0, 1.0, cells + 1)
        nodes = np.stack([x, np.zeros(cells + 1)], axis=1)
        low, high = nodes[:-1] - 0.26 / cells, nodes[1:] + 0.26 / cells
        assert len(points_in_boxes(0.5 * (nodes[1:] + nodes[:-1]), low, high)[0]) <= 3 * cells


def test_cells_of_sides(element: Element) -> None:
    mesh = block(element, (3, 2), (0.0, 1.0))
    sides, cells = outer_sides(mesh.cells, element)
    assert all(np.isin(side, mesh.cells[cell]).all() for side, cell in zip(sides, cells, strict=True))


def test_a_file_with_a_slit_is_a_scene_with_a_contact(tmp_path: Path) -> None:
    """Refused as it is; with a contact across the slit it is as stiff against compression as a whole block.

    Uniform strain without Poisson's effect: E times 0.02 / 2 over a height of 1, exact for mortars but for round-off.
    """
    mesh = beside(block(Q1(), (4, 4), (0.0, 1.0)), block(Q1(), (4, 6), (1.0, 2.0)))
    tags = {"l left": 1, "l right": 2, "r left": 3, "r right": 4}
    cells = [("quad", mesh.cells), *(("line", mesh.edges[name]) for name in tags)]
    data = [np.full(len(mesh.cells), 9), *(np.full(len(mesh.edges[name]), tag) for name, tag in tags.items())]
    meshio.write(
        tmp_path / "slit.msh",
        meshio.Mesh(
            np.column_stack([mesh.nodes, np.zeros(len(mesh.nodes))]), cells,
            cell_data={"gmsh:physical": data, "gmsh:geometrical": data},
            field_data={name: np.array([tag, 1]) for name, tag in tags.items()},
        ),
        file_format="gmsh22",
    )  # fmt: skip
    held = {"ux": 0.0, "uy": 0.0}
    scene: dict[str, Any] = {
        "format": 1,
        "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
        "bodies": {
            "b": {"element": "q1", "material": "m", "mesh": {"use": "file", "path": str(tmp_path / "slit.msh")}}
        },
        "supports": [{"on": "b.l left", **held}, {"on": "b.r right", "ux": {"ramp": "linear", "to": -0.02}, "uy": 0.0}],
        "record": {"recorders": []},
    }
    with pytest.raises(SceneError, match=r"bodies\.b\.mesh: the mesh has a slit inside"):
        simulate(Scene.from_data(scene))
    contact = {"slave": "b.l right", "master": "b.r left", "algorithm": "mortar-p1"}
    results = simulate(Scene.from_data(scene | {"contacts": [contact]}))
    assert results.summary["reactions"]["b.r right"][0] == pytest.approx(-10.0, rel=1e-6)
