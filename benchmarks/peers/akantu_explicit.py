"""Explicit steps of Akantu on a structured mesh of bilinear quadrilaterals, timed as ours are.

    python benchmarks/peers/akantu_explicit.py --cells 10000 --rounds 5

Prints one line of JSON: the version, the cells, and CPU seconds per step, one number a round.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import tempfile
from importlib.metadata import version
from pathlib import Path

import akantu as aka
import numpy as np
from problem import ELASTIC, arguments, quads, report, velocities

MATERIAL = """
material elastic [
  name = m
  rho = {density}
  E = {young}
  nu = {poisson}
  Plane_Stress = 0
]
"""


def written(folder: Path, nodes: np.ndarray, cells: np.ndarray) -> str:
    """The mesh as a Gmsh file, which is what Akantu reads."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes))]
    lines += [f"{i + 1} {x!r} {y!r} 0" for i, (x, y) in enumerate(nodes.tolist())]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += [f"{i + 1} 3 2 1 1 {a} {b} {c} {d}" for i, (a, b, c, d) in enumerate((cells + 1).tolist())]
    path = folder / "mesh.msh"
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return str(path)


def main() -> None:
    """Build, warm up, measure, print."""
    chosen = arguments(__doc__)
    nodes, cells = quads(chosen.cells)
    with tempfile.TemporaryDirectory() as folder:
        material = Path(folder) / "material.dat"
        material.write_text(MATERIAL.format(**ELASTIC))
        aka.parseInput(str(material))
        mesh = aka.Mesh(2)
        mesh.read(written(Path(folder), nodes, cells))
    model = aka.SolidMechanicsModel(mesh)
    model.initFull(_analysis_method=aka._explicit_lumped_mass)
    model.setTimeStep(0.8 * model.getStableTimeStep())
    model.getVelocity()[:] = velocities(np.array(mesh.getNodes()))
    report("Akantu", version("akantu"), len(cells), model.solveStep, chosen.rounds)
    assert np.isfinite(model.getDisplacement()).all()
    assert np.abs(model.getInternalForce()).max() > 0.0


if __name__ == "__main__":
    main()
