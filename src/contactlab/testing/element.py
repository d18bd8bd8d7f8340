"""Checks of elements."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np

from contactlab.api import Element, Floats, Ints, Kinematics
from contactlab.meshing.mesh import cell_measures, jacobians
from contactlab.testing.assertions import Check, NotApplicable, agree, identical, require, untouched
from contactlab.testing.cells import Cells, cell_stiffness, distorted_cells, gauss

KINEMATICS: tuple[Kinematics, ...] = get_args(Kinematics)
ROUND_OFF = 1e-12  # some thousand roundings of numbers of order one


def _points(count: int = 20) -> Floats:
    return np.random.default_rng(2).uniform(-1.0, 1.0, (count, 2))


def reference_nodes(element: Element) -> None:
    """Nodes lie in the reference square, corners first and counter-clockwise."""
    nodes = np.asarray(element.nodes)
    require(nodes.ndim == 2 and nodes.shape[1] == 2, f"nodes: shape {nodes.shape}, expected (a, 2)")
    require(np.all(np.abs(nodes) <= 1.0), "nodes: some lie outside [-1, 1]^2")
    corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
    agree(nodes[:4], corners, 0.0, "the first four nodes are the corners, counter-clockwise from (-1, -1)")
    require(len({tuple(node) for node in nodes.tolist()}) == len(nodes), "nodes: two of them coincide")


def edges_of_the_cell(element: Element) -> None:
    """Each side is listed once with all its nodes, start to end with the cell on the left."""
    nodes = np.asarray(element.nodes)
    require(len(element.edges) == 4, f"edges: {len(element.edges)} of them, expected one per side")
    seen = set()
    for edge in element.edges:
        start, end = nodes[edge[0]], nodes[edge[1]]
        along = end - start
        left = np.array([-along[1], along[0]])
        require(np.hypot(*along) == 2.0, f"edge {edge}: its first two nodes are not the ends of a side")
        require(left @ -start > 0.0, f"edge {edge}: the cell lies on its right; reverse the edge")
        on_side = {k for k, node in enumerate(nodes) if left @ (node - start) == 0.0}
        require(on_side == set(edge), f"edge {edge}: the nodes on this side are {sorted(on_side)}")
        seen.add(frozenset(edge))
    require(len(seen) == 4, "edges: a side is listed twice")


def tables_are_of_their_types(element: Element) -> None:
    """Shape functions, gradients, points, weights and nodes are arrays of float64."""
    shape, rule, trace = element.shape(_points()), element.quadrature(), element.edge_shape(np.linspace(-1.0, 1.0, 5))
    tables = {
        "nodes": element.nodes, "shape: values": shape[0], "shape: gradient": shape[1],
        "quadrature: points": rule.points, "quadrature: weights": rule.weights,
        "edge_shape: values": trace[0], "edge_shape: derivatives": trace[1],
    }  # fmt: skip
    for name, table in tables.items():
        require(isinstance(table, np.ndarray), f"{name}: got {type(table).__name__}, needed an array of float64")
        require(table.dtype == np.float64, f"{name}: got an array of {table.dtype}, needed float64")


def partition_of_unity(element: Element) -> None:
    """Shape functions sum to one and their gradients to zero."""
    value, gradient = element.shape(_points())
    agree(value.sum(axis=1), np.ones(len(value)), ROUND_OFF, "sum of the shape functions")
    agree(gradient.sum(axis=1), np.zeros((len(value), 2)), ROUND_OFF, "sum of their gradients")


def delta_property(element: Element) -> None:
    """Each shape function is one at its own node and zero at the others."""
    agree(element.shape(np.asarray(element.nodes)).value, np.eye(len(element.nodes)), ROUND_OFF, "shape at the nodes")


def gradient_is_the_derivative(element: Element) -> None:
    """Gradients are the derivatives of the values."""
    points, step = _points(), 1e-4
    _, gradient = element.shape(points)
    for i in range(2):
        shift = np.zeros(2)
        shift[i] = step
        # fourth-order differences: exact for polynomials up to degree four, so only round-off / step is left
        near = element.shape(points + shift).value - element.shape(points - shift).value
        far = element.shape(points + 2 * shift).value - element.shape(points - 2 * shift).value
        expected = (8.0 * near - far) / (12.0 * step)
        agree(gradient[..., i], expected, 1e-10, f"derivative by coordinate {i} against differences")


def complete_to_its_degree(element: Element) -> None:
    """Polynomials up to `degree` are reproduced, as the promised rate of convergence requires."""
    points, nodes = _points(), np.asarray(element.nodes)
    value = element.shape(points).value
    for i in range(element.degree + 1):
        for j in range(element.degree + 1 - i):
            exact = points[:, 0] ** i * points[:, 1] ** j
            interpolated = value @ (nodes[:, 0] ** i * nodes[:, 1] ** j)
            agree(interpolated, exact, ROUND_OFF, f"degree is {element.degree}: interpolant of xi^{i} eta^{j}")


def quadrature_exactness(element: Element) -> None:
    """The rule integrates degree 2 p - 1 exactly in each direction, p = `degree`, as optimal rates need."""
    points, weights = element.quadrature()
    require(np.all(np.abs(points) <= 1.0), "quadrature: a point lies outside the reference square")
    highest = max(1, 2 * element.degree - 1)
    for i in range(highest + 1):
        for j in range(highest + 1):
            exact = (1 - i % 2) * 2.0 / (i + 1) * (1 - j % 2) * 2.0 / (j + 1)
            agree(weights @ (points[:, 0] ** i * points[:, 1] ** j), exact, ROUND_OFF, f"integral of xi^{i} eta^{j}")


def trace_is_the_shape(element: Element) -> None:
    """The edge's own functions are the shape functions on a side, and all others vanish there."""
    s = np.linspace(-1.0, 1.0, 7)
    nodes = np.asarray(element.nodes)
    value, derivative = element.edge_shape(s)
    for edge in element.edges:
        start, end = nodes[edge[0]], nodes[edge[1]]
        on_edge = 0.5 * np.outer(1.0 - s, start) + 0.5 * np.outer(1.0 + s, end)
        shape = element.shape(on_edge)
        agree(value, shape.value[:, edge], ROUND_OFF, f"edge_shape on edge {edge}")
        agree(
            derivative,
            shape.gradient[:, edge] @ (0.5 * (end - start)),
            ROUND_OFF,
            f"derivative of edge_shape, edge {edge}",
        )
        others = [k for k in range(len(nodes)) if k not in edge]
        agree(shape.value[:, others], np.zeros((len(s), len(others))), ROUND_OFF, f"other nodes' shapes on edge {edge}")


