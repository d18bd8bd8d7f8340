"""Laws that are used beyond what they hold for: small strain, and no yielding."""

from __future__ import annotations

import math

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Floats, RunWarning
from contactlab.missing_effects.missing_effect import Detectors, needed, per_cent
from contactlab.model.bodies.body import Block, BodyForces
from contactlab.model.model import Model

STRAIN = 0.05  # largest principal strain of small-strain laws
ROTATION = math.radians(5.0)  # it adds about 1 - cos(5 degrees) = 0.4 % of false strain
TORQUE = 0.01  # of the moments of its forces: in a stretched bar the rotation; friction errs by that over mu
LEFT_OUT = 0.5 * STRAIN  # of the strain energy, as if half of it were where strains are that large


def strain_detectors(scene: object, model: Model) -> Detectors:
    """Detectors for bodies with a small-strain law, and at those whose law knows an elastic limit."""
    for forces in model.forces:
        law = forces.body.material
        key = f"materials.{scene.bodies[forces.body.name].material}"  # type: ignore[attr-defined]
        if law.kinematics == "small":
            yield LargeStrain(forces, key)
        if math.isfinite(law.elastic_limit()):
            yield UnusedYieldStress(forces, key)


class LargeStrain:
    """`worst`: largest principal strain [-] and rotation [rad] of any point; largest work [mJ] of the stresses on the
    strain that the law leaves out, and largest strain energy [mJ] of the body; largest torque [N mm] of the stresses
    about the deformed body, and largest moment of all of them.

    Forces on a deformed body have no torque in equilibrium; small-strain laws balance them where it was at the start.
    Such a law leaves H^T H/2 out of the strain, H = du/dX: the share of that work is the strain in a stretched bar, and
    above one in a body that turns. Few points at an edge of contact add little to it, and change no force.
    """

    def __init__(self, forces: BodyForces, key: str) -> None:
        self.forces, self.key, self.worst = forces, key, np.zeros(6)

    def update(self) -> None:
        """Strain, rotation, energies and torque from the displacement gradients of the last update."""
        left_out = energy = torque = moment = 0.0
        for block, volume in self.forces.current_volumes():
            np.maximum(self.worst[:2], _strain_and_rotation(block.gradient), out=self.worst[:2])
            works = _works(block)
            left_out += float(np.abs(works[0]) @ volume)
            energy += float(0.5 * np.abs(works[1]) @ volume)
            # per volume, of symmetric stresses that act on the undeformed body
            (xx, xy, yx, yy), stress = block.gradient, block.stress
            torque += float((stress[XX] * yx - stress[YY] * xy + stress[XY] * (yy - xx)) @ volume)
            moment += float((np.abs(block.stress[[XX, YY, XY, XY]]) @ volume).sum())
        np.maximum(self.worst[2:], (left_out, energy, abs(torque), moment), out=self.worst[2:])

    def warning(self) -> RunWarning | None:
        """Advise a law for finite strain, once strains are large where much of the energy is; None before."""
        strain, rotation, left_out, energy, torque, moment = (float(value) for value in self.worst)
        if left_out <= LEFT_OUT * energy:
            return None
        turned = f"rotations reach {math.degrees(rotation):.1f} degrees"
        if strain > STRAIN:
            value, limit, seen = strain, STRAIN, f"strains reach {per_cent(strain)}"
        elif rotation > ROTATION:
            value, limit, seen = rotation, ROTATION, turned
        elif torque > TORQUE * moment:
            value, limit = torque / moment, TORQUE
            seen = f"{turned}, and its forces have a torque of {per_cent(value)} of their moments"
        else:
            return None
        return needed(
            "finite-strain",
            value,
            limit,
            self.key,
            f"body {self.forces.body.name}: {seen}, but its law is for small strains (5 % and 5 degrees)",
            _other_law(self.key, self.forces.body.material.beyond.get("finite strain"), "a law for finite strain"),
        )


def _strain_and_rotation(gradient: Floats) -> tuple[float, float]:
    """Largest |principal strain| and |angle of the polar decomposition| of du/dX (4, P)."""
    xx, xy, yx, yy = gradient
    mean, radius = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), 0.5 * (xy + yx))
    angle = np.arctan2(yx - xy, 2.0 + xx + yy)
    return float((np.abs(mean) + radius).max()), float(np.abs(angle).max())


def _works(block: Block) -> tuple[Floats, Floats]:
    """Stress times H^T H/2 and times the small strain (P,) [MPa], of H = du/dX."""
    (xx, xy, yx, yy), stress = block.gradient, block.stress
    left_out = 0.5 * (stress[XX] * (xx**2 + yx**2) + stress[YY] * (xy**2 + yy**2)) + stress[XY] * (xx * xy + yx * yy)
    return left_out, stress[XX] * xx + stress[YY] * yy + stress[XY] * (xy + yx)


class UnusedYieldStress:
    """`worst`: largest von Mises stress [MPa] of any point."""

    def __init__(self, forces: BodyForces, key: str) -> None:
        self.forces, self.key, self.worst = forces, key, np.zeros(1)

    def update(self) -> None:
        """Keep the largest von Mises stress of the last accepted step."""
        for block in self.forces.current():
            s = block.stress
            deviator = (s[XX] - s[YY]) ** 2 + (s[YY] - s[ZZ]) ** 2 + (s[ZZ] - s[XX]) ** 2
            self.worst[0] = max(self.worst[0], float(np.sqrt(0.5 * deviator + 3.0 * s[XY] ** 2).max()))

    def warning(self) -> RunWarning | None:
        """Advise a plastic law if stresses exceed what the material is known to bear; None before."""
        law, stress = self.forces.body.material, float(self.worst[0])
        if stress <= law.elastic_limit():
            return None
        return needed(
            "plasticity",
            stress,
            law.elastic_limit(),
            self.key,
            f"body {self.forces.body.name}: the von Mises stress reaches {stress:.4g}, its yield stress is "
            f"{law.elastic_limit():.4g} and its law does not yield",
            _other_law(self.key, law.beyond.get("plasticity"), "a law that yields"),
        )


def _other_law(key: str, name: str | None, otherwise: str) -> str:
    return f'write {key}.use = "{name}"' if name else f"use {otherwise} in {key}"
