"""Files of meshes with a few wrong numbers, or with damage."""

from __future__ import annotations

import contextlib
import io
import random
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from damages import damage

# what meshio writes and reads with groups of cells or points, or without
FORMATS = ("gmsh22", "gmsh", "abaqus", "vtk", "vtu", "nastran", "med", "xdmf", "su2", "obj")
ENDINGS = {"gmsh22": ".msh", "gmsh": ".msh", "abaqus": ".inp", "nastran": ".bdf"}
CELLS = (4, 2)
NUMBERS = (0.0, -1.0, 1e-300, 1e300, float("nan"), float("inf"), -float("inf"), 0.5)


def strange_mesh(folder: Path, chance: random.Random) -> dict[str, Any]:
    """Write a block of quadrilaterals that was tampered with; the changes of a scene that take it as its block."""
    points, cells = _block()
    for _ in range(chance.choice((0, 1, 1, 2))):
        chance.choice((_move, _stretch, _renumber, _drop, _repeat))(points, cells, chance)
    kind = chance.choice(FORMATS)
    path = folder / f"mesh{ENDINGS.get(kind, '.' + kind)}"
    sides = np.array([[i, i + 1] for i in range(CELLS[0])])
    top = sides + CELLS[1] * (CELLS[0] + 1)
    data = [("quad", np.array(cells)), ("line", np.concatenate([sides, top]))]
    tags = [np.full(len(cells), 9), np.repeat([1, 2], CELLS[0])]
    groups = {"block": np.array([9, 2]), "bottom": np.array([1, 1]), "top": np.array([2, 1])}
    more = {"cell_data": {"gmsh:physical": tags, "gmsh:geometrical": tags}, "field_data": groups}
    flat = np.column_stack([np.array(points), np.zeros(len(points))])
    with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(Exception):
        meshio.write(path, meshio.Mesh(flat, data, **(more if kind.startswith("gmsh") else {})), file_format=kind)
    if not path.is_file():  # meshio does not write this
        path.write_bytes(chance.randbytes(chance.choice((0, 1, 100))))
    elif chance.random() < 0.4 and path.stat().st_size:
        damage(path, chance)
    named = kind.startswith("gmsh")
    changes: dict[str, Any] = {"bodies.block.mesh": {"use": "file", "path": str(path)}}
    return changes if named else {**changes, "contacts.0.master": "block.boundary", "supports.0.on": "block.boundary"}


def _block() -> tuple[list[list[float]], list[list[int]]]:
    nx, ny = CELLS
    points = [[-0.9 + 1.8 * i / nx, -0.3 + 0.3 * j / ny] for j in range(ny + 1) for i in range(nx + 1)]
    at = [[i + j * (nx + 1) for i in range(nx + 1)] for j in range(ny + 1)]
    cells = [[at[j][i], at[j][i + 1], at[j + 1][i + 1], at[j + 1][i]] for j in range(ny) for i in range(nx)]
    return points, cells


def _move(points: list[list[float]], cells: list[list[int]], chance: random.Random) -> None:
    chance.choice(points)[chance.randrange(2)] = chance.choice(NUMBERS)


def _stretch(points: list[list[float]], cells: list[list[int]], chance: random.Random) -> None:
    factor = chance.choice(NUMBERS)
    for point in points:
        point[1] *= factor


def _renumber(points: list[list[float]], cells: list[list[int]], chance: random.Random) -> None:
    chance.choice(cells)[chance.randrange(4)] = chance.choice((0, -1, 3, len(points), 10**9))


def _drop(points: list[list[float]], cells: list[list[int]], chance: random.Random) -> None:
    if len(cells) > 1:
        del cells[chance.randrange(len(cells))]


def _repeat(points: list[list[float]], cells: list[list[int]], chance: random.Random) -> None:
    cells.append(list(chance.choice(cells)))