def linear_field_is_exact(element: Element) -> None:
    """The kernels give the exact gradient of a linear field on distorted cells, for laws of all kinematics."""
    imposed = np.array([[0.3, -1.1], [0.7, 0.4]])
    for kinematics in KINEMATICS:
        cells = distorted_cells(element, 7, kinematics=kinematics)
        got = cells.gradient(cells.nodes @ imposed.T)
        expected = np.repeat(imposed.reshape(4, 1), cells.points, axis=1)
        agree(got, expected, 1e-11, f"{kinematics}: gradient of a linear field (round-off over half sides of 0.4)")


def constant_stress_is_balanced(element: Element) -> None:
    """A constant stress gives the exact nodal forces, without resultant and without moment."""
    for kinematics in KINEMATICS:
        cells = distorted_cells(element, 7, kinematics=kinematics)
        stress = np.repeat(np.array([[1.3], [-0.4], [0.2], [0.9]]), cells.points, axis=1)
        force = cells.force(stress)
        exact = _exact_force(element, cells.nodes, cells.connectivity, stress[:, 0])
        agree(force, exact, 1e-11, f"{kinematics}: nodal forces")
        by_cell, x = force[cells.connectivity], cells.nodes[cells.connectivity]
        agree(by_cell.sum(axis=0), np.zeros((7, 2)), 1e-11, f"{kinematics}: resultant of a cell")
        moment = (x[..., 0] * by_cell[..., 1] - x[..., 1] * by_cell[..., 0]).sum(axis=0)
        agree(moment, np.zeros(7), 1e-10, f"{kinematics}: moment of a cell (lever arms up to 7)")


