"""Every check of normal laws catches a planted defect, and right laws pass all of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from contactlab.api import Floats, NormalLaw, formula
from contactlab.parts.contract import faults
from contactlab.testing import normal_law
from contactlab.testing.assertions import NotApplicable


@dataclass(frozen=True)
class Square(NormalLaw):
    """Pressure by the square of what lies below `open_at`, with one flaw or none."""

    length_scale = "open_at"

    open_at: float = 0.01
    factor: float = 1.0
    flaw: str = ""

    def begins(self) -> float:
        return (0.5 if self.flaw == "begins too soon" else 1.0) * self.open_at

    def pressure(self, gap: Floats, stiffness: Floats, size: Floats, pressure: Floats, slope: Floats) -> None:
        k = 1e4 if self.flaw == "does not follow the cells" else stiffness
        k = self._stiffer() * k
        close = self.open_at - gap if self.flaw == "grips" else np.maximum(self.open_at - gap, 0.0)
        pressure[:] = k * close**2 / self.open_at
        slope[:] = -2.0 * k * close / self.open_at
        if self.flaw == "pulls":
            pressure -= 1e-3 * pressure.max()
        if self.flaw == "gives way":
            pressure[:] = np.minimum(pressure, 4.0 * k * self.open_at - pressure)
        if self.flaw == "half the slope":
            slope *= 0.5
        if self.flaw == "slope of the other sign":
            slope *= -1.0
        if self.flaw == "knows its neighbours":
            pressure += 1e-6 * pressure.mean() * (pressure > 0.0)
        if self.flaw == "writes gaps":
            gap[:] = np.minimum(gap, self.open_at)

    def _stiffer(self) -> float:
        return self.factor

    def energy(self, gap: Floats, stiffness: Floats, size: Floats) -> Floats:
        share = 0.5 if self.flaw == "half the energy" else 1.0
        return share * super().energy(gap, stiffness, size)


@dataclass(frozen=True)
class Capped(Square):
    """A largest pressure, which is reached far from where it begins."""

    most: float = 1e5

    def pressure(self, gap: Floats, stiffness: Floats, size: Floats, pressure: Floats, slope: Floats) -> None:
        super().pressure(gap, stiffness, size, pressure, slope)
        slope[pressure > self.most] = 0.0
        np.minimum(pressure, self.most, out=pressure)


@dataclass(frozen=True)
class Deaf(Square):
    """`factor` does nothing."""

    def _stiffer(self) -> float:
        return 1.0


@dataclass(frozen=True)
class Lean(NormalLaw):
    """Half the stress behind and a spring, with one flaw or none."""

    needs = ("traction",)

    share: float = 0.5
    flaw: str = ""

    def pressure(
        self,
        gap: Floats,
        stiffness: Floats,
        size: Floats,
        pressure: Floats,
        slope: Floats,
        traction: Floats,
        by_traction: Floats,
    ) -> None:
        felt = np.abs(traction) if self.flaw == "tension presses" else traction
        felt = -traction if self.flaw == "of the other sign" else felt
        wish = -self.share * felt - stiffness * gap
        pressure[:] = wish if self.flaw == "glues" else np.maximum(wish, 0.0)
        slope[:] = np.where(pressure > 0.0, -stiffness, 0.0)
        if self.flaw == "gaps only where it is compressed":
            pressure[:] = np.where(traction < 0.0, np.maximum(-self.share * traction, 0.0), pressure)
            slope[traction < 0.0] = 0.0
        by_traction[:] = np.where(pressure > 0.0, -self.share, 0.0)
        if self.flaw == "half the derivative":
            by_traction *= 0.5
        if self.flaw == "derivative not filled":
            by_traction[:] = np.nan
        if self.flaw == "no derivative":
            by_traction[:] = 0.0
        if self.flaw == "derivative of the other sign":
            by_traction *= -1.0
        if self.flaw == "derivative everywhere":
            by_traction[:] = -self.share
        if self.flaw == "writes tractions":
            traction[:] = np.minimum(traction, 0.0)


@dataclass(frozen=True)
class Variant(Lean):
    """All of the stress behind and a spring, and an adjoint in all variants but 0, with one flaw or none."""

    share: float = 1.0
    variant: int = 0

    def adjoint(
        self,
        pressure: Floats,
        stiffness: Floats,
        size: Floats,
        adjoint: Floats,
        by_pressure: Floats,
        traction: Floats,
        by_traction: Floats,
    ) -> None:
        stiff = 1e4 if self.flaw == "does not follow the cells" else stiffness
        factor = self.variant / stiff
        adjoint[:] = factor * (pressure + traction)
        by_pressure[:], by_traction[:] = factor, factor
        if self.flaw == "stress without pressure":
            adjoint[:], by_pressure[:] = factor * traction, 0.0
        if self.flaw == "pressure of the other sign":
            adjoint[:], by_pressure[:] = factor * (traction - pressure), -factor
        if self.flaw == "half the derivative by the pressure":
            by_pressure *= 0.5
        if self.flaw == "no derivative by the traction":
            by_traction[:] = 0.0
        if self.flaw == "second derivative not filled":
            by_traction[:] = np.nan
        if self.flaw == "writes pressures":
            pressure[:] = 0.0


def caught(law: NormalLaw) -> set[str]:
    found = set()
    for check in normal_law.CHECKS:
        try:
            check(law)
        except NotApplicable:
            continue
        except AssertionError:
            found.add(check.__name__)
    return found


def test_right_laws_pass() -> None:
    assert not caught(Square())
    assert not caught(Square(open_at=1.0))
    assert not caught(Capped())
    assert not caught(Lean())
    assert not caught(Variant())


@pytest.mark.parametrize(
    ("flaw", "check"),
    [
        ("begins too soon", "pressure_begins_where_it_says"),
        ("grips", "pressure_begins_where_it_says"),
        ("pulls", "pressure_never_pulls_nor_falls"),
        ("gives way", "pressure_never_pulls_nor_falls"),
        ("slope of the other sign", "pressure_never_pulls_nor_falls"),
        ("half the slope", "slope_is_the_derivative"),
        ("knows its neighbours", "conditions_do_not_know_each_other"),
        ("half the energy", "energy_is_the_integral"),
        ("writes gaps", "gaps_are_only_read"),
        ("does not follow the cells", "stiffness_behind_scales"),
    ],
)
def test_defects_are_caught(flaw: str, check: str) -> None:
    assert check in caught(Square(flaw=flaw))


@pytest.mark.parametrize(
    ("flaw", "check"),
    [
        ("tension presses", "tractions_press_as_they_should"),
        ("of the other sign", "tractions_press_as_they_should"),
        ("glues", "tractions_press_as_they_should"),
        ("gaps only where it is compressed", "tractions_press_as_they_should"),
        ("half the derivative", "tractions_press_as_they_should"),
        ("derivative not filled", "tractions_press_as_they_should"),
        ("no derivative", "tractions_press_as_they_should"),
        ("derivative of the other sign", "tractions_press_as_they_should"),
        ("derivative everywhere", "tractions_press_as_they_should"),
        ("writes tractions", "gaps_are_only_read"),
    ],
)
def test_defects_of_laws_of_the_stress_are_caught(flaw: str, check: str) -> None:
    assert check in caught(Lean(flaw=flaw))


@pytest.mark.parametrize(
    "law",
    [
        Variant(flaw="stress without pressure"),
        Variant(flaw="pressure of the other sign"),
        Variant(flaw="half the derivative by the pressure"),
        Variant(flaw="no derivative by the traction"),
        Variant(flaw="second derivative not filled"),
        Variant(flaw="does not follow the cells"),
        Variant(flaw="writes pressures"),
        Variant(share=0.5),
    ],
    ids=lambda law: law.flaw or "half the stress",
)
def test_defects_of_adjoints_are_caught_whatever_the_default_variant(law: Variant) -> None:
    assert caught(law) == {"adjoint_is_right_in_every_variant"}


def test_an_adjoint_needs_tractions() -> None:
    with pytest.raises(TypeError, match=r"Blind.adjoint works on tractions, allowed: with needs"):
        type("Blind", (Square,), {"adjoint": Variant.adjoint})


def test_a_number_with_a_default_that_does_nothing_is_caught_in_the_law_by_default() -> None:
    assert caught(Deaf()) == {"its_numbers_matter"}
    assert not caught(Deaf(factor=2.0))


@dataclass(frozen=True)
class Crushed(Square):
    """Elastic under what is crushed of it, 0.9 of the deepest overlap, with one flaw or none."""

    needs = ("time",)
    memory = ("crushed",)
    length_scale = ""

    def begins(self) -> float:
        return 0.0

    def pressure(self, gap, stiffness, size, pressure, slope, time, crushed):  # type: ignore[no-untyped-def, override]
        left = np.maximum(-gap - (0.0 if self.flaw == "deaf" else crushed), 0.0) * (
            1.0 if self.flaw == "timeless" else time
        )
        pressure[:] = 1e4 * left
        slope[:] = np.where(left > 0.0, -1e4 * (1.0 if self.flaw in ("timeless", "slope without time") else time), 0.0)
        if self.flaw == "slope of a new layer":
            slope[crushed > 0.0] *= 0.5
        if self.flaw == "pulls when crushed":
            pressure -= np.where(crushed > 0.0, 1.0, 0.0)

    def evolve(self, gap, time, crushed, **beside):  # type: ignore[no-untyped-def, override]
        if self.flaw == "forgets":
            return {"crushed": crushed}
        if self.flaw == "writes memory":
            crushed[:] = np.maximum(crushed, -0.9 * gap)
            return {}
        found = np.maximum(crushed, -0.9 * gap)
        if self.flaw == "own memory":
            LAST.append(float(found.max()))
            return {"crushed": np.maximum(found, max(LAST))}
        return {"crushed" if self.flaw != "another name" else "worn": found}

    energy = NormalLaw.energy


LAST: list[float] = []


@pytest.mark.parametrize(
    ("flaw", "found"),
    [
        ("", set()),
        ("deaf", {"needs_and_memory_count"}),
        ("timeless", {"needs_and_memory_count"}),
        ("forgets", {"needs_and_memory_count"}),
        ("writes memory", {"memory_is_only_in_the_state"}),
        ("own memory", {"memory_is_only_in_the_state"}),
        ("slope without time", {"slope_is_the_derivative", "pressure_is_right_under_what_it_remembers"}),
        ("slope of a new layer", {"pressure_is_right_under_what_it_remembers"}),
        ("pulls when crushed", {"pressure_is_right_under_what_it_remembers"}),
        ("another name", {"needs_and_memory_count"}),
    ],
)
def test_flaws_of_laws_with_memory_are_caught(flaw: str, found: set[str]) -> None:
    caught_ones = caught(Crushed(flaw=flaw))
    assert found <= caught_ones
    assert found or not caught_ones & MEMORY


MEMORY = {check for check in vars(normal_law) if "memor" in check or "remember" in check}


def test_arguments_are_those_of_the_needs() -> None:
    """An array method takes what the law declares, and no less."""
    assert not faults("enforcement", Lean)
    blind = type("Blind", (Lean,), {"pressure": Square.pressure, "__module__": __name__})
    assert "is called with (self, gap, stiffness, size, pressure, slope, traction" in faults("enforcement", blind)[0]


def test_needs_that_are_not_there_are_named() -> None:
    with pytest.raises(TypeError, match=r"got pressure in needs or memory.*the law itself gives the pressure"):
        type("Fed", (NormalLaw,), {"needs": ("pressure",)})
    with pytest.raises(TypeError, match=r"got cell_size in needs or memory.*`size` is always given"):
        type("Sized", (NormalLaw,), {"needs": ("cell_size",)})
    with pytest.raises(TypeError, match=r'allowed: "traction" alone'):
        type("Both", (NormalLaw,), {"needs": ("traction",), "memory": ("crushed",)})
    with pytest.raises(TypeError, match=r"got the argument traction, allowed: gap"):
        type("Deaf", (NormalLaw,), {"pressure": formula(_of_traction)})


def _of_traction(gap: float, traction: float) -> float:
    return max(0.0, -traction - gap)
