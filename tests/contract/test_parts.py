"""Every installed part keeps the contract of its kind; a part that is installed is checked without being named here."""

from __future__ import annotations

from typing import Any

import pytest

from contactlab.api.part import KINDS
from contactlab.parts.registry import default_registry
from contactlab.testing import checks_for
from contactlab.testing.assertions import Check
from contactlab.testing.examples import example
from contactlab.testing.scenarios.case import is_put_to_an_algorithm
from contactlab.testing.subject import Subject


def installed() -> list[tuple[str, str]]:
    registry = default_registry()
    return [(kind, name) for kind in KINDS for name in registry.names(kind)]


LONG = {
    ("implicit-dynamics", "contact_makes_no_energy"), ("implicit-dynamics", "energy_is_bounded"),
    ("implicit-dynamics", "friction_takes_the_energy_of_what_slides"),
}  # fmt: skip
"""Thousands of steps that iterate."""
ALIKE = {"linear-hardening", "tip", "slips", "nodal-forces", "overlap-area", "leapfrog-energy"}
"""Parts that are made like another one: flow as in `power-law`, whose kernels take long to compile, and watches."""


def tier(name: str, check: Check) -> tuple[Any, ...]:
    return (pytest.mark.full,) if name in ALIKE or (name, check.__name__) in LONG else ()


CASES = [
    pytest.param(kind, name, check, id=f"{kind}-{name}-{check.__name__}", marks=tier(name, check))
    for kind, name in installed()
    for check in checks_for(kind, default_registry().part_class(kind, name))
]


@pytest.mark.parametrize(("kind", "name", "check"), CASES)
def test_part(kind: str, name: str, check: Check) -> None:
    check(example(default_registry(), kind, name))


IN_SHORT = ("hertz", "pulled-strip", "tresca-block")
"""Cases whose runs are short: one raises in curves of NaN, one reads states, one counts nodes by the sign."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in IN_SHORT else (pytest.mark.full,))
        for kind, name in installed()
        if kind == "case"
    ],
)
def test_case_in_a_run(name: str) -> None:
    is_put_to_an_algorithm(Subject(default_registry(), "case", name))


@pytest.mark.parametrize(("kind", "name"), installed())
def test_no_part_escapes_its_checks(kind: str, name: str) -> None:
    """A new part whose fields have no usual value would be skipped silently: `USUAL` must know them."""
    part: Any = example(default_registry(), kind, name)
    assert len(checks_for(kind, type(part))) > 0
    assert type(part) is default_registry().part_class(kind, name)


def test_every_checked_kind_has_parts() -> None:
    assert {kind for kind, _ in installed()} == set(KINDS)