def _exact_force(element: Element, nodes: Floats, connectivity: Ints, stress: Floats) -> Floats:
    """Integral of grad N . stress by a fine rule."""
    points, weights = gauss()
    derivatives = element.shape(points).gradient
    tensor = np.array([[stress[0], stress[3]], [stress[3], stress[1]]])
    x = nodes[connectivity.T]
    j = np.einsum("qak,nai->nqik", derivatives, x)
    gradient = np.einsum("qak,nqki->nqai", derivatives, np.linalg.inv(j))
    by_cell = np.einsum("q,nq,nqai,ij->naj", weights, np.linalg.det(j), gradient, tensor)
    force = np.zeros_like(nodes)
    np.add.at(force, connectivity.T, by_cell)
    return force


def rigid_motion_is_free(element: Element) -> None:
    """Exactly three modes of a cell, the rigid ones, give no force."""
    for seed in range(3):
        cell = distorted_cells(element, 1, seed=seed)
        stiffness = cell_stiffness(cell)
        largest = np.linalg.norm(stiffness, 2)
        x, y = cell.nodes[:, 0] - cell.nodes[:, 0].mean(), cell.nodes[:, 1] - cell.nodes[:, 1].mean()
        for name, mode in {"x": (x**0, 0 * x), "y": (0 * x, x**0), "rotation": (-y, x)}.items():
            force = stiffness @ np.stack(mode, axis=1).ravel()
            agree(force, np.zeros_like(force), 1e-11 * float(largest), f"force of a rigid motion ({name})")
        free = int(np.count_nonzero(np.linalg.svd(stiffness, compute_uv=False) < 1e-10 * largest))
        require(free == 3, f"{free} modes of a cell give no force, expected the 3 rigid ones")


def lumped_mass(element: Element) -> None:
    """Every node of a distorted cell has positive mass, and they sum to the area."""
    cells = distorted_cells(element, 20)
    measures = cell_measures(cells.mesh, element)
    require(np.all(measures > 0.0), f"lumping {element.lumping!r} gives a node zero or negative mass")
    points, weights = gauss()
    area = jacobians(cells.mesh, element, points) @ weights
    agree(measures.sum(axis=1) / area, np.ones(20), 1e-10, "lumped mass over density times area")


def forces_are_added(element: Element) -> None:
    """The force kernel adds to the array, also if cells share nodes, and changes no other node."""
    cells = distorted_cells(element, 3)
    q, a = len(element.quadrature().weights), len(element.nodes)
    stress = np.random.default_rng(3).normal(size=(4, q))
    first = cells.part(0, 1)
    single = first.force(stress)
    agree(single[a:], np.zeros((2 * a, 2)), 0.0, "forces on nodes of other cells")
    twice = replace(first, connectivity=np.ascontiguousarray(np.repeat(first.connectivity, 2, axis=1)))
    agree(twice.force(np.repeat(stress, 2, axis=1)), 2.0 * single, 1e-12, "two cells on the same nodes")
    total = np.ones_like(cells.nodes)
    first.add_force(stress, total)
    agree(total - 1.0, single, 1e-12, "force kernel with forces already there")


def stabilisation_sees_no_linear_field(element: Element) -> None:
    """Stabilising forces vanish for every linear displacement, so that patch tests still pass."""
    cells = distorted_cells(element, 5)
    if cells.kernels.stabilise is None:
        raise NotApplicable("the element needs no stabilising forces")
    force = cells.stabilising_force(cells.nodes @ np.array([[0.3, 0.7], [-1.1, 0.4]]) + 0.5)
    agree(force, np.zeros_like(force), 1e-11, "stabilising forces of a linear displacement")
    random = np.random.default_rng(8).normal(size=cells.nodes.shape)
    require(float((random * cells.stabilising_force(random)).sum()) > 0.0, "stabilising forces do no work")


