"""Disc on block with GetFEM, an independent free code, on the same meshes and with the same law.

    apt-get install python3-getfem
    python3 benchmarks/peers/getfem_disc_on_block.py --level 2 --slave disc

Q1 elements; contact is GetFEM's own: large sliding by ray tracing, an augmented Lagrangian with continuous P1
multipliers on the slave, integrated over it; linear systems go to its MUMPS. Nothing of contactlab is imported. Writes
deformed x, pressure and the reaction to benchmarks/references, or prints them with CPU seconds as one line of JSON
(`--json`).
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from time import process_time

import getfem as gf
import numpy as np

OUT = Path(__file__).parents[1] / "references"
SLAVE, MASTER, HELD = 1, 2, 3
R = 70000.0  # N/mm3, of the augmentation: about the modulus of the block over a segment
QUADRATURE = 9  # order of the contact's integration on the slave
TOLERANCE = 1e-8  # of unbalanced forces over the reaction, and of gaps and multipliers over a segment and a pressure
LAW = "0.5*mu_{0}*((F):(F) - 2 - 2*log(Det(F))) + 0.5*la_{0}*sqr(log(Det(F)))"


def grid(columns: int, rows: int, place) -> gf.Mesh:
    """Cells of a unit square, mapped."""
    mesh = gf.Mesh("empty", 2)
    transformation = gf.GeoTrans("GT_QK(2,1)")
    for j in range(rows):
        for i in range(columns):
            corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)]
            points = np.array([place(a / columns, b / rows) for a, b in corners]).T
            mesh.add_convex(transformation, points)
    return mesh


def disc(level: int) -> gf.Mesh:
    """Between the arc of radius 1, |x| <= 0.8, and y = 0.6; columns of equal width."""

    def place(s: float, t: float) -> tuple[float, float]:
        x = 1.6 * s - 0.8
        low = 1.0 - np.sqrt(1.0 - x * x)
        return x, low + t * (0.6 - low)

    return grid(24 * level, 6 * level, place)


def block(level: int) -> gf.Mesh:
    """1.8 by 0.3, its top at y = 0."""
    return grid(36 * level, 6 * level, lambda s, t: (1.8 * s - 0.9, 0.3 * t - 0.3))


def region(mesh: gf.Mesh, number: int, chosen) -> None:
    """Outer faces all of whose nodes are chosen by (x, y)."""
    faces = mesh.outer_faces()
    kept = []
    for cell, face in faces.T:
        points = mesh.pts_from_cvid(cell)[0]
        own = mesh.pid_in_faces([[cell], [face]])
        points = mesh.pts(own)
        if chosen(points[0], points[1]).all():
            kept.append((cell, face))
    mesh.set_region(number, np.array(kept).T)


def solve(
    level: int, slave: str, depth: float, steps: int, quadrature: int = QUADRATURE
) -> tuple[np.ndarray, np.ndarray, float, int, float]:
    """Deformed x and pressure of the slave's nodes, vertical reaction, Newton iterations, CPU seconds of these."""
    meshes = {"d": disc(level), "b": block(level)}
    arc = lambda x, y: np.abs(y - (1.0 - np.sqrt(np.maximum(0.0, 1.0 - x * x)))) < 1e-9  # noqa: E731
    top = lambda x, y: np.abs(y) < 1e-9  # noqa: E731
    region(meshes["d"], SLAVE if slave == "disc" else MASTER, arc)
    region(meshes["b"], MASTER if slave == "disc" else SLAVE, top)
    region(meshes["d"], HELD, lambda x, y: np.abs(y - 0.6) < 1e-9)
    region(meshes["b"], HELD, lambda x, y: np.abs(y + 0.3) < 1e-9)
    model = gf.Model("real")
    fields, integrals = {}, {}
    for name, young in (("d", 70000.0), ("b", 7000.0)):
        fields[name] = gf.MeshFem(meshes[name], 2)
        fields[name].set_fem(gf.Fem("FEM_QK(2,1)"))
        integrals[name] = gf.MeshIm(meshes[name], gf.Integ("IM_GAUSS_PARALLELEPIPED(2,4)"))
        model.add_fem_variable(name, fields[name])
        model.add_initialized_data(f"mu_{name}", young / 2.6)
        model.add_initialized_data(f"la_{name}", young * 0.3 / (1.3 * 0.4))
        model.add_nonlinear_term(integrals[name], law(name))
        model.add_initialized_data(f"given_{name}", [0.0, 0.0])
        model.add_Dirichlet_condition_with_multipliers(integrals[name], name, fields[name], HELD, f"given_{name}")
    one, two = ("d", "b") if slave == "disc" else ("b", "d")
    multiplier = gf.MeshFem(meshes[one], 2)
    multiplier.set_fem(gf.Fem("FEM_QK(2,1)"))
    model.add_filtered_fem_variable("lam", multiplier, SLAVE)
    model.add_initialized_data("r", R)
    fine = gf.MeshIm(meshes[one], gf.Integ(f"IM_GAUSS_PARALLELEPIPED(2,{quadrature})"))
    contact = model.add_integral_large_sliding_contact_brick_raytracing("r", 0.05)
    model.add_slave_contact_boundary_to_large_sliding_contact_brick(contact, fine, SLAVE, one, "lam")
    model.add_master_contact_boundary_to_large_sliding_contact_brick(contact, integrals[two], MASTER, two)
    iterations, began = 0, process_time()
    for step in range(1, steps + 1):
        model.set_variable("given_d", [0.0, -depth * step / steps])
        iterations += newton(model)
    seconds = process_time() - began
    force = reaction(model, integrals["b"], fields["b"])
    return (*profile(model, fields[one], multiplier, one), force, iterations, seconds)


