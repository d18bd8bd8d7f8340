"""Does a block that slides with friction flutter by itself? (docs/theory/friction-flutter.md)

    python benchmarks/studies/flutter.py [--levels 1 2 4] [--runs]

Modes of the block of `block-on-incline` on its plane, all of its lower nodes closed and sliding: an assembly of its
own, with nothing of contactlab in it. Their growth without damping, and the least `rate` of vibration-damping at which
none grows in steps of central differences. `--runs` puts this to the scene: runs with 0.8 and 1.25 times that rate.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
from scipy.linalg import eig, qr

YOUNG, POISSON, DENSITY, MU = 100.0, 0.3, 7.8e-9, 0.3  # MPa, t/mm3, as in the scene
LENGTH, HEIGHT, CELLS = 10.0, 5.0, (8, 4)  # mm
FRACTION = 0.9  # of the stable step, as in the scene
STRAINS = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 1.0, 0.0]])
"""Strains xx, yy and xy of the gradient (ux,x ux,y uy,x uy,y)."""
Array = Any


def cell_stiffness(wide: float, high: float) -> Array:
    """Of a bilinear rectangle with 2 x 2 points, plane strain, (8, 8)."""
    lame, shear = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
    law = np.diag([2 * shear, 2 * shear, shear])
    law[:2, :2] += lame
    xs, ys = np.array([-1, 1, 1, -1]), np.array([-1, -1, 1, 1])
    total = np.zeros((8, 8))
    for a in (-(3**-0.5), 3**-0.5):
        for b in (-(3**-0.5), 3**-0.5):
            shapes = np.array([xs * (1 + b * ys) / (2 * wide), ys * (1 + a * xs) / (2 * high)])  # gradients, (2, 4)
            gradient = np.zeros((4, 8))
            gradient[:2, 0::2] = gradient[2:, 1::2] = shapes
            strain = STRAINS @ gradient
            total += strain.T @ law @ strain * wide * high / 4
    return total


def system(level: int) -> tuple[Array, Array, Array, Array]:
    """Stiffness (n, n), lumped masses (n,), nodes' positions (n/2, 2) and nodes of the lower side."""
    across, up = CELLS[0] * level, CELLS[1] * level
    wide, high = LENGTH / across, HEIGHT / up
    y, x = np.meshgrid(np.arange(up + 1) * high, np.arange(across + 1) * wide, indexing="ij")
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    stiffness, mass = np.zeros((2 * len(places),) * 2), np.zeros(2 * len(places))
    cell = cell_stiffness(wide, high)
    for row in range(up):
        for column in range(across):
            first = row * (across + 1) + column
            nodes = np.array([first, first + 1, first + across + 2, first + across + 1])
            unknowns = np.stack([2 * nodes, 2 * nodes + 1], axis=1).ravel()
            stiffness[np.ix_(unknowns, unknowns)] += cell
            mass[unknowns] += DENSITY * wide * high / 4
    return stiffness, mass, places, np.arange(across + 1)


def growth(level: int) -> dict[str, float]:
    """Largest growth without damping [1/s], its circular frequency, and the least rate that stops all modes [1/s].

    The pressure on a lower node is p = (K u)_n, as its inertia along the normal vanishes; friction -mu p along the
    plane makes the matrix of the free unknowns unsymmetric: rows of tangents K_t + mu K_n. Pairs of conjugate
    eigenvalues flutter. Damping of everything but the rigid motion takes the share of a mode that is not rigid, by its
    left and right vectors.
    """
    stiffness, mass, places, lower = system(level)
    with_friction = stiffness.copy()
    with_friction[2 * lower] += MU * stiffness[2 * lower + 1]
    free = np.setdiff1d(np.arange(len(mass)), 2 * lower + 1)
    root = np.sqrt(mass[free])
    values, left, right = eig(with_friction[np.ix_(free, free)] / root[:, None] / root[None, :], left=True)
    x, y = places.T
    rigid = np.zeros((len(mass), 3))
    rigid[0::2, 0] = rigid[1::2, 1] = 1.0
    rigid[0::2, 2], rigid[1::2, 2] = -y, x
    basis = qr(np.sqrt(mass)[:, None] * rigid, mode="economic")[0][free]  # projects momenta of the whole body
    overlap = np.einsum("ij,ij->j", left.conj(), right)
    damped = 1.0 - np.einsum("ij,ij->j", (basis.T @ left).conj(), basis.T @ right) / overlap
    frequency = np.sqrt(values.astype(complex))
    step = FRACTION * 2.0 / np.abs(frequency).max()
    half = 1.0 - 0.5 * values * step**2  # z + 1/z = 2 half for displacements that grow by z a step
    grown = np.abs(np.log(np.abs(half + np.sqrt(half**2 - 1.0 + 0.0j)))) / step
    # a rate takes half of it times the damped share from the growth; modes that damping does not reach are rigid
    share = damped.real
    moving = np.abs(frequency) > 1e-6 * np.abs(frequency).max()
    at = int(np.argmax(np.where(moving, np.abs(frequency.imag), 0.0)))
    needed = np.where(moving, grown / (0.5 * share), 0.0)
    most = int(np.argmax(needed))
    return {
        "growth": float(abs(frequency[at].imag)),
        "frequency": float(frequency[at].real),
        "growth in steps": float(grown[at]),
        "rate": float(needed[most]),
        "its frequency": float(frequency[most].real),
        "its damped share": float(share[most]),
    }


def swing(level: int, rate: float) -> tuple[str, float]:
    """How the scene ends with that rate, and how far the plane's reaction swings in the second half over its mean."""
    import contactlab

    changes = {"level": level, "effects.0.ramp": 0.01, "time.end": 0.06}
    scene = contactlab.load_scene("block-on-incline").with_(changes)
    found = contactlab.simulate(scene.with_({"effects.1.rate": rate, "record.recorders": []}))
    force = np.asarray(found.history["plane.fy"])
    late = force[len(force) // 2 :]
    return found.summary["status"], float(np.ptp(late) / np.mean(late))


def main() -> None:
    """Print a row per level."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--levels", type=int, nargs="+", default=[1, 2, 4])
    arguments.add_argument("--runs", action="store_true")
    asked = arguments.parse_args()
    for level in asked.levels:
        found = growth(level)
        print(level, *(f"{name} {value:.3g}" for name, value in found.items()), sep=" | ", flush=True)
        for factor in (0.8, 1.25) if asked.runs else ():
            status, size = swing(level, factor * found["rate"])
            print(f"  {factor} of the rate: {status}, reaction swings by {size:.2g} of its mean", flush=True)


if __name__ == "__main__":
    main()
