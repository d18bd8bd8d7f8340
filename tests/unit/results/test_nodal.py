"""Nodal values: exact for linear fields, also at the skin and at corners of a body."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.results.nodal import nodal_values, principal_stresses


def grid(nx: int, ny: int, warp: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.meshgrid(np.linspace(0.0, 4.0, nx + 1), np.linspace(0.0, 1.0, ny + 1))
    nodes = np.column_stack([x.ravel() + warp * np.sin(3.0 * y.ravel()), y.ravel() + warp * np.sin(x.ravel())])
    first = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    return nodes, np.column_stack([first, first + 1, first + nx + 2, first + nx + 1])


@pytest.mark.parametrize("warp", [0.0, 0.1])
def test_a_linear_field_is_exact_everywhere(warp: float) -> None:
    nodes, cells = grid(7, 4, warp)
    values = nodes[cells].mean(axis=1) @ np.array([[2.0, 1.0], [-3.0, 0.0]]) + 5.0
    assert nodal_values(nodes, cells, values) == pytest.approx(nodes @ np.array([[2.0, 1.0], [-3.0, 0.0]]) + 5.0)


def test_triangles_and_quadratic_cells_are_those_of_their_corners() -> None:
    nodes, cells = grid(5, 3)
    triangles = np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    values = nodes[triangles].mean(axis=1)[:, :1]
    assert nodal_values(nodes, triangles, values)[:, 0] == pytest.approx(nodes[:, 0])
    more = np.concatenate([nodes, nodes[cells].mean(axis=1)])  # a middle node in each cell
    nine = np.column_stack([cells, cells, len(nodes) + np.arange(len(cells))])
    found = nodal_values(more, nine, nodes[cells].mean(axis=1)[:, :1])[:, 0]
    assert found[: len(nodes)] == pytest.approx(nodes[:, 0])
    assert np.isnan(found[len(nodes) :]).all()


def test_the_skin_of_a_bent_beam_has_its_stress() -> None:
    """Four cells high: means of cells reach 3/4 of the largest stress."""
    nodes, cells = grid(12, 4)
    stress = (nodes[cells].mean(axis=1)[:, 1:] - 0.5) * 2.0
    assert np.abs(stress).max() == pytest.approx(0.75)
    assert np.abs(nodal_values(nodes, cells, stress)).max() == pytest.approx(1.0)


@pytest.mark.parametrize(("nx", "ny"), [(1, 1), (2, 1), (6, 1)])
def test_cells_in_a_row_are_averaged_across(nx: int, ny: int) -> None:
    nodes, cells = grid(nx, ny)
    found = nodal_values(nodes, cells, np.full((len(cells), 1), 3.0))
    assert found == pytest.approx(3.0)


def test_principal_stresses_of_shear_and_pressure() -> None:
    stress = np.array([[0.0, 0.0, 0.0, 2.0], [-1.0, -1.0, -5.0, 0.0], [3.0, -1.0, 1.0, 1.5]])
    assert principal_stresses(stress) == pytest.approx(
        np.array([[2.0, 0.0, -2.0], [-1.0, -1.0, -5.0], [3.5, 1.0, -1.5]])
    )
