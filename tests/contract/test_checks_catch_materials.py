"""Every check of materials catches a planted defect, and right laws in plain NumPy pass all of them."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import pytest

from contactlab.api import UNIT, Floats, Kinematics, Material, formula
from contactlab.testing import NotApplicable, material, material_states, material_waves, scales
from contactlab.testing.assertions import Check
from contactlab.testing.points import DT

LAME, SHEAR = 1.5, 1.0
RHO = 2.0
SPEEDS = (float(np.sqrt((LAME + 2 * SHEAR) / RHO)), float(np.sqrt(SHEAR / RHO)))


def hooke(xx: Floats, yy: Floats, xy: Floats) -> Floats:
    """Stress rows of strains; xy is the tensor component."""
    pressure = LAME * (xx + yy)
    return np.stack([pressure + 2 * SHEAR * xx, pressure + 2 * SHEAR * yy, pressure, 2 * SHEAR * xy])


@dataclass(frozen=True)
class Small(Material):
    """Hooke's law with one named flaw, or none."""

    flaw: str = ""
    density: float = RHO
    seen: ClassVar[dict[int, Floats]] = {}
    room: ClassVar[Floats] = np.zeros(1000)
    kinematics: ClassVar[Kinematics] = "small"
    has_energy: ClassVar[bool] = True

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        xx, xy, yx, yy = gradient
        stress[:] = hooke(xx, yy, xy if self.flaw == "strain not symmetrised" else 0.5 * (xy + yx))
        if self.flaw == "prestressed":
            stress += 1e-6
        if self.flaw == "depends on its neighbours" and stress.shape[1]:
            stress += 1e-14 * gradient[0].mean()
        if self.flaw == "asks for the largest":
            stress *= 1.0 + 0.0 * gradient.max()
        if self.flaw == "creeps":
            stress /= 1.0 + dt
        if self.flaw == "gradient centred in place":
            gradient -= gradient.mean()
        if self.flaw == "forgets a row":
            stress[2] = np.nan
        if self.flaw == "stiffer along x":
            stress[0] += 0.1 * xx
        if self.flaw == "nothing across the plane":
            stress[2] = 0.0
        if self.flaw == "knows its array again":
            seen = self.seen.setdefault(gradient.__array_interface__["data"][0], stress.copy())
            stress[:] = seen
        if self.flaw == "one room for all threads":
            self.room[: stress.shape[1]] = xx
            time.sleep(1e-3)
            stress[0] += self.room[: stress.shape[1]] - xx

    def wave_speeds(self) -> tuple[float, float]:
        young = SHEAR * (3 * LAME + 2 * SHEAR) / (LAME + SHEAR)
        if self.flaw == "speed of a bar":
            return float(np.sqrt(young / RHO)), SPEEDS[1]
        return (SPEEDS[1], SPEEDS[0]) if self.flaw == "speeds exchanged" else SPEEDS

    def tangent(self, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
        super().tangent(gradient, history, dt, tangent)
        if self.flaw == "tangent without coupling":
            tangent[2] = 0.0

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        xx, yy, xy = gradient[0], gradient[3], 0.5 * (gradient[1] + gradient[2])
        shear = 1.0 if self.flaw == "shear energy halved" else 2.0
        energy[:] = 0.5 * LAME * (xx + yy) ** 2 + SHEAR * (xx**2 + yy**2 + shear * xy**2)
        if self.flaw == "energy at rest":
            energy += 1.0

    def dissipation(self, gradient: Floats, history: Floats, dissipation: Floats) -> None:
        dissipation[:] = 0.1 * gradient[0] ** 2 if self.flaw == "dissipates what it stores" else 0.0


class Unnamed(Small):
    """Remembers a number that has no name."""

    history_size: ClassVar[int] = 1


@dataclass(frozen=True)
class Finite(Material):
    """The compressible neo-Hookean law from F itself, with one named flaw, or none."""

    flaw: str = ""
    density: float = RHO
    kinematics: ClassVar[Kinematics] = "finite"
    has_energy: ClassVar[bool] = True

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        f, j = self._deformation(gradient)
        left = np.einsum("pji,pjk->pik" if self.flaw == "right Cauchy-Green tensor" else "pij,pkj->pik", f, f)
        stress[0], stress[1] = SHEAR * (left[:, 0, 0] - 1), SHEAR * (left[:, 1, 1] - 1)
        stress[2], stress[3] = 0.0, SHEAR * left[:, 0, 1]
        stress[:3] += LAME * np.log(j)
        stress /= j

    @staticmethod
    def _deformation(gradient: Floats) -> tuple[Floats, Floats]:
        f = np.linalg.inv(np.ascontiguousarray(gradient.T).reshape(-1, 2, 2))
        return f, np.linalg.det(f)

    def wave_speeds(self) -> tuple[float, float]:
        return SPEEDS

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        f, j = self._deformation(gradient)
        energy[:] = 0.5 * SHEAR * ((f**2).sum(axis=(1, 2)) - 2 - 2 * np.log(j)) + 0.5 * LAME * np.log(j) ** 2
        if self.flaw != "energy per undeformed volume":
            energy /= j

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        if self.flaw == "never stiffens":
            out[:] = 1.0
            return
        f, j = self._deformation(gradient)
        # the moduli are at most those of the largest principal stretch, over the volume
        stretch = np.linalg.svd(f, compute_uv=False)[:, 0]
        out[:] = (np.maximum(stretch**2, 1.0) + np.maximum(-np.log(j), 0.0)) / np.minimum(j, 1.0)


@dataclass(frozen=True)
class Rate(Material):
    """Hooke's law in rate form, turned by Hughes & Winget's rotation; its stress is its history."""

    flaw: str = ""
    density: float = RHO
    kinematics: ClassVar[Kinematics] = "rate"
    history_size: ClassVar[int] = 4
    history_names: ClassVar[tuple[str, ...]] = ("xx", "yy", "zz", "xy")
    calls: ClassVar[list[int]] = [0]

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        xx, xy, yx, yy = gradient
        stress[:] = hooke(xx, yy, 0.5 * (xy + yx))
        if self.flaw == "history written first":
            new_history[:] = stress
        half = np.zeros_like(xx) if self.flaw == "no rotation" else 0.25 * (yx - xy)
        cos, sin = (1 - half**2) / (1 + half**2), 2 * half / (1 + half**2)
        a, b, c = history[0], history[1], history[3]
        turned = np.stack(
            [
                cos**2 * a + sin**2 * b - 2 * sin * cos * c,
                sin**2 * a + cos**2 * b + 2 * sin * cos * c,
                history[2],
                sin * cos * (a - b) + (cos**2 - sin**2) * c,
            ]
        )
        stress += turned
        if self.flaw == "counts its calls":
            self.calls[0] += 1
            stress += 1e-9 * self.calls[0]
        new_history[:] = stress

    def wave_speeds(self) -> tuple[float, float]:
        return SPEEDS

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        largest = np.abs(stress).max(axis=0) if self.flaw != "never stiffens" else 0.0
        out[:] = 1.0 + 4.0 * largest / SHEAR


@dataclass(frozen=True)
class Softened(Finite):
    """The neo-Hookean law over 1 + d, where d is the largest strain so far: the stress has a kink where it grows."""

    history_size: ClassVar[int] = 1
    history_names: ClassVar[tuple[str, ...]] = ("d",)
    has_energy: ClassVar[bool] = False

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        grown = np.maximum(history[0], self._strain(gradient))
        super().stress(gradient, history, dt, stress, new_history)
        stress /= 1.0 + grown
        new_history[0] = grown

    def _strain(self, gradient: Floats) -> Floats:
        f, _ = self._deformation(gradient)
        strain = 0.5 * (np.einsum("pji,pjk->pik", f, f) - np.eye(2))
        return np.asarray(np.sqrt((strain**2).sum(axis=(1, 2))))

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        super().stiffening(gradient, stress, out)
        if self.flaw == "counts on what was lost":
            out /= 2.0 * (1.0 + self._strain(gradient))


@dataclass(frozen=True)
class Formulas(Material):
    """Hooke's law by formulas, whose stress is also given by hand."""

    density: float = RHO
    shear: float = SHEAR

    @formula
    def stress(H: Any, p: Any) -> Any:
        return LAME * H.trace() * UNIT + 2.0 * p.shear * H.symmetric()

    def stress_by_hand(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        xx, xy, yx, yy = gradient
        pressure = LAME * (xx + yy)
        stress[:] = pressure + 2 * self.shear * xx, pressure + 2 * self.shear * yy, pressure, self.shear * (xy + yx)

    @formula
    def energy(H: Any, p: Any) -> Any:
        return 0.5 * LAME * H.trace() * H.trace() + p.shear * H.symmetric().dot(H.symmetric())


@dataclass(frozen=True)
class OtherByHand(Formulas):
    """The stress by hand is a little off."""

    @formula
    def stress(H: Any, p: Any) -> Any:
        return LAME * H.trace() * UNIT + 2.00001 * p.shear * H.symmetric()


@dataclass(frozen=True)
class Thick(Small):
    """It is stiffer across the plane."""

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        super().stress(gradient, history, dt, stress, new_history)
        stress[2] *= 1.001


@dataclass(frozen=True)
class Unheated(Formulas):
    """It needs a temperature, and has no thermal strain."""

    needs: ClassVar[tuple[str, ...]] = ("temperature",)


@dataclass(frozen=True)
class Renamed(Formulas):
    """What it calls Young's modulus is its shear modulus."""

    young: float = 1000.0
    poisson: float = 0.3

    @formula
    def stress(H: Any, p: Any) -> Any:
        return LAME * H.trace() * UNIT + 2.0 * p.young * H.symmetric()

    stress_by_hand = None


RIGHT: tuple[Material, ...] = (Small(), Finite(), Rate(), Formulas())


@pytest.mark.parametrize("check", material.CHECKS)
@pytest.mark.parametrize("part", RIGHT, ids=lambda part: type(part).__name__)
def test_right_laws_pass(part: Material, check: Check) -> None:
    try:
        check(part)
    except NotApplicable as reason:
        declined = {material.stiffening_bounds_the_waves, material.history_in_place}
        declined |= {material_waves.flow_is_of_second_order, scales.scales_are_fields}
        declined |= {material.needs_count, material.young_and_poisson_are_meant}
        declined |= {material.formulas_are_what_runs} if not isinstance(part, Formulas) else set()
        if part.kinematics == "rate":
            declined |= {material.energy_is_positive, material.energy_belongs_to_the_stress}
            declined |= {material_states.work_is_stored_or_dissipated}
        assert check in declined, reason


@dataclass(frozen=True)
class Creeping(Small):
    """Hooke's law whose shear relaxes: v' = (gamma - v)/(3 DT), by implicit Euler steps."""

    history_size: ClassVar[int] = 1
    history_names: ClassVar[tuple[str, ...]] = ("v",)
    rate_dependent: ClassVar[bool] = True
    implicit_euler: ClassVar[bool] = True

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        super().stress(gradient, history, dt, stress, new_history)
        ratio, gamma = dt / (3.0 * DT), gradient[1] + gradient[2]
        if self.flaw == "flows at the rate of the start":
            new_history[0] = history[0] + ratio * (gamma - history[0])
        else:
            new_history[0] = (history[0] + ratio * gamma) / (1.0 + ratio)
        stress[3] -= SHEAR * new_history[0]


def test_implicit_euler_steps_are_integrated_to_second_order() -> None:
    material_waves.flow_is_of_second_order(Creeping())


def test_unloading_waves_are_bounded_where_loading_softens() -> None:
    """The same law is right with the bound of its undamaged material."""
    material.stiffening_bounds_the_waves(Softened())


@dataclass(frozen=True)
class OfOneValue(Small):
    """Right as long as its stiffness is 1."""

    stiffness: float = field(kw_only=True)

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        super().stress(gradient, history, dt, stress, new_history)
        stress *= self.stiffness


@dataclass(frozen=True)
class Deaf(Small):
    """Has a hardening that nothing follows."""

    hardening: float = 500.0


@dataclass(frozen=True)
class Timed(Small):
    """Names a time that is no number above 0."""

    tau: float = 0.0
    time_scale: ClassVar[str] = "tau"


WRONG: list[tuple[Check, Material]] = [
    (material.other_values_are_right, OfOneValue(stiffness=1.0)),
    (material.numbers_count, Deaf()),
    (material.needs_count, Unheated()),
    (material_states.across_is_across, Thick()),
    (material.young_and_poisson_are_meant, Renamed()),
    (material.declarations, Unnamed()),
    (material.declarations, Small("speeds exchanged")),
    (material.no_stress_at_rest, Small("prestressed")),
    (material.speeds_belong_to_the_tangent, Small("speed of a bar")),
    (material.objectivity, Small("strain not symmetrised")),
    (material.objectivity, Finite("right Cauchy-Green tensor")),
    (material.objectivity, Rate("no rotation")),
    (material.tangent_is_the_derivative, Small("tangent without coupling")),
    (material.formulas_are_what_runs, OtherByHand()),
    (material.rate_is_declared, Small("creeps")),
    (material.energy_belongs_to_the_stress, Small("shear energy halved")),
    (material.energy_is_positive, Small("energy at rest")),
    (material.energy_belongs_to_the_stress, Finite("energy per undeformed volume")),
    (material.stiffening_bounds_the_waves, Finite("never stiffens")),
    (material.stiffening_bounds_the_waves, Rate("never stiffens")),
    (material.stiffening_bounds_the_waves, Softened("counts on what was lost")),
    (material.any_cut_gives_the_same, Small("depends on its neighbours")),
    (material.no_points_at_all, Small("asks for the largest")),
    (material.inputs_untouched, Small("gradient centred in place")),
    (material.inputs_untouched, Small("forgets a row")),
    (material.history_in_place, Rate("history written first")),
    (material.same_answer_twice, Rate("counts its calls")),
    (material_states.isotropy, Small("stiffer along x")),
    (material_states.plane_strain, Small("nothing across the plane")),
    (material_states.work_is_stored_or_dissipated, Small("dissipates what it stores")),
    (material_states.arrays_change_in_place, Small("knows its array again")),
    (material_waves.flow_is_of_second_order, Creeping("flows at the rate of the start")),
    (scales.scales_are_fields, Timed()),
    (material_states.threads_do_not_disturb_each_other, Small("one room for all threads")),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
def test_wrong_laws_are_caught(caught: Any, check: Check, part: Material) -> None:
    caught(check, part, raises=check is material.no_points_at_all)


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} == set(material.CHECKS)
