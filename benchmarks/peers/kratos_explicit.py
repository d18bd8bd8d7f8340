"""Explicit steps of Kratos Multiphysics on a structured mesh of bilinear quadrilaterals, timed as ours are.

    python benchmarks/peers/kratos_explicit.py --cells 10000 --rounds 5

Prints one line of JSON: the version, the cells, and CPU seconds per step, one number a round.
"""

from __future__ import annotations

import contextlib
import os
import sys
from importlib.metadata import version

os.environ.setdefault("OMP_NUM_THREADS", "1")

with contextlib.redirect_stdout(sys.stderr):
    import KratosMultiphysics as Kratos
    import KratosMultiphysics.StructuralMechanicsApplication as Structural

import numpy as np
from problem import ELASTIC, arguments, quads, report, velocities

STABLE = 0.5  # of the cell's side over the speed of sound


def block(model: Kratos.Model, nodes: np.ndarray, cells: np.ndarray) -> Kratos.ModelPart:
    """A model part of small-strain quadrilaterals in plane strain with the flow as initial velocity."""
    part = model.CreateModelPart("block")
    part.ProcessInfo[Kratos.DOMAIN_SIZE] = 2
    part.ProcessInfo[Kratos.COMPUTE_LUMPED_MASS_MATRIX] = True
    for name in (
        "DISPLACEMENT", "VELOCITY", "ACCELERATION", "REACTION", "VOLUME_ACCELERATION", "NODAL_MASS", "FORCE_RESIDUAL",
        "RESIDUAL_VECTOR",
    ):  # fmt: skip
        part.AddNodalSolutionStepVariable(getattr(Kratos, name))
    part.AddNodalSolutionStepVariable(Structural.MIDDLE_VELOCITY)
    part.SetBufferSize(2)
    constants = part.CreateNewProperties(1)
    constants[Kratos.YOUNG_MODULUS], constants[Kratos.POISSON_RATIO] = ELASTIC["young"], ELASTIC["poisson"]
    constants[Kratos.DENSITY], constants[Kratos.THICKNESS] = ELASTIC["density"], 1.0
    constants[Kratos.CONSTITUTIVE_LAW] = Structural.LinearElasticPlaneStrain2DLaw()
    for i, (x, y) in enumerate(nodes.tolist()):
        part.CreateNewNode(i + 1, x, y, 0.0)
    for i, corners in enumerate((cells + 1).tolist()):
        part.CreateNewElement("SmallDisplacementElement2D4N", i + 1, corners, constants)
    for node, (vx, vy) in zip(part.Nodes, velocities(nodes).tolist(), strict=True):
        node.SetSolutionStepValue(Kratos.VELOCITY, [vx, vy, 0.0])
    for x, reaction in ((Kratos.DISPLACEMENT_X, Kratos.REACTION_X), (Kratos.DISPLACEMENT_Y, Kratos.REACTION_Y)):
        Kratos.VariableUtils().AddDof(x, reaction, part)
    return part


def main() -> None:
    """Build, warm up, measure, print."""
    chosen = arguments(__doc__)
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    nodes, cells = quads(chosen.cells)
    model = Kratos.Model()
    part = block(model, nodes, cells)
    dt = STABLE * (ELASTIC["density"] / (1.35 * ELASTIC["young"])) ** 0.5
    scheme = Structural.ExplicitCentralDifferencesScheme(dt, 0.333333333333, 0)
    strategy = Structural.MechanicalExplicitStrategy(part, scheme, False, False, True)
    strategy.SetRebuildLevel(0)
    strategy.Initialize()
    time = 0.0

    def step() -> None:
        nonlocal time
        time += dt
        part.ProcessInfo[Kratos.STEP] += 1
        part.CloneTimeStep(time)
        strategy.InitializeSolutionStep()
        strategy.Predict()
        strategy.SolveSolutionStep()
        strategy.FinalizeSolutionStep()

    step()
    report("Kratos", version("KratosMultiphysics"), len(cells), step, chosen.rounds)
    moved = np.array([node.GetSolutionStepValue(Kratos.DISPLACEMENT) for node in part.Nodes])
    assert np.isfinite(moved).all()
    assert np.abs(moved).max() > 0.0


if __name__ == "__main__":
    main()
