"""Dual numbers in kernels and in Python: every operation against differences and against each other."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.api import UNIT, Tensor, Vector, formula
from contactlab.api.compiled.dual import changes, derivatives, seed, seed_changing, value
from contactlab.api.compiled.formulas import FormulaError, Slot, made
from contactlab.api.compiled.kernel import kernel
from contactlab.api.formulas import members_of
from contactlab.api.mathematics import DualNumber, seeds
from contactlab.api.segments import Covered, MasterSegment, Overlap, SideSegment, SlavePoint, SlaveSegment

FORMULA = Slot("FORMULA")


@kernel
def of_numbers(x, out):
    out[0] = FORMULA(x[0], x[1])


@kernel
def of_duals(x, out):
    found = FORMULA(seed(x[0], 0, 4), seed(x[1], 1, 4))
    first, second, third, fourth = derivatives(found, 4)
    out[0], out[1], out[2], out[3], out[4] = value(found), first, second, third, fourth


@kernel
def of_twelve(x, out):
    found = FORMULA(seed(x[0], 5, 12), seed(x[1], 11, 12))
    changes = derivatives(found, 12)
    for i in range(12):
        out[i] = changes[i]


@kernel
def of_changing(x, out):
    for i in range(2):
        found = FORMULA(seed_changing(x[0], 0, 4, 1.0 - i), seed_changing(x[1], 1, 4, 1.0 * i))
        first, second, third, fourth = changes(found, 4)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = first, second, third, fourth


def invariant(x: Any, y: Any) -> Any:
    F = Tensor(x, 0.3 * y, -0.2, y + 1.0, 1.0)
    b = (2.0 * F @ F.T() - UNIT) / F.det() + F.symmetric() * x
    return b.deviator().dot(F.inverse()) + b.trace() - (F @ Vector(x, 1.0)).cross(Vector(y, 2.0)) * F.det()


def directions(x: Any, y: Any) -> Any:
    a, b = Vector(x, 2.0), Vector(1.0, y)
    return (a - 3.0 * b).unit() @ (-a.turned()) + (a + b / x).length()


def looped(x: Any, y: Any) -> Any:
    found = 1.0
    for k in range(1, 6):
        found = found + x**k / k if k % 2 else found - y / k
    while found > 2.0:
        found *= 0.5
    return found


def branching(x: Any, y: Any) -> Any:
    if x < y and x != y:
        low, high = 0.0, min(max(x, 0.25), y)
    else:
        low, high = abs(-x), 1
    return high * x - low + max(2, y) + min(3.0, x)


CASES: dict[str, Callable[[Any, Any], Any]] = {
    "sums": lambda x, y: 2 - x + y - (3.0 - y) + (-x) + 1,
    "products": lambda x, y: x * y * 2 + 3.0 * x / y - 1 / x + y / 2,
    "powers": lambda x, y: x**2 + x**0.5 + 2.0**y + x**y + y**3,
    "roots": lambda x, y: math.sqrt(x) + math.hypot(x, y) + math.hypot(x, 2.0),
    "exponentials": lambda x, y: math.exp(-x) * math.log(y + x) + np.exp(y) + np.log(x),
    "angles": lambda x, y: math.atan2(x, y) + math.sin(x) * math.cos(y) + math.tan(x) + math.atan(y) + np.arctan2(y, x),
    "inverse": lambda x, y: math.asin(0.3 * x) + math.acos(0.2 * y) + math.sinh(x) + math.cosh(y) + math.tanh(x * y),
    "signs": lambda x, y: math.copysign(x, -y) + math.fabs(-x) + abs(y - 5.0) + np.maximum(x, y) - np.minimum(x, 2.0),
    "choices": lambda x, y: np.where(x > y, x * y, x / y),
    "invariant": invariant,
    "directions": directions,
    "looped": looped,
    "branching": branching,
}  # fmt: skip


@pytest.mark.parametrize("name", some(CASES, ["powers", "angles", "signs", "invariant", "branching"]))
def test_derivatives_are_those_of_the_function(name: str) -> None:
    """Compiled and in Python, against central differences of the compiled function of numbers."""
    function = formula(CASES[name])
    compiled, differentiated = (
        made(template, f"test.{name}", {FORMULA: function}) for template in (of_numbers, of_duals)
    )
    at, out = np.array([0.7, 1.3]), np.empty(5)
    differentiated(at, out)

    def number(x: float, y: float) -> float:
        one = np.empty(1)
        compiled(np.array([x, y]), one)
        return float(one[0])

    step = 1e-6
    expected = [
        (number(0.7 + step, 1.3) - number(0.7 - step, 1.3)) / (2.0 * step),
        (number(0.7, 1.3 + step) - number(0.7, 1.3 - step)) / (2.0 * step),
    ]
    assert out[0] == pytest.approx(number(0.7, 1.3), rel=1e-15)
    assert out[1:3] == pytest.approx(expected, rel=1e-8, abs=1e-8)  # differences keep ten of sixteen digits
    assert out[3:].tolist() == [0.0, 0.0]
    dual = function(*seeds(at))
    assert dual.value == pytest.approx(out[0], rel=1e-14)
    assert dual.derivatives == pytest.approx(out[1:3], rel=1e-13)
    assert function(0.7, 1.3) == pytest.approx(out[0], rel=1e-14)


@pytest.mark.parametrize("name", some(CASES, ["powers", "angles", "invariant"]))
def test_changes_of_derivatives_are_second_derivatives(name: str) -> None:
    """Against central differences of the first ones; symmetric to round-off."""
    function = formula(CASES[name])
    differentiated, changing = (made(one, f"test.{name}", {FORMULA: function}) for one in (of_duals, of_changing))
    step, at, out, expected = 1e-6, np.array([0.7, 1.3]), np.empty((2, 4)), np.empty((2, 2))
    changing(at, out)
    for i in range(2):
        low, high, along = np.empty(5), np.empty(5), step * np.eye(2)[i]
        differentiated(at - along, low)
        differentiated(at + along, high)
        expected[i] = (high - low)[1:3] / (2.0 * step)
    np.testing.assert_allclose(out[:, :2], expected, rtol=1e-8, atol=1e-8)  # differences keep ten of sixteen digits
    assert out[0, 1] == pytest.approx(out[1, 0], rel=1e-13, abs=1e-15)
    assert not out[:, 2:].any()


def test_twelve_directions_are_kept_apart() -> None:
    out = np.empty(12)
    made(of_twelve, "test.twelve", {FORMULA: formula(CASES["products"])})(np.array([0.7, 1.3]), out)
    few = np.empty(5)
    made(of_duals, "test.four", {FORMULA: formula(CASES["products"])})(np.array([0.7, 1.3]), few)
    assert out[[5, 11]].tolist() == few[1:3].tolist()
    assert np.count_nonzero(out) == 2


def test_a_kink_has_the_derivative_of_the_side_of_its_value() -> None:
    assert max(DualNumber(0.0, np.array([1.0])), 0.0).derivatives.tolist() == [1.0]  # type: ignore[attr-defined]
    assert min(*seeds([2.0, 1.0])).derivatives.tolist() == [0.0, 1.0]


def test_functions_of_floats_alone_do_not_lose_derivatives_in_silence() -> None:
    with pytest.raises(TypeError, match="has lost the derivatives"):
        math.erf(DualNumber(1.0, np.ones(1)))  # type: ignore[arg-type]


def unknown(x: Any, y: Any) -> Any:
    return np.linalg.norm(x) + y


def listed(x: Any, y: Any) -> Any:
    return sum([x, y])


@pytest.mark.parametrize(("function", "line"), [(unknown, "np.linalg.norm(x)"), (listed, "sum([x, y])")])
def test_what_kernels_do_not_know_is_named_with_its_line(function: Any, line: str) -> None:
    with pytest.raises(FormulaError) as raised:
        made(of_duals, f"test.{function.__name__}", {FORMULA: formula(function)})(np.ones(2), np.empty(5))
    text = str(raised.value)
    assert f"{__file__}, line {function.__code__.co_firstlineno + 1}" in text
    assert line in text
    assert len(text.splitlines()) == 4


def unknown_member(x: Any, y: Any) -> Any:
    return Vector(x, y).norm()  # type: ignore[attr-defined]


def test_members_that_exist_stand_beside_an_unknown_one() -> None:
    with pytest.raises(FormulaError, match=r"Vector has no norm\n +allowed +x, y, cross\(\), turned\(\), length\(\)"):
        made(of_duals, "test.unknown_member", {FORMULA: formula(unknown_member)})(np.ones(2), np.empty(5))


def misspelt(x: Any, y: Any) -> Any:
    return sqroot(x) + y  # type: ignore[name-defined]  # noqa: F821


def test_a_name_that_is_nowhere_is_named_with_its_formula() -> None:
    with pytest.raises(FormulaError, match="misspelt: NameError: name 'sqroot' is not defined"):
        made(of_duals, "test.misspelt", {FORMULA: formula(misspelt)})(np.ones(2), np.empty(5))


@pytest.mark.parametrize("kind", [Vector, SlaveSegment, SlavePoint, MasterSegment, Overlap, Covered, SideSegment])
def test_the_page_of_contact_names_all_that_its_formulas_see(kind: type[Any]) -> None:
    page = (Path(__file__).parents[3] / "docs" / "parts" / "contact.md").read_text()
    (row,) = re.findall(rf"^\| `{kind.__name__}` \|.*$", page, re.MULTILINE)
    assert not [name for name in members_of(kind).split(", ") if not re.search(rf"\b{name.rstrip('()')}\b", row)]


def test_formulas_run_uncompiled_if_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same code objects run, so that a debugger stops in them."""
    monkeypatch.setenv("CONTACTLAB_PYTHON", "1")
    ran = []

    def noted(x: Any, y: Any) -> Any:
        ran.append(type(x).__name__)
        return math.sqrt(x * y)

    out = np.empty(5)
    made(of_duals, "test.noted", {FORMULA: formula(noted)})(np.array([4.0, 9.0]), out)
    assert ran == ["DualNumber"]
    assert out.tolist() == [6.0, 0.75, 1.0 / 3.0, 0.0, 0.0]
