"""Patch, locking and stability of the quadrilaterals in linear statics, each with its exact answer."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contactlab_quads.q1 import Q1
from contactlab_quads.q1_fbar import Q1Fbar
from contactlab_quads.q1_reduced import Q1Reduced
from contactlab_quads.q2 import Q2
from contactlab_quads.q2_lagrange import Q2Lagrange
from contactlab_solids.linear_elastic import LinearElastic
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import spsolve

from contactlab.api import Element, Floats, Ints, Mesh
from contactlab.api.meshing import structured
from contactlab.kernels.cells import element_kernels
from contactlab.model.bodies.body import Body
from contactlab.model.bodies.stiffness import cell_stiffness

ELEMENTS: tuple[Element, ...] = (Q1(), Q1Fbar(), Q1Reduced(), Q2(), Q2Lagrange())
LINEAR = ELEMENTS[:3]


def names(element: Element) -> str:
    return type(element).__name__


def body_of(mesh: Mesh, element: Element, poisson: float) -> Body:
    return Body("body", element, LinearElastic(1000.0, poisson, 1.0), mesh, 0, len(mesh.nodes), mesh.cells)


def assembled(body: Body) -> csc_matrix:
    n, a = body.cells.shape
    dof = (2 * body.cells[:, :, None] + np.arange(2)).reshape(n, 2 * a)
    rows, columns = np.repeat(dof, 2 * a, axis=1).ravel(), np.tile(dof, (1, 2 * a)).ravel()
    return coo_matrix((cell_stiffness(body, body.mesh.nodes).ravel(), (rows, columns))).tocsc()


def solved(body: Body, load: Floats, held: Ints, values: Floats) -> Floats:
    """Displacements (N, 2) under nodal loads with the degrees of freedom `held` at `values`."""
    stiffness = assembled(body)
    u = np.zeros(load.size)
    u[held] = values
    free = np.setdiff1d(np.arange(load.size), held)
    u[free] = spsolve(stiffness[free][:, free], load.ravel()[free] - stiffness[free] @ u)
    return u.reshape(-1, 2)


def distorted_square(element: Element, cells: int) -> Mesh:
    """A unit square whose inner corners are off their place by up to 15 % of a cell; mid nodes stay in the middle."""

    def place(s: Floats, t: Floats) -> tuple[Floats, Floats]:
        # bilinear between shifted corners, so that sides stay straight
        random = np.random.default_rng(7)
        shift = random.uniform(-0.15, 0.15, (2, cells + 1, cells + 1)) / cells
        shift[:, [0, -1], :] = shift[:, :, [0, -1]] = 0.0
        x, y = s * cells, t * cells
        i, j = np.minimum(x.astype(int), cells - 1), np.minimum(y.astype(int), cells - 1)
        a, b = x - i, y - j
        moved = (
            (1 - a) * (1 - b) * shift[:, i, j] + a * (1 - b) * shift[:, i + 1, j]
            + (1 - a) * b * shift[:, i, j + 1] + a * b * shift[:, i + 1, j + 1]
        )  # fmt: skip
        return s + moved[0], t + moved[1]

    return structured(element, (cells, cells), place)


# --- patch ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("poisson", [0.3, 0.4999])
@pytest.mark.parametrize("element", ELEMENTS, ids=names)
def test_patch(element: Element, poisson: float) -> None:
    """With a linear displacement on the boundary the inside is linear, too."""
    body = body_of(distorted_square(element, 4), element, poisson)
    x = body.mesh.nodes
    exact = x @ np.array([[0.01, 0.003], [-0.006, 0.008]]) + [0.1, -0.2]
    boundary = np.flatnonzero(np.isclose(x % 1.0, 0.0).any(axis=1))
    held = np.concatenate([2 * boundary, 2 * boundary + 1])
    values = np.concatenate([exact[boundary, 0], exact[boundary, 1]])
    u = solved(body, np.zeros_like(x), held, values)
    # round-off times the condition of the stiffness, which grows like 1/(1 - 2 poisson)
    np.testing.assert_allclose(u, exact, atol=1e-12 if poisson == 0.3 else 1e-9)


@pytest.mark.parametrize("element", [Q2(), Q2Lagrange()], ids=names)
def test_pure_bending_is_exact(element: Element) -> None:
    """A beam with moments at its ends bends into the parabola of beam theory on rectangular quadratic cells."""
    mesh = structured(element, (4, 1), lambda s, t: (4.0 * s, t - 0.5))
    body = body_of(mesh, element, 0.3)
    x, y = mesh.nodes.T
    curvature = 1e-3
    # plane strain: strain xx = curvature y, strain yy = -nu/(1 - nu) strain xx
    exact = curvature * np.stack([x * y, -0.5 * x**2 - 0.5 * 0.3 / 0.7 * y**2], axis=1)
    ends = np.flatnonzero(np.isclose(x, 0.0) | np.isclose(x, 4.0))
    held = np.concatenate([2 * ends, 2 * ends + 1])
    u = solved(body, np.zeros_like(mesh.nodes), held, np.concatenate([exact[ends, 0], exact[ends, 1]]))
    np.testing.assert_allclose(u, exact, atol=1e-15 * 1e3)  # round-off times the condition


# --- modes of one cell ---------------------------------------------------------------------------


def eigenvalues(element: Element, poisson: float) -> Floats:
    """Eigenvalues of one distorted cell's stiffness over its shear modulus."""
    corners = np.array([[0.0, 0.0], [1.1, 0.1], [1.0, 1.2], [-0.1, 0.9]])
    mesh = Mesh(Q1().shape(element.nodes).value @ corners, np.arange(len(element.nodes), dtype=np.int32)[None], {})
    body = body_of(mesh, element, poisson)
    return np.asarray(np.linalg.eigvalsh(cell_stiffness(body, mesh.nodes)[0]) / body.shear_modulus)


