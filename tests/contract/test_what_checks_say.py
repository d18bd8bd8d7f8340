"""What checks say of parts that are right in their own way, or that the contract refuses before any check."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0
from contactlab_quads.q2 import Q2
from contactlab_segments.midplane import Midplane
from contactlab_segments.node_on_segment import NodeOnSegment
from from_source import subject_of

from contactlab.api import Floats, FrictionBound, FrictionLaw, Integrator, NormalLaw, formula
from contactlab.errors import WrongAnswer
from contactlab.parts.contract import faults
from contactlab.testing import (
    Expected,
    NotApplicable,
    checks_for,
    contact,
    effect,
    friction,
    integrator,
    integrator_contact,
    mesh,
    potential,
    run_check,
    run_checks,
)

PLAIN = "integrator outside plain-leapfrog/src/plain_leapfrog/integrator.py:PlainLeapfrog"


def made(base: str, folder: Path, *pieces: str) -> Any:
    return subject_of(base, folder, pieces).make()


# --- what is told, expected and left out ---------------------------------------------------------------


def test_all_checks_of_a_right_part_pass(tmp_path: Path) -> None:
    outcomes = run_checks("mesh", made("template mesh", tmp_path))
    assert [(o.status, o.reason) for o in outcomes] == [("passed", "")] * len(mesh.CHECKS)
    assert checks_for("viewer") == ()


def test_a_part_that_raises_has_failed() -> None:
    outcome = run_check(mesh.cells_are_sound, object())
    assert outcome.status == "failed"
    assert "AttributeError" in outcome.reason


def test_facts_that_are_not_declared_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    falling = made("template effect", tmp_path, "    conservative: ClassVar[bool] = True\n", "")
    outcome = run_check(effect.work_around_a_path_is_declared, falling)
    assert (outcome.status, outcome.reason) == ("passed", "declare conservative = True")
    monkeypatch.setattr(MortarP0, "passes_patch_test", False)  # a new class would compile its kernels
    outcome = run_check(contact.patch_test, MortarP0())
    assert outcome.status == "passed"
    assert "declare passes_patch_test" in outcome.reason


def test_a_bound_that_knows_a_direction_is_told() -> None:
    outcome = run_check(friction.slip_both_ways, Fur())
    assert outcome.status == "passed"
    assert "is an abs missing" in outcome.reason


@dataclass(frozen=True)
class Fur(FrictionLaw):
    """Half as much against the grain."""

    mu: float = 0.3
    needs: ClassVar[tuple[str, ...]] = ("slip_rate",)

    def bound(self, slip_rate: Any) -> FrictionBound:
        return FrictionBound(self.mu * np.where(slip_rate > 0.0, 1.0, 0.5), 0.0, 0.0)


def test_what_was_never_promised_is_expected() -> None:
    outcome = run_check(contact.patch_test, NodeOnSegment())
    assert outcome.status == "expected"
    assert "passes_patch_test is False" in outcome.reason
    said: Any = type("Said", (Midplane,), {"passes_patch_test": False, "gradient": leaning, "__module__": __name__})
    with pytest.raises((NotApplicable, Expected)):
        potential.patch_test(said())


def leaning(self: Any, view: Any, positions: Floats) -> Floats:
    """Forces that are stronger to the right."""
    found = Midplane.gradient(self, view, positions)
    return found * (1.0 + 1e-6 * (positions[:, :1] - positions[:, 0].mean()))


def test_a_scheme_that_says_so_may_lose_energy_and_never_gain_it(caught: Any, tmp_path: Path) -> None:
    says = "    order: ClassVar[int] = 2\n", "    order: ClassVar[int] = 2\n    dissipates: ClassVar[bool] = True\n"
    step = "        mean = 0.5 * (before + v)\n        reaction"
    integrator.energy_is_bounded(made(PLAIN, tmp_path, *says, step, f"        v *= 1.0 - 1e-5\n{step}"))
    caught(integrator.energy_is_bounded, made(PLAIN, tmp_path, *says, step, f"        v *= 1.0 + 1e-6\n{step}"))
    caught(integrator.energy_is_bounded, made(PLAIN, tmp_path, step, f"        v *= 1.0 - 1e-5\n{step}"))


def test_a_speed_that_decays_stands_if_the_scheme_declares_that_it_dissipates(tmp_path: Path) -> None:
    """What stands has a speed that falls by a share from step to step, as generalised-alpha does at rho = 0.8."""
    check = integrator_contact.friction_takes_the_energy_of_what_slides
    says = "    order: ClassVar[int] = 2\n", "    order: ClassVar[int] = 2\n    dissipates: ClassVar[bool] = True\n"
    end = "        return Step(work, reaction)"

    def left(share: str) -> tuple[str, str]:
        late = "self.state.step > 300 and np.abs(v[:, 0]).max() < 1e-5"
        return end, f"        if {late}:\n            v[:, 0] += 1e-6 * {share} ** (self.state.step - 300)\n{end}"

    assert run_check(check, made(PLAIN, tmp_path, *says, *left("0.98"))).status == "passed"
    assert "300 steps later" in run_check(check, made(PLAIN, tmp_path, *says, *left("1.0"))).reason
    assert "speed after friction has stopped" in run_check(check, made(PLAIN, tmp_path, *left("0.98"))).reason


def test_every_duty_of_the_base_class_has_a_check() -> None:
    numbers = [int(number) for number in re.findall(r"^ *(\d+)\. ", Integrator.__doc__ or "", re.MULTILINE)]
    assert numbers == list(range(1, len(numbers) + 1)) == list(integrator.DUTIES)
    assert all(integrator.DUTIES.values())


def test_a_scheme_without_an_order_is_refused_and_found(caught: Any, tmp_path: Path) -> None:
    fields = {"order": 0, "__module__": __name__}
    wrong: Any = type("NoOrder", (type(made(PLAIN, tmp_path)),), fields)
    assert faults("integrator", wrong)
    caught(integrator.declarations, wrong())


# --- what is refused ----------------------------------------------------------------------------------


def test_functions_that_drop_the_imaginary_part_are_refused() -> None:
    """Their gradients are found by complex steps."""

    class Compared(Q2):
        def functions(self, points: Floats) -> Floats:
            return np.abs(super().functions(points))

    with pytest.raises(WrongAnswer, match="functions gave real numbers at complex points"):
        Compared().shape(np.zeros((1, 2)))


@dataclass(frozen=True)
class Worn(FrictionLaw):
    """A right law with memory."""

    needs = ("slip_rate", "dt")
    memory = ("way",)

    def bound(self, slip_rate: Any, dt: float, way: Any) -> FrictionBound:
        return FrictionBound(0.2 + 0.3 * np.exp(-way), 0.0, 0.0)

    def evolve(self, slip_rate: Any, dt: float, way: Any) -> Any:
        return {"way": way + dt * np.abs(slip_rate)}


@pytest.mark.parametrize(
    ("attributes", "says"),
    [
        ({}, ""),
        ({"needs": ("slip_rates", "dt")}, 'did you mean "slip_rate"?'),
        ({"needs": "slip_rate"}, "a tuple of strings among"),
        ({"needs": ("slip_rate",)}, "its bound takes (self, slip_rate, dt, way); it is called with (self, slip_rate,"),
        ({"memory": ("way", "dt")}, "allowed: names that differ, and none of needs"),
        ({"evolve": FrictionLaw.evolve}, "it has memory but no evolve"),
        ({"need": ("dt",)}, "did you mean needs?"),
        ({"bounds": lambda self: None}, "did you mean bound?"),
        ({"helper": 1}, ""),
    ],
)
def test_declarations_that_miss_the_contract_are_refused(attributes: dict[str, Any], says: str) -> None:
    made = type("Wrong", (Worn,), {"__module__": __name__, **attributes})
    found = faults("friction", dataclass(frozen=True)(made))
    assert says in "\n".join(found)
    assert bool(found) == bool(says)


def test_misspelt_class_attributes_are_refused() -> None:
    body = {"__module__": __name__, "__annotations__": {"keep_energy": ClassVar[bool]}, "keep_energy": True}
    promised = dataclass(frozen=True)(type("Promised", (MortarP0,), body))
    assert "its keep_energy is not known to the contract; did you mean keeps_energy?" in faults("contact", promised)


def _pressure(self: Any, gap: Floats, stiffness: Floats, size: Floats, pressure: Floats, slope: Floats) -> None:
    pressure[:] = np.maximum(-stiffness * gap, 0.0)
    slope[:] = np.where(gap < 0.0, -stiffness, 0.0)


def _of_traction(gap: float, traction: float) -> float:
    return max(0.0, -traction - gap)


def test_arguments_of_pressures_are_those_of_the_needs() -> None:
    """An array method takes what the law declares, and no less."""
    fields: dict[str, Any] = {"pressure": _pressure, "__module__": __name__}
    assert not faults("enforcement", dataclass(frozen=True)(type("Springs", (NormalLaw,), fields)))
    blind = dataclass(frozen=True)(type("Blind", (NormalLaw,), fields | {"needs": ("traction",)}))
    assert "is called with (self, gap, stiffness, size, pressure, slope, traction" in faults("enforcement", blind)[0]


@pytest.mark.parametrize(
    ("declared", "says"),
    [
        ({"needs": ("pressure",)}, r"got pressure in needs or memory.*the law itself gives the pressure"),
        ({"needs": ("cell_size",)}, r"got cell_size in needs or memory.*`size` is always given"),
        ({"needs": ("traction",), "memory": ("crushed",)}, r'allowed: "traction" alone'),
        ({"pressure": formula(_of_traction)}, r"got the argument traction, allowed: gap"),
        ({"adjoint": lambda self, *arrays: None}, r"adjoint works on tractions, allowed: with needs"),
    ],
)
def test_needs_that_are_not_there_are_named(declared: dict[str, Any], says: str) -> None:
    with pytest.raises(TypeError, match=says):
        type("Law", (NormalLaw,), declared)
