"""Friction laws with needs and memory: right ones pass every check, and each planted defect is caught."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from contactlab.api import FrictionBound, FrictionLaw
from contactlab.parts.contract import faults
from contactlab.parts.registry import Registry
from contactlab.testing import friction, run_check, run_checks
from contactlab.testing.assertions import Check

LAWS = Registry(files=[Path(__file__).parents[1] / "outside" / "rate-friction" / "src" / "rate_friction" / "laws.py"])
STRIBECK: Any = LAWS.part_class("friction", "stribeck")
DIETERICH: Any = LAWS.part_class("friction", "rate-and-state")
NUMBERS = {"mu": 0.4, "a": 0.02, "b": 0.03, "length": 0.01, "speed": 10.0}


def coulomb(mu: Any) -> FrictionBound:
    return FrictionBound(mu, 0.0, 0.0)


@dataclass(frozen=True)
class Worn(FrictionLaw):
    """Falls from `new` to `worn` with the way slid, by exp(-way / length); forward Euler.

    new, worn  [-] coefficients
    length     [mm] way after which 37 % of the fall is left
    """

    new: float = 0.5
    worn: float = 0.2
    length: float = 0.5
    needs = ("slip_rate", "dt")
    memory = ("way",)

    def bound(self, slip_rate: Any, dt: float, way: Any) -> FrictionBound:
        return coulomb(self.worn + (self.new - self.worn) * np.exp(-way / self.length))

    def evolve(self, slip_rate: Any, dt: float, way: Any) -> Any:
        return {"way": way + dt * np.abs(slip_rate)}


@dataclass(frozen=True)
class OfPressure(FrictionLaw):
    """mu / (1 + largest pressure so far / limit): asperities stay flat.

    mu     [-] coefficient of rough surfaces
    limit  [MPa] pressure at which half is left
    """

    mu: float = 0.5
    limit: float = 100.0
    needs = ("pressure",)
    memory = ("most",)

    def bound(self, pressure: Any, most: Any) -> FrictionBound:
        return coulomb(self.mu / (1.0 + np.maximum(most, pressure) / self.limit))

    def evolve(self, pressure: Any, most: Any) -> Any:
        return {"most": np.maximum(most, pressure)}


@dataclass(frozen=True)
class Lubricated(FrictionLaw):
    """A shear stress that grows with the rate, as a power of it, without a coefficient.

    stress    [MPa] at `speed`
    speed     [mm/s] rate of reference
    exponent  [-] sensitivity to the rate
    """

    stress: float = 20.0
    speed: float = 100.0
    exponent: float = 0.2
    needs = ("slip_rate",)

    def bound(self, slip_rate: Any) -> FrictionBound:
        return FrictionBound(0.0, self.stress * (np.abs(slip_rate) / self.speed) ** self.exponent, math.inf)


@dataclass(frozen=True)
class Striped(FrictionLaw):
    """A coefficient that varies along x and fades with time; segments longer than `length` have more of it.

    mu      [-] mean
    length  [mm] period, and length of a segment with twice the mean
    fade    [1/s] rate
    """

    mu: float = 0.3
    length: float = 2.0
    fade: float = 50.0
    needs = ("position", "time", "cell_size")

    def bound(self, position: Any, time: float, cell_size: Any) -> FrictionBound:
        wave = 1.0 + 0.5 * np.sin(2.0 * np.pi * position[:, 0] / self.length)
        return coulomb(self.mu * wave * (1.0 + cell_size / self.length) * np.exp(-self.fade * time))


RIGHT = [
    STRIBECK(0.5, 0.3, 20.0), STRIBECK(0.5, 0.3, 20.0, 1e-4), DIETERICH(**NUMBERS), Worn(), OfPressure(), Lubricated(),
    Striped(),
]  # fmt: skip


@pytest.mark.parametrize("law", RIGHT)
def test_right_laws_pass(law: FrictionLaw) -> None:
    outcomes = run_checks("friction", law)
    assert not [outcome for outcome in outcomes if outcome.status == "failed"]
    assert not [outcome.reason for outcome in outcomes if outcome.status == "passed" and outcome.reason]
    assert {outcome.check for outcome in outcomes if outcome.status == "passed"} >= {"needs_count", "numbers_in_range"}
    assert not faults("friction", type(law))


class RemembersInBound(DIETERICH):  # type: ignore[misc]
    """Advances what it remembers in every call, those of rejected steps included."""

    kept: ClassVar[dict[str, float]] = {"calls": 0.0}

    def bound(self, slip_rate: Any, dt: float, theta: Any) -> FrictionBound:
        self.kept["calls"] += 1e-9
        return super().bound(slip_rate, dt, theta + self.kept["calls"])  # type: ignore[no-any-return]


class RemembersInEvolve(Worn):
    kept: ClassVar[dict[str, Any]] = {"way": 0.0}

    def evolve(self, slip_rate: Any, dt: float, way: Any) -> Any:
        self.kept["way"] = self.kept["way"] + dt * np.abs(slip_rate)
        return {"way": self.kept["way"]}


class ChangesInPlace(DIETERICH):  # type: ignore[misc]
    def evolve(self, slip_rate: Any, dt: float, theta: Any) -> Any:
        theta += dt
        return {"theta": theta}


class BoundWritesMemory(Worn):
    def bound(self, slip_rate: Any, dt: float, way: Any) -> FrictionBound:
        way += dt * np.abs(slip_rate)
        return super().bound(slip_rate, dt, way)


class CountsSteps(DIETERICH):  # type: ignore[misc]
    def evolve(self, slip_rate: Any, dt: float, theta: Any) -> Any:
        return {"theta": theta + 1e-3 * (self.length / self.speed + 0.0 * dt)}


class SquaredTime(Worn):
    def evolve(self, slip_rate: Any, dt: float, way: Any) -> Any:
        return {"way": way + dt**2 * np.abs(slip_rate) * 1e6}


class SlipOfUsualStep(Worn):
    """As if all steps took a microsecond."""

    def evolve(self, slip_rate: Any, dt: float, way: Any) -> Any:
        return {"way": way + 1e-6 * np.abs(slip_rate)}


class NeverChanges(Worn):
    def evolve(self, slip_rate: Any, dt: float, way: Any) -> Any:
        return {"way": way}


class Negative(STRIBECK):  # type: ignore[misc]
    """Viscous with the wrong sign."""

    def bound(self, slip_rate: Any) -> FrictionBound:
        return coulomb(self.kinetic - 1e-2 * self.static * np.abs(slip_rate) / self.speed)


class AbsMissing(STRIBECK):  # type: ignore[misc]
    def bound(self, slip_rate: Any) -> FrictionBound:
        return coulomb(self.kinetic + (self.static - self.kinetic) * np.exp(-slip_rate / self.speed))


class LogarithmOfZero(DIETERICH):  # type: ignore[misc]
    def bound(self, slip_rate: Any, dt: float, theta: Any) -> FrictionBound:
        with np.errstate(divide="ignore"):
            return coulomb(self.mu + self.a * np.log(np.abs(slip_rate) / self.speed) + self.b * np.log(theta))


class StressForCoefficient(Lubricated):
    def bound(self, slip_rate: Any) -> FrictionBound:
        return coulomb(super().bound(slip_rate).adhesion)


class RateWithoutReference(Lubricated):
    """The rate itself to a power, in mm/s."""

    def bound(self, slip_rate: Any) -> FrictionBound:
        share = np.abs(slip_rate) ** self.exponent / (1.0 + self.speed * 0.01)
        return FrictionBound(0.0, self.stress * share, math.inf)


class PressureOfSteel(OfPressure):
    """A hundred MPa that are not a field."""

    def bound(self, pressure: Any, most: Any) -> FrictionBound:
        return coulomb(self.mu / (1.0 + np.maximum(most, pressure) / 100.0 + most / self.limit))


class MeanOfAll(STRIBECK):  # type: ignore[misc]
    def bound(self, slip_rate: Any) -> FrictionBound:
        return super().bound(np.full_like(slip_rate, np.abs(slip_rate).mean()))  # type: ignore[no-any-return]


class Neighbours(Worn):
    def evolve(self, slip_rate: Any, dt: float, way: Any) -> Any:
        return {"way": way + dt * np.abs(np.roll(slip_rate, 1))}


class Column(STRIBECK):  # type: ignore[misc]
    def bound(self, slip_rate: Any) -> FrictionBound:
        return coulomb(super().bound(slip_rate).coefficient[:, None])


class NeedsForNothing(STRIBECK):  # type: ignore[misc]
    needs = ("slip_rate", "time")

    def bound(self, slip_rate: Any, time: float) -> FrictionBound:
        return super().bound(slip_rate)  # type: ignore[no-any-return]


class MemoryForNothing(Worn):
    def bound(self, slip_rate: Any, dt: float, way: Any) -> FrictionBound:
        return coulomb(self.worn + (self.new - self.worn) * np.exp(-np.abs(slip_rate) * dt / self.length))


class IgnoresLength(DIETERICH):  # type: ignore[misc]
    def start(self) -> Any:
        return {"theta": 1.0 / self.speed}

    def bound(self, slip_rate: Any, dt: float, theta: Any) -> FrictionBound:
        return coulomb(np.maximum(self.mu + self.a * slip_rate**2 / self.speed**2 + self.b * theta * self.speed, 0.0))

    def evolve(self, slip_rate: Any, dt: float, theta: Any) -> Any:
        return {"theta": theta + dt}


class OtherName(Worn):
    def evolve(self, slip_rate: Any, dt: float, way: Any) -> Any:
        return {"distance": way}


class StartsOtherName(DIETERICH):  # type: ignore[misc]
    def start(self) -> Any:
        return {"age": 1.0}


class Noisy(STRIBECK):  # type: ignore[misc]
    def bound(self, slip_rate: Any) -> FrictionBound:
        noise = 1e-6 * np.random.default_rng().random(len(slip_rate))
        return coulomb(super().bound(slip_rate).coefficient + noise)


CAUGHT: list[tuple[Check, FrictionLaw]] = [
    (friction.same_bound_twice, RemembersInBound(**NUMBERS)),
    (friction.same_bound_twice, RemembersInEvolve()),
    (friction.same_bound_twice, Noisy(0.5, 0.3, 20.0)),
    (friction.inputs_are_only_read, ChangesInPlace(**NUMBERS)),
    (friction.inputs_are_only_read, BoundWritesMemory()),
    (friction.memory_follows_time, CountsSteps(**NUMBERS)),
    (friction.memory_follows_time, SquaredTime()),
    (friction.memory_follows_time, SlipOfUsualStep()),
    (friction.memory_follows_time, NeverChanges()),
    (friction.numbers_in_range, Negative(0.5, 0.3, 20.0)),
    (friction.numbers_in_range, AbsMissing(0.5, 0.3, 20.0)),
    (friction.numbers_in_range, LogarithmOfZero(**NUMBERS)),
    (friction.numbers_in_range, Column(0.5, 0.3, 20.0)),
    (friction.numbers_in_range, OtherName()),
    (friction.numbers_in_range, StartsOtherName(**NUMBERS)),
    (friction.units_do_not_matter_to_the_law, StressForCoefficient()),
    (friction.units_do_not_matter_to_the_law, RateWithoutReference()),
    (friction.units_do_not_matter_to_the_law, PressureOfSteel()),
    (friction.multipliers_do_not_know_each_other, MeanOfAll(0.5, 0.3, 20.0)),
    (friction.multipliers_do_not_know_each_other, Neighbours()),
    (friction.needs_count, NeedsForNothing(0.5, 0.3, 20.0)),
    (friction.needs_count, MemoryForNothing()),
    (friction.numbers_count, IgnoresLength(**NUMBERS)),
]


@pytest.mark.parametrize(("check", "law"), CAUGHT)
def test_defects_are_caught(check: Check, law: FrictionLaw) -> None:
    outcome = run_check(check, law)
    assert outcome.status == "failed"
    assert "raised" not in outcome.reason


def test_a_bound_that_knows_a_direction_is_told() -> None:
    class Fur(STRIBECK):  # type: ignore[misc]
        def bound(self, slip_rate: Any) -> FrictionBound:
            return coulomb(super().bound(slip_rate).coefficient * np.where(slip_rate > 0.0, 1.0, 0.5))

    outcome = run_check(friction.slip_both_ways, Fur(0.5, 0.3, 20.0))
    assert outcome.status == "passed"
    assert "is an abs missing" in outcome.reason


@pytest.mark.parametrize(
    ("attributes", "says"),
    [
        ({"needs": ("slip_rates", "dt")}, 'did you mean "slip_rate"?'),
        ({"needs": "slip_rate"}, "a tuple of texts among"),
        ({"needs": ("slip_rate",)}, "its bound takes (self, slip_rate, dt, way); it is called with (self, slip_rate,"),
        ({"memory": ("way", "dt")}, "allowed: names that differ, and none of needs"),
        ({"evolve": FrictionLaw.evolve}, "it has memory and no evolve"),
        ({"need": ("dt",)}, "did you mean needs?"),
    ],
)  # fmt: skip
def test_declarations_that_miss_the_contract_are_refused(attributes: dict[str, Any], says: str) -> None:
    wrong = type("Wrong", (Worn,), {"__module__": __name__, **attributes})
    assert says in "\n".join(faults("friction", wrong))


# --- laws of three constants -----------------------------------------------------------------------


@dataclass(frozen=True)
class Constant(FrictionLaw):
    """A law with any numbers."""

    numbers: tuple[float, float, float] = (0.2, 0.0, 0.0)

    def bound(self) -> FrictionBound:
        return FrictionBound(*self.numbers)


@dataclass(frozen=True)
class Deaf(FrictionLaw):
    """Does not hear what the scene says."""

    mu: float

    def bound(self) -> FrictionBound:
        return FrictionBound(0.2, 0.0, 0.0)


class Moody(Constant):
    """Another bound in every call."""

    calls: ClassVar[Any] = itertools.count()

    def bound(self) -> FrictionBound:
        return FrictionBound(0.2 + 0.001 * next(self.calls), 0.0, 0.0)


@pytest.mark.parametrize("check", friction.CHECKS)
@pytest.mark.parametrize("numbers", [(0.2, 0.0, 0.0), (0.0, 200.0, np.inf), (0.1, 50.0, 5.0)])
def test_right_friction_passes(check: Check, numbers: tuple[float, float, float]) -> None:
    check(Constant(numbers))


WRONG_FRICTION: list[tuple[Check, FrictionLaw]] = [
    (friction.numbers_in_range, Constant((np.nan, 0.0, 0.0))),
    (friction.numbers_in_range, Constant((0.2, np.inf, np.inf))),
    (friction.bound_grows_with_pressure, Constant((-0.1, 1000.0, np.inf))),
    (friction.rubs_at_all, Constant((0.0, 200.0, 0.0))),
    (friction.same_bound_twice, Moody()),
    (friction.numbers_count, Deaf(0.2)),
]


@pytest.mark.parametrize(("check", "part"), WRONG_FRICTION)
def test_wrong_friction_is_caught(caught: Any, check: Check, part: FrictionLaw) -> None:
    caught(check, part)


def test_every_check_has_a_wrong_friction_law() -> None:
    """But the one that only tells."""
    assert {check for check, _ in [*WRONG_FRICTION, *CAUGHT]} == set(friction.CHECKS) - {friction.slip_both_ways}