@pytest.mark.parametrize("element", ELEMENTS, ids=names)
def test_only_rigid_motions_are_free(element: Element) -> None:
    values = eigenvalues(element, 0.3)
    assert np.abs(values[:3]).max() < 1e-12
    assert values[3] > 0.01  # also the hourglass modes of the reduced element


@pytest.mark.parametrize(("element", "growing"), [(Q1(), 3), (Q1Fbar(), 1), (Q1Reduced(), 1)], ids=str)
def test_constraints_of_an_incompressible_cell(element: Element, growing: int) -> None:
    """Eigenvalues that grow like 1/(1 - 2 nu): one, the change of area, unless the cell locks."""
    near, nearer = eigenvalues(element, 0.499), eigenvalues(element, 0.4999)
    grown = nearer / np.maximum(near, 1e-9) > 5.0
    assert int((grown & (nearer > 10.0)).sum()) == growing


# --- thick ring ----------------------------------------------------------------------------------


def inner_displacement(element: Element, cells: int, poisson: float) -> float:
    """Radial displacement at the inner radius of a ring a = 1, b = 2 under inner pressure 1, over the exact one."""

    def place(s: Floats, t: Floats) -> tuple[Floats, Floats]:
        radius, angle = 1.0 + t, 0.5 * math.pi * (1.0 - s)
        return radius * np.cos(angle), radius * np.sin(angle)

    mesh = structured(element, (2 * cells, cells), place)
    load = np.zeros_like(mesh.nodes)
    points, weights = np.polynomial.legendre.leggauss(4)
    value, derivative = element.edge_shape(points)
    for edge in mesh.edges["bottom"]:
        along = derivative @ mesh.nodes[edge]
        # the body lies on the left of the edge, so pressure pushes to the left
        push = np.stack([-along[:, 1], along[:, 0]], axis=1) * weights[:, None]
        np.add.at(load, edge, value.T @ push)
    x, y = mesh.nodes.T
    held = np.concatenate([2 * np.flatnonzero(np.isclose(x, 0.0)), 2 * np.flatnonzero(np.isclose(y, 0.0)) + 1])
    u = solved(body_of(mesh, element, poisson), load, held, np.zeros(len(held)))
    inner = np.flatnonzero(np.isclose(np.hypot(x, y), 1.0))
    exact = (1.0 + poisson) * ((1.0 - 2.0 * poisson) + 4.0) / (1000.0 * 3.0)
    return float(np.hypot(u[inner, 0], u[inner, 1]).mean() / exact)


@pytest.mark.parametrize("element", [Q1Fbar(), Q1Reduced(), Q2(), Q2Lagrange()], ids=names)
def test_thick_ring_nearly_incompressible(element: Element) -> None:
    """Eight cells through the thickness, poisson = 0.4999: within 1 %."""
    assert inner_displacement(element, 8, 0.4999) == pytest.approx(1.0, abs=0.01)


def test_plain_q1_locks() -> None:
    assert inner_displacement(Q1(), 8, 0.3) == pytest.approx(1.0, abs=0.01)
    assert inner_displacement(Q1(), 8, 0.4999) < 0.3


# --- stabilisation -------------------------------------------------------------------------------


def test_hourglass_control_ignores_linear_fields() -> None:
    """Any linear displacement of any cell, small or large, meets no hourglass force; an hourglass does."""
    random = np.random.default_rng(2)
    stabilise = element_kernels(Q1Reduced(), "finite").stabilise
    assert stabilise is not None
    x = (Q1.nodes[None] + random.uniform(-0.3, 0.3, (50, 4, 2))).transpose(1, 0, 2).reshape(-1, 2)
    conn = np.arange(200, dtype=np.int32).reshape(4, 50)
    force, scratch = np.zeros((200, 2)), np.zeros((30, 50))
    stabilise(x, x @ random.uniform(-2.0, 2.0, (2, 2)) + 0.7, conn, 1.0, force, scratch)
    assert np.abs(force).max() < 1e-14
    stabilise(x, np.repeat([[1.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [-1.0, 0.0]], 50, axis=0), conn, 1.0, force, scratch)
    assert np.abs(force[:, 0]).min() > 1e-3
    by_cell = force[conn]
    np.testing.assert_allclose(by_cell.sum(axis=0), 0.0, atol=1e-14)  # no resultant
    moment = (x[conn, 0] * by_cell[..., 1] - x[conn, 1] * by_cell[..., 0]).sum(axis=0)
    np.testing.assert_allclose(moment, 0.0, atol=1e-14)
