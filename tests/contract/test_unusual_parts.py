"""Right parts unlike the shipped ones pass; what they declare narrows the checks that it names and no others."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from unusual_parts import Enhanced, ExplicitCurve, ImplicitCurve, Relaxing, Springs, Thermal

from contactlab.api import Floats, State
from contactlab.parts.registry import Registry
from contactlab.testing import Outcome, integrator_contact, run_check, run_checks


@dataclass(frozen=True)
class OfRate(ImplicitCurve):
    """Stribeck's friction, by the slip of a step of known length: the bound falls from all to 60 % with the speed."""

    step: float = 0.5
    time_scale: ClassVar[str] = "step"

    def most(self, slip: Floats) -> tuple[Floats, Floats]:
        fall = 0.4 * np.exp(-((slip / self.step) ** 2))
        return 0.6 + fall, -2.0 * slip / self.step**2 * fall


LEAPFROG: Any = Registry(files=[Path(__file__).with_name("leapfrog.py")]).part_class("integrator", "numpy-leapfrog")


@dataclass(frozen=True)
class Decays(LEAPFROG):  # type: ignore[misc]
    """Leaves a speed of what stands that falls by a share from step to step, as generalised-alpha does at rho = 0.8."""

    left: float = 0.98
    dissipates: ClassVar[bool] = True

    def bind(self, equations: Any, state: State) -> Any:
        inner = super().bind(equations, state)

        def step(dt: float) -> Any:
            done = inner(dt)
            speed = state["velocity"][:, 0]
            if state.step > 300 and np.abs(speed).max() < 1e-5:
                speed += 1e-6 * self.left ** (state.step - 300)
            return done

        return step


@dataclass(frozen=True)
class DecaysUndeclared(Decays):
    dissipates: ClassVar[bool] = False


def test_a_speed_that_decays_stands_if_the_scheme_declares_that_it_dissipates() -> None:
    check = integrator_contact.friction_takes_the_energy_of_what_slides
    assert run_check(check, Decays()).status == "passed"
    for wrong, said in (
        (Decays(left=1.0), "300 steps later"),
        (DecaysUndeclared(), "speed after friction has stopped"),
    ):
        assert said in run_check(check, wrong).reason


RIGHT: dict[str, tuple[str, Any, dict[str, str]]] = {
    "springs for explicit runs": ("enforcement", Springs(), {"is_the_direct_solution": "exact is False"}),
    "soft springs for explicit runs": ("enforcement", Springs(0.05), {"is_the_direct_solution": "exact is False"}),
    "an explicit pressure curve": ("enforcement", ExplicitCurve(), {"is_the_direct_solution": "exact is False"}),
    "a pressure curve of 1 mm": ("enforcement", ExplicitCurve(length=1.0), {}),
    "a pressure curve for implicit runs": (
        "enforcement", ImplicitCurve(),
        {"closed_gaps_bear_forces": "pressure_before_contact", "exactness_is_declared": "pressure_before_contact"},
    ),
    "friction of rate": ("enforcement", OfRate(), {"friction_keeps_its_bound": "time_scale"}),
    "a law that relaxes in 1 ms": ("material", Relaxing(), {}),
    "a law that relaxes in an hour": ("material", Relaxing(tau=3600.0), {}),
    "a law that relaxes in 1 ns": ("material", Relaxing(tau=1e-9), {}),
    "thermal strain": ("material", Thermal(), {"no_stress_at_rest": "stress_free is False"}),
    "thermal strain of a cooled body": ("material", Thermal(expansion=-0.02), {}),
    "enhanced strains": ("element", Enhanced(), {"kernels_are_at_the_points": "exact is False"}),
}  # fmt: skip


@pytest.mark.parametrize("name", RIGHT)
def test_right_parts_pass_and_say_what_was_assumed(name: str) -> None:
    kind, part, left_out = RIGHT[name]
    outcomes = run_checks(kind, part)
    assert _failed(outcomes) == {}
    reasons = {o.check: o.reason for o in outcomes if o.status == "not applicable"}
    for check, declared in left_out.items():
        assert declared in reasons[check]


WRONG: list[tuple[str, type[Any], str]] = [
    *(("enforcement", Springs, flaw) for flaw in (
        "acts when open", "pulls", "sleeps", "starts warm", "old slots stay", "nodes get less", "reports no correction",
        "rubs too much", "rubs along",
    )),
    *(("enforcement", ExplicitCurve, flaw) for flaw in (
        "pulls", "starts warm", "old slots stay", "nodes get less", "reports no correction", "rubs too much",
    )),
    *(("enforcement", ImplicitCurve, flaw) for flaw in (
        "pulls", "acts where nothing is", "slope of half", "looks aside", "never acts", "status 3", "rubs too much",
    )),
    *(("enforcement", OfRate, flaw) for flaw in (
        "pulls", "acts where nothing is", "slope of half", "looks aside", "status 3", "rubs too much",
    )),
    *(("material", Relaxing, flaw) for flaw in (
        "a step of no length", "half the loss", "no branch", "viscosity of shear forgotten", "flows at once",
        "tangent without time", "speeds of the relaxed",
    )),
    *(("material", Thermal, flaw) for flaw in (
        "shears", "along x alone", "hotter points", "nothing across", "spins", "stiffer along y",
    )),
    *(("element", Enhanced, flaw) for flaw in (
        "keeps nothing of the middle", "swaps xy and yx", "larger by a thousandth", "writes positions", "no weights",
        "overwrites forces",
    )),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "part", "flaw"), WRONG)
def test_defects_of_parts_that_declare_are_caught(kind: str, part: type[Any], flaw: str) -> None:
    assert _failed(run_checks(kind, part(flaw=flaw)))


def _failed(outcomes: list[Outcome]) -> dict[str, str]:
    return {outcome.check: outcome.reason for outcome in outcomes if outcome.status == "failed"}
