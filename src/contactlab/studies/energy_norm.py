"""Distance of two solutions in the energy norm of linear elasticity, on nested rectangular meshes."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from contactlab.api import Floats, Record
from contactlab.model.bodies.body import Body
from contactlab.model.bodies.stiffness import cell_stiffness
from contactlab.model.build import build
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

Ended = Results | Record

ROUND = 12  # decimals at which coordinates of nodes are the same


def energy_norm(results: Ended, scene: Scene, body: str) -> float:
    """sqrt(a(u, u)) [sqrt(N)] of a body's displacement at the end of a run, per mm thickness."""
    return _norm(_body(scene, body), results.nodes, results.displacement)


def energy_distance(coarse: Ended, fine: Ended, fine_scene: Any, body: str) -> float:
    """sqrt(a(u - v, u - v)) [sqrt(N)] of a body between two runs of one scene.

    The coarse field is interpolated to the fine nodes, which loses nothing if the coarse mesh is `q1` on an
    upright rectangle and its lines are lines of the fine mesh. Raises ValueError for any other body.
    """
    difference = fine.displacement.copy()
    own, other = np.unique(fine.cells[body]), np.unique(coarse.cells[body])
    difference[own] -= _interpolated(coarse.nodes[other], coarse.displacement[other], fine.nodes[own])
    return _norm(_body(fine_scene, body), fine.nodes, difference)


def _body(scene: Scene, name: str) -> Body:
    return next(body for body in build(scene, scene.registry).bodies if body.name == name)


def _norm(body: Body, nodes: Floats, displacement: Floats) -> float:
    cells = displacement[body.cells].reshape(len(body.cells), -1)
    matrices = cell_stiffness(body, np.ascontiguousarray(nodes))
    return float(np.sqrt(np.einsum("ni,nij,nj->", cells, matrices, cells)))


def _interpolated(nodes: Floats, values: Floats, at: Floats) -> Floats:
    x, column = np.unique(nodes[:, 0].round(ROUND), return_inverse=True)
    y, row = np.unique(nodes[:, 1].round(ROUND), return_inverse=True)
    if len(x) * len(y) != len(nodes):
        raise ValueError(f"a body of {len(nodes)} nodes is not an upright grid of {len(x)} by {len(y)} lines")
    grid = np.empty((len(x), len(y), 2))
    grid[column, row] = values
    return np.asarray(RegularGridInterpolator((x, y), grid)(at.round(ROUND)))
