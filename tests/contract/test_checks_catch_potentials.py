"""Every check of potentials catches a planted defect, and a right one passes all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from contactlab_segments.midplane import Midplane

from contactlab.api import Floats, NodalForces, Potential, PotentialView
from contactlab.testing import Expected, NotApplicable, potential
from contactlab.testing.assertions import Check


@dataclass(frozen=True)
class Flawed(Midplane):
    """Contact on the common line with one named flaw."""

    flaw: str = ""
    calls: ClassVar[list[int]] = [0]

    def clearance(self, view: PotentialView) -> float:
        return 0.05 * float(view.length.min()) if self.flaw == "keeps a distance and passes through" else 0.0

    def energy(self, view: PotentialView, positions: Floats) -> float:
        found = super().energy(view, positions)
        if self.flaw == "energy of one place":
            found *= 1.0 + 1e-3 * positions[0, 0]
        return found

    def gradient(self, view: PotentialView, positions: Floats) -> Floats:
        found, m = super().gradient(view, positions), len(view.slave.nodes)
        if self.flaw == "one per cent too strong":
            found = 1.01 * found
        if self.flaw == "pulls":
            found = -found
        if self.flaw == "master pushed too little":
            found[m:] *= 0.999
        if self.flaw == "pushes beside its contact":
            found[:, 1] += 1e-3 * np.sign(np.arange(len(found)) - m + 0.5)
        if self.flaw == "stronger to the right":
            found = found * (1.0 + 1e-6 * (positions[:, :1] - positions[:, 0].mean()))
        if self.flaw == "forces along the axes":
            found[:, 0] = 0.0
        if self.flaw == "counts its calls":
            self.calls[0] += 1
            found = found * (1.0 + 1e-14 * self.calls[0])
        if self.flaw == "positions written":
            positions[0] += 1e-12
        return found

    def hessian(self, view: PotentialView, positions: Floats) -> Any:
        found = super().hessian(view, positions)
        if self.flaw == "half of the Hessian":
            return 0.5 * found
        if self.flaw == "rows without columns":
            found = found.tolil()
            found[0, :] = 0.0
            return found.tocsr()
        return found

    def largest_step(self, view: PotentialView, positions: Floats, displacement: Floats) -> float:
        if self.flaw == "keeps a distance and passes through":
            return 1.0
        found = super().largest_step(view, positions, displacement)
        return 0.5 * found if self.flaw == "cuts all motions" else found

    def friction_gradient(self, view: PotentialView, positions: Floats) -> Floats:
        found, m = super().friction_gradient(view, positions), len(view.slave.nodes)
        if self.flaw == "friction that drives":
            found = -found
        if self.flaw == "rubs too much":
            found = 1.1 * found
        if self.flaw == "rubs the slave alone":
            found[m:] = 0.0
        if self.flaw == "rubs at rest":
            found = found + 1e-3 * np.sign(np.arange(len(found)) - m + 0.5)[:, None]
        return found

    def friction_hessian(self, view: PotentialView, positions: Floats) -> Any:
        found = super().friction_hessian(view, positions)
        return 0.0 * found if self.flaw == "friction without stiffness" else found

    def nodal_forces(self, view: PotentialView, positions: Floats) -> NodalForces:
        found = super().nodal_forces(view, positions)
        if self.flaw == "shows twice the push":
            return found._replace(push=2.0 * found.push)
        if self.flaw == "shears turned round":
            return found._replace(rub=-found.rub)
        if self.flaw == "pressures that lean":
            return found._replace(push=found.push * np.linspace(0.999, 1.001, len(found.push))[:, None])
        return found


WRONG: list[tuple[Check, str]] = [
    (potential.gradient_is_the_derivative, "one per cent too strong"),
    (potential.hessian_is_the_derivative, "half of the Hessian"),
    (potential.hessian_is_the_derivative, "rows without columns"),
    (potential.forces_balance, "pulls"),
    (potential.forces_balance, "master pushed too little"),
    (potential.patch_test, "stronger to the right"),
    (potential.patch_test, "pressures that lean"),
    (potential.shown_forces_sum_to_those_that_act, "shows twice the push"),
    (potential.shown_forces_sum_to_those_that_act, "shears turned round"),
    (potential.rigid_motions_keep_the_energy, "energy of one place"),
    (potential.rigid_motions_keep_the_energy, "forces along the axes"),
    (potential.no_force_when_apart, "pushes beside its contact"),
    (potential.no_force_when_apart, "cuts all motions"),
    (potential.steps_end_before_surfaces_meet, "keeps a distance and passes through"),
    (potential.friction_opposes_slip, "friction that drives"),
    (potential.friction_opposes_slip, "rubs too much"),
    (potential.friction_opposes_slip, "rubs the slave alone"),
    (potential.friction_opposes_slip, "rubs at rest"),
    (potential.friction_hessian_is_the_derivative, "friction without stiffness"),
    (potential.arrays_are_only_read, "counts its calls"),
    (potential.arrays_are_only_read, "positions written"),
]


@pytest.mark.parametrize("check", potential.CHECKS)
def test_a_right_potential_passes(check: Check) -> None:
    try:
        check(Midplane())
    except NotApplicable:
        assert check is potential.steps_end_before_surfaces_meet


@pytest.mark.parametrize(("check", "flaw"), WRONG)
def test_a_planted_defect_is_caught(check: Check, flaw: str) -> None:
    with pytest.raises(AssertionError):
        check(Flawed(flaw=flaw))


def test_every_check_catches_one() -> None:
    assert {check for check, _ in WRONG} == set(potential.CHECKS)


def test_a_potential_that_fails_the_patch_test_may_say_so() -> None:
    said: Any = type("Said", (Flawed,), {"passes_patch_test": False, "__module__": __name__})
    part: Potential = said(flaw="stronger to the right")
    with pytest.raises((NotApplicable, Expected)):
        potential.patch_test(part)