def newton(model: gf.Model, most: int = 60) -> int:
    """Newton's iteration on GetFEM's residual and tangent, full corrections."""
    change = np.inf
    for iteration in range(most + 1):
        model.assembly("build_all")
        right = model.rhs()
        if iteration and balanced(model, right):
            return iteration
        change = np.ravel(gf.linsolve_mumps(model.tangent_matrix(), right))
        model.to_variables(model.from_variables() + change)
        if not np.isfinite(change).all():
            break
    raise SystemExit(f"no convergence in {most} iterations, last correction {np.abs(change).max():.1e}")


def balanced(model: gf.Model, right: np.ndarray) -> bool:
    """Whether bodies are in balance and contact conditions hold, as exactly as contactlab asks by default."""
    sizes = {}
    for name in ("d", "b", "lam"):
        first, count = model.interval_of_variable(name)
        sizes[name] = float(np.abs(right[first : first + count]).max())
    # a nodal force is about the largest multiplier over a segment of 1/30 mm, a violated gap is integrated over one
    force = max(1.0, float(np.abs(model.variable("lam")).max()) / 30.0)
    return max(sizes["d"], sizes["b"]) < TOLERANCE * force and sizes["lam"] < TOLERANCE / 30.0


def law(name: str) -> str:
    """Energy of the compressible neo-Hookean law."""
    return LAW.format(name).replace("F", f"(Id(2)+Grad_{name})")


def reaction(model: gf.Model, integral: gf.MeshIm, field: gf.MeshFem) -> float:
    """Sum of vertical internal forces at the block's bottom."""
    forces = gf.asm_generic(integral, 1, law("b"), -1, model)
    first, count = model.interval_of_variable("b")
    own = np.asarray(forces)[first : first + count]
    held = np.asarray(field.basic_dof_on_region(HELD))
    return float(abs(own[held[held % 2 == 1]].sum()))


def profile(model: gf.Model, field: gf.MeshFem, full: gf.MeshFem, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Deformed x and size of the multiplier at the slave's nodes, from left to right."""
    values = gf.compute_interpolate_on(model.mesh_fem_of_variable("lam"), model.variable("lam"), full)
    nodes, moved = field.basic_dof_nodes(), model.variable(name)
    on = np.asarray(field.basic_dof_on_region(SLAVE))
    on = on[on % 2 == 0]
    on = on[np.argsort(nodes[0, on])]
    before = np.stack([nodes[0, on], nodes[1, on]])
    after = before + np.stack([moved[on], moved[on + 1]])
    # multipliers are per undeformed length
    return after[0], np.hypot(values[on], values[on + 1]) * lengths(before) / lengths(after)


def lengths(x: np.ndarray) -> np.ndarray:
    """What each node of a chain (2, n) stands for [mm]."""
    half = 0.5 * np.hypot(*np.diff(x))
    return np.append(half, 0.0) + np.append(0.0, half)


def main() -> None:
    """Solve and write."""
    wish = argparse.ArgumentParser(description=__doc__)
    wish.add_argument("--level", type=int, default=2)
    wish.add_argument("--slave", choices=["disc", "block"], default="disc")
    wish.add_argument("--depth", type=float, default=0.1581)
    wish.add_argument("--steps", type=int, default=10)
    wish.add_argument("--quadrature", type=int, default=QUADRATURE)
    wish.add_argument("--json", action="store_true")
    given = wish.parse_args()
    gf.util_trace_level(0)
    x, pressure, force, iterations, seconds = solve(
        given.level, given.slave, given.depth, given.steps, given.quadrature
    )
    if given.json:
        row = {"x": x.tolist(), "pressure": pressure.tolist(), "reaction": force}
        print(json.dumps(row | {"iterations": iterations, "seconds": seconds}))
        return
    print(f"reaction {force:.3f} N/mm, {iterations} iterations, highest pressure {pressure.max():.1f} MPa")
    OUT.mkdir(exist_ok=True)
    name = f"getfem-disc-on-block-{given.slave}-level-{given.level}-depth-{given.depth:g}.csv"
    head = f"GetFEM, {given.slave} is slave, level {given.level}, depth {given.depth:g} mm, reaction {force:.4f} N/mm"
    table = np.stack([x, pressure], 1)
    np.savetxt(OUT / name, table, "%.7g", ",", header=f"{head}\nx_deformed_mm,p_MPa", comments="# ")


if __name__ == "__main__":
    main()