def any_cut_gives_the_same(element: Element) -> None:
    """Results do not depend on which cells share a block, to the last bit."""
    cells = distorted_cells(element, 13)
    q = len(element.quadrature().weights)
    field = np.random.default_rng(4).normal(size=cells.nodes.shape)
    stress = np.random.default_rng(5).normal(size=(4, cells.points))
    whole = cells.gradient(field).reshape(4, q, 13)
    force = np.zeros_like(cells.nodes)
    for begin, end in ((0, 1), (1, 6), (6, 13)):
        part = cells.part(begin, end)
        identical(part.gradient(field).reshape(4, q, -1), whole[:, :, begin:end], f"gradient in cells {begin} to {end}")
        cut = np.ascontiguousarray(stress.reshape(4, q, 13)[:, :, begin:end].reshape(4, -1))
        force += part.force(cut)
    identical(force, cells.force(stress), "force")


def kernels_leave_inputs_alone(element: Element) -> None:
    """Kernels read positions, field, connectivity and stress, and change none of them."""
    cells = distorted_cells(element, 5)
    field = np.random.default_rng(6).normal(size=cells.nodes.shape)
    stress = np.random.default_rng(7).normal(size=(4, cells.points))
    with untouched(geometry=cells.nodes, field=field, connectivity=cells.connectivity, stress=stress):
        cells.gradient(field)
        cells.force(stress)


def kernels_are_at_the_points(element: Element) -> None:
    """Kernels on parallelograms give the gradient at the points of the rule; its trace may be averaged."""
    turn = np.array([[1.2, 0.3], [-0.2, 0.8]])
    cell = Cells(element, np.asarray(element.nodes) @ turn.T, np.arange(len(element.nodes), dtype=np.int32)[:, None])
    field = np.random.default_rng(12).normal(size=cell.nodes.shape)
    shape = element.shape(element.quadrature().points).gradient @ np.linalg.inv(turn)
    xx, xy, yx, yy = np.einsum("ai,qaj->ijq", field, shape).reshape(4, -1)
    got = cell.gradient(field)
    if not element.exact:
        weights = element.quadrature().weights
        agree(
            got @ weights,
            np.stack([xx, xy, yx, yy]) @ weights,
            1e-11,
            "mean gradient by kernels and by shape functions",
        )
        raise NotApplicable("assumes the gradient of the shape functions at each point: exact is False")
    for name, one, other in (("xx - yy", got[0] - got[3], xx - yy), ("xy", got[1], xy), ("yx", got[2], yx)):
        agree(one, other, 1e-11, f"{name} of the gradient by the kernels, and by shape functions at the points")


def locking_is_declared(element: Element) -> None:
    """Points see no change of volume in the isochoric motion (x^2, -2 x y), or the element declares that it locks."""
    if not element.exact:
        raise NotApplicable("assumes strains of the shape functions: exact is False")
    x, y = element.nodes.T
    one = Cells(element, np.ascontiguousarray(element.nodes), np.arange(len(x), dtype=np.int32)[:, None])
    xx, _, _, yy = one.gradient(np.stack([x**2, -2.0 * x * y], axis=1))
    seen = float(np.abs(xx + yy).max())
    require(
        element.locks or seen < 1e-6,
        f"locks is False, but in an isochoric motion with strains of 1 volumes at its points change by {seen:.2f}: "
        "plastic flow is too stiff; declare locks = True",
    )


CHECKS: tuple[Check, ...] = (
    reference_nodes,
    edges_of_the_cell,
    tables_are_of_their_types,
    partition_of_unity,
    delta_property,
    gradient_is_the_derivative,
    complete_to_its_degree,
    quadrature_exactness,
    trace_is_the_shape,
    linear_field_is_exact,
    kernels_are_at_the_points,
    constant_stress_is_balanced,
    rigid_motion_is_free,
    lumped_mass,
    forces_are_added,
    stabilisation_sees_no_linear_field,
    any_cut_gives_the_same,
    kernels_leave_inputs_alone,
    locking_is_declared,
)
