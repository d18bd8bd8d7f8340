"""Cells of four nodes that bend: how far the energy of their bending is from the energy of a cell that can bend.

A bilinear cell has two modes beyond constant strain, u = h xi eta. If it is bent along xi by such a mode, exact
stresses are linear across the cell and vanish on its sides along xi: the energy is the energy of a beam,

    B = A E'/6 sum_k ((h . x_k) / |x_k|^2)^2,    x_1 = dx/dxi, x_2 = dx/deta, E' = E/(1 - nu^2),

which is also the energy with Wilson's incompatible modes. The element's own energy V of the stresses that vary within
the cell differs: fully integrated elements add shear that no beam has (and, in incompressible materials, pressure),
elements with averaged volume or one point lack a part, and hourglass control replaces it by a stiffness of its own.
With W the energy of all stresses, displacements under given loads are wrong by the share (B - V)/W: a cantilever of
20 x 1 cells by -33 % with q1, by +1230 % with q1-reduced, as observed.

Near a concentrated load cells lack stiffness by their stress, and have too much by their shape. So four times the
energy of what stresses jump between cells is taken from a positive B - V: in beams they do not jump.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Floats, RunWarning
from contactlab.api.arrays import Flags
from contactlab.missing_effects.locking import PLASTIC
from contactlab.missing_effects.missing_effect import Detectors, needed, per_cent
from contactlab.model.bodies.body import Block, Body, BodyForces
from contactlab.model.model import Model

WRONG = 0.05  # of displacements
SMALL = 0.25  # of the kinetic energy
LITTLE = 0.1  # of the energy of all such bodies: what one with less of it lacks is measured against so much
UNSEEN = 4.0  # times the energy of jumps: averages at nodes do not see what all cells there lack
NO_STRAIN = 1e-7  # energies of smaller strains are round-off
MODE = np.array([1.0, -1.0, 1.0, -1.0]) / 4.0  # of xi eta, over the corners of a cell


def bending_detectors(scene: object, model: Model) -> Detectors:
    """Detectors for bodies of four-node cells whose law is elastic, or says where it yields."""
    del scene
    found: list[Bending] = []
    for forces in model.forces:
        law = forces.body.material
        if len(forces.body.element.nodes) == len(MODE) and (not law.history_size or PLASTIC in law.history_names):
            found.append(Bending(forces, model, found))
    yield from found


class Bending:
    """`worst`: largest and smallest B - V, largest W and hourglass energy, and largest kinetic energy of the run [mJ].

    Bodies that fly or rock hold little energy in their strains: how large an error these have decides little there.
    A stiff body next to a soft body holds little energy, too. `every` holds the detectors of all bodies.
    """

    def __init__(self, forces: BodyForces, model: Model, every: Sequence[Bending]) -> None:
        self.forces, self.model, self.every, self.worst = forces, model, every, np.zeros(5)
        body = forces.body
        area = float(sum(forces.determinants(block, np.zeros((1, 2))).sum() for block in forces.blocks)) * 4.0
        self.nothing = 0.5 * NO_STRAIN**2 * body.dilatational_modulus * area

    def update(self) -> None:
        """Take in the energies of the last accepted step."""
        now = self.forces, self.model.reference, self.model.state["displacement"]
        lacking, total = bending_energies(*now)
        hourglass = self.forces.numerical_energy()
        lacking, total = lacking - hourglass, total + hourglass
        if lacking > WRONG * total:
            lacking -= min(lacking, UNSEEN * jump_energy(*now))
        kinetic = self.model.kinetic_energy() if self.model.integrator.inertia else 0.0
        self.worst[0] = max(self.worst[0], lacking)
        self.worst[1] = min(self.worst[1], lacking)
        self.worst[2:] = np.maximum(self.worst[2:], (total, hourglass, kinetic))

    def warning(self) -> RunWarning | None:
        """Advise an element that bends, or finer cells; None if neither is needed."""
        soft, stiff, total, hourglass, kinetic = (float(value) for value in self.worst)
        if total <= max(self.nothing, SMALL * kinetic):
            return None
        total = max(total, LITTLE * sum(float(body.worst[2]) for body in self.every))
        soft, stiff, hourglass = soft / total, stiff / total, hourglass / total
        error = stiff if -stiff > soft else soft
        if hourglass > WRONG:
            seen = f"hourglass modes, which the element resists by an artificial stiffness, hold {per_cent(hourglass)} "
            return self.advice("hourglass", hourglass, f"{seen}of its strain energy", error)
        if abs(error) <= WRONG:
            return None
        bends = "its cells bend, and its element is too"
        if error < 0.0:
            return self.advice("locking", -error, f"{bends} stiff in bending", error)
        return self.advice("soft-bending", error, f"{bends} soft in bending", error)

    def advice(self, code: str, value: float, seen: str, error: float) -> RunWarning:
        """Warn of what was `seen`, of displacements that are wrong by `error`, and name an element that bends."""
        body = self.forces.body
        key = f"bodies.{body.name}.element"
        far = f"about {per_cent(abs(error))} too {'small' if error < 0.0 else 'large'}"
        other = body.element.beyond.get("quadratic shape functions")
        cells = f"cells {_finer(max(value, abs(error)))} times as short in both directions"
        return needed(
            code, value, WRONG, key,
            f"body {body.name}: {seen}; displacements under given loads are {far} (limit {per_cent(WRONG)})",
            f'write {key} = "{other}", or take {cells}' if other else f"take {cells}, or an element that bends",
        )  # fmt: skip


def _finer(error: float) -> str:
    """Factor to divide lengths by: errors go with their square; of a part e of all energy, e/(1 - e) does."""
    share = error / max(1.0 - error, 1e-3) if error < 1.0 else error
    return f"{math.ceil(10.0 * math.sqrt(share * (1.0 - WRONG) / WRONG)) / 10.0:.2g}"


class _Bent(NamedTuple):
    """Cells of a block: stress (4, q, n), its mean (4, n), volumes (q, n) [mm2], areas (n,), directions (n, 2, 2) along
    xi and eta, and of the bending along each the stress (n, 2) [MPa] at a side."""

    block: Block
    stress: Floats
    mean: Floats
    volume: Floats
    area: Floats
    along: Floats
    bending: Floats


def _bent(forces: BodyForces, reference: Floats, displacement: Floats) -> Iterator[_Bent]:
    """The blocks of a body.

    Modes are measured by gamma vectors (Flanagan & Belytschko 1981): nothing of a homogeneous deformation or of a
    rotation, however large, is in them.
    """
    body = forces.body
    rule = body.element.quadrature()
    centre = body.shape_gradients(np.zeros((1, 2)))[0]
    for block in forces.current():
        before = reference[block.connectivity]
        now = before + displacement[block.connectivity]
        at_start, deformed, tangents = (
            np.einsum("anj,ak->nkj", x, centre) for x in (before, now, forces.geometry[block.connectivity])
        )
        gradient = np.linalg.solve(at_start, deformed)  # of positions now by those before, transposed
        warped, mode = (np.einsum("a,anj->nj", MODE, x) for x in (before, now))
        mode -= np.einsum("ni,nij->nj", warped, gradient)
        square = (tangents**2).sum(axis=2)
        bending = _beam_modulus(body) * np.einsum("nj,nkj->nk", mode, tangents) / square
        stress = block.stress.reshape(4, len(rule.weights), -1)
        volume = np.abs(forces.determinants(block, rule.points)) * rule.weights[:, None]
        mean = (stress * volume).sum(axis=1) / volume.sum(axis=0)
        area = 4.0 * np.abs(np.linalg.det(tangents))
        yield _Bent(block, stress, mean, volume, area, tangents / np.sqrt(square)[:, :, None], bending)


def bending_energies(forces: BodyForces, reference: Floats, displacement: Floats) -> tuple[float, float]:
    """B - V and W [mJ] of a body, without the energy of hourglass control; B - V of cells that have not yielded.

    Energies of stresses use the law at the undeformed state.
    """
    body, lacking, total = forces.body, 0.0, 0.0
    for bent in _bent(forces, reference, displacement):
        beams = bent.area * (bent.bending**2).sum(axis=1) / (6.0 * _beam_modulus(body))
        varying = (_energy(body, bent.stress - bent.mean[:, None]) * bent.volume).sum(axis=0)
        lacking += float((beams - varying)[_elastic(body, bent.block)].sum())
        total += float((_energy(body, bent.stress) * bent.volume).sum())
    return lacking, total


def jump_energy(forces: BodyForces, reference: Floats, displacement: Floats) -> float:
    """Energy [mJ] of what mean stress and bending leave of the stress that is averaged at nodes: none in a beam."""
    body = forces.body
    corners, areas, seen = np.zeros((4, len(reference))), np.zeros(len(reference)), []
    for bent in _bent(forces, reference, displacement):
        x, y = bent.along[..., 0], bent.along[..., 1]
        # Poisson's ratio of the undeformed material
        ratio = body.shear_modulus / body.dilatational_modulus
        poisson = (1.0 - 2.0 * ratio) / (2.0 - 2.0 * ratio)
        parts = np.stack([x**2, y**2, np.full_like(x, poisson), x * y])
        # bending along xi is linear in eta, and the other way round
        own = [bent.mean + (parts * bent.bending * place[::-1]).sum(axis=2) for place in body.element.nodes]
        for nodes, stress in zip(bent.block.connectivity, own, strict=True):
            np.add.at(areas, nodes, bent.area)
            for row, values in zip(corners, stress * bent.area, strict=True):
                np.add.at(row, nodes, values)
        seen.append((bent.block.connectivity, np.stack(own), bent.area))
    corners /= np.maximum(areas, 1e-300)
    total = 0.0
    for nodes, stresses, area in seen:
        apart = corners[:, nodes].transpose(1, 0, 2) - stresses
        mean = apart.mean(axis=0)
        linear = sum(_energy(body, part - mean) for part in apart) / 12.0  # a quarter each, a third of its square
        total += float(((_energy(body, mean) + linear) * area).sum())
    return total


def _elastic(body: Body, block: Block) -> Flags:
    """Mask of the cells of a block that have not yielded at any point."""
    if not body.material.history_size:
        return np.ones(block.connectivity.shape[1], np.bool_)
    flow = block.history[body.material.history_names.index(PLASTIC)]
    return np.asarray(~flow.reshape(body.points, -1).any(axis=0))


def _beam_modulus(body: Body) -> float:
    """E/(1 - nu^2) [MPa] of the undeformed material."""
    shear, dilatational = body.shear_modulus, body.dilatational_modulus
    return 4.0 * shear * (dilatational - shear) / dilatational


def _energy(body: Body, stress: Floats) -> Floats:
    """Elastic energy [mJ/mm3] of stresses (4, ...) by the undeformed law's moduli."""
    shear = body.shear_modulus
    bulk = body.dilatational_modulus - 4.0 / 3.0 * shear
    pressure = (stress[XX] + stress[YY] + stress[ZZ]) / 3.0
    deviator = (stress[[XX, YY, ZZ]] - pressure) ** 2
    return np.asarray((deviator.sum(axis=0) + 2.0 * stress[XY] ** 2) / (4.0 * shear) + pressure**2 / (2.0 * bulk))
