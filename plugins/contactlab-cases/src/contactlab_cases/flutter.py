"""Modes of a block that slides on a plane with friction, from an assembly of its own: nothing of contactlab is used.

All nodes of the lower side are closed and slide. They do not accelerate along the normal, so that the pressure on them
is p = (K u)_n, and friction -mu p makes the matrix of the free unknowns unsymmetric: rows of tangents K_t + mu K_n.
Pairs of conjugate eigenvalues flutter (Martins, Guimaraes & Faria 1995, J. Vib. Acoust. 117:445-451).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from contactlab.api import Floats

STRAINS = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 1.0, 0.0]])
"""Strains xx, yy and xy of a gradient (ux,x ux,y uy,x uy,y)."""
POINTS = (-(3.0**-0.5), 3.0**-0.5)
RIGID = 1e-6  # of the highest frequency: the block slides freely, and that mode neither grows nor is damped


@dataclass(frozen=True)
class Block:
    """A rectangle of bilinear cells, plane strain: sides [mm], cells along them, Hooke's law [MPa], density [t/mm3]."""

    sides: tuple[float, float]
    cells: tuple[int, int]
    young: float
    poisson: float
    density: float


@dataclass(frozen=True)
class Flutter:
    """Fastest growing mode, and the damping that stops all modes.

    growth     largest without damping, in time [1/s]
    frequency  circular, of the mode that grows most [1/s]
    in_steps   growth of that mode in steps of central differences [1/s]
    damping    least rate [1/s] of damping -rate m v of all but the rigid motion at which no mode grows in such steps
    at         circular frequency [1/s] of the mode that needs it
    """

    growth: float
    frequency: float
    in_steps: float
    damping: float
    at: float


@lru_cache
def flutter(block: Block, mu: float, fraction: float = 0.9) -> Flutter:
    """Flutter of the block with Coulomb's `mu`, in steps of `fraction` of the longest stable one.

    Steps multiply a mode by z, z + 1/z = 2 - w^2 dt^2. A rate takes half of it from the growth, times the part of the
    mode that is not rigid, by its left and right vectors.
    """
    from scipy.linalg import eig

    stiffness, mass, places = _assembled(block)
    lower = np.arange(block.cells[0] + 1)
    sliding = stiffness.copy()
    sliding[2 * lower] += mu * stiffness[2 * lower + 1]
    free = np.setdiff1d(np.arange(len(mass)), 2 * lower + 1)
    root = np.sqrt(mass[free])
    squares, left, right = eig(sliding[np.ix_(free, free)] / np.outer(root, root), left=True)
    rigid = _rigid_motions(mass, places)[free]
    share = np.sum((rigid.T @ left).conj() * (rigid.T @ right), axis=0) / np.sum(left.conj() * right, axis=0)
    frequency = np.sqrt(squares.astype(complex))
    highest = np.abs(frequency).max()
    dt = fraction * 2.0 / highest
    half = 1.0 - 0.5 * squares * dt**2
    in_steps = np.abs(np.log(np.abs(half + np.sqrt(half**2 - 1.0 + 0.0j)))) / dt
    moving = np.abs(frequency) > RIGID * highest
    most = int(np.argmax(np.where(moving, np.abs(frequency.imag), 0.0)))
    needed = np.divide(in_steps, 0.5 * (1.0 - share.real), out=np.zeros_like(in_steps), where=moving)
    worst = int(np.argmax(needed))
    return Flutter(
        float(abs(frequency[most].imag)), float(frequency[most].real), float(in_steps[most]),
        float(needed[worst]), float(frequency[worst].real),
    )  # fmt: skip


def _assembled(block: Block) -> tuple[Floats, Floats, Floats]:
    """Stiffness (2 n, 2 n), lumped masses (2 n,) and places (n, 2) of the nodes, lower side first."""
    across, up = block.cells
    wide, high = block.sides[0] / across, block.sides[1] / up
    y, x = np.meshgrid(np.arange(up + 1) * high, np.arange(across + 1) * wide, indexing="ij")
    stiffness, mass = np.zeros((2 * x.size, 2 * x.size)), np.zeros(2 * x.size)
    cell = _cell(block, wide, high)
    for row in range(up):
        for column in range(across):
            first = row * (across + 1) + column
            nodes = np.array([first, first + 1, first + across + 2, first + across + 1])
            unknowns = np.stack([2 * nodes, 2 * nodes + 1], axis=1).ravel()
            stiffness[np.ix_(unknowns, unknowns)] += cell
            mass[unknowns] += block.density * wide * high / 4.0
    return stiffness, mass, np.stack([x.ravel(), y.ravel()], axis=1)


def _cell(block: Block, wide: float, high: float) -> Floats:
    """Stiffness (8, 8) of a rectangle with 2 x 2 points."""
    shear = block.young / (2.0 * (1.0 + block.poisson))
    law = np.diag([2.0 * shear, 2.0 * shear, shear])
    law[:2, :2] += 2.0 * shear * block.poisson / (1.0 - 2.0 * block.poisson)
    xs, ys = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    total = np.zeros((8, 8))
    for a in POINTS:
        for b in POINTS:
            slopes = np.array([xs * (1.0 + b * ys) / (2.0 * wide), ys * (1.0 + a * xs) / (2.0 * high)])
            gradient = np.zeros((4, 8))
            gradient[:2, 0::2] = gradient[2:, 1::2] = slopes
            strain = STRAINS @ gradient
            total += strain.T @ law @ strain * (wide * high / 4.0)
    return total


def _rigid_motions(mass: Floats, places: Floats) -> Floats:
    """Three rigid motions (2 n, 3), orthonormal in the masses, times the roots of the masses."""
    x, y = places.T
    motions = np.zeros((len(mass), 3))
    motions[0::2, 0] = motions[1::2, 1] = 1.0
    motions[0::2, 2], motions[1::2, 2] = -y, x
    return np.asarray(np.linalg.qr(np.sqrt(mass)[:, None] * motions)[0])
