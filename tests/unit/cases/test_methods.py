"""Names of contact methods: algorithms with fields, and with an enforcement of their own."""

from __future__ import annotations

import pytest

from contactlab.api import Setup
from contactlab.cases.methods import method_name, method_of, methods
from contactlab.cases.run_case import declined, run_case, scene_of
from contactlab.errors import RequestError
from contactlab.parts.registry import default_registry

HALVES = "gauss-point passes=2 + linear-pressure"


def test_names_and_parts_of_all_methods_are_two_ways_to_write_one_thing() -> None:
    registry = default_registry()
    names = methods(registry, variants=True)
    assert {*methods(registry)} < {*names}
    assert [method_name(*method_of(name, registry, "here")) for name in names] == names
    for name in names:
        for kind, spec in zip(("contact", "enforcement"), method_of(name, registry, "here"), strict=True):
            if spec:
                registry.make(kind, spec)
    assert method_of(HALVES, registry, "here") == ({"use": "gauss-point", "passes": 2}, "linear-pressure")


@pytest.mark.parametrize(("name", "got"), [("mortar-p9", "mortar-p9"), ("mortar-p1 + nitscher", "nitscher")])
def test_a_part_that_is_not_there_is_named(name: str, got: str) -> None:
    with pytest.raises(RequestError) as error:
        method_of(name, default_registry(), "here")
    assert error.value.got == got


@pytest.mark.parametrize(
    ("case", "name", "why"),
    [
        ("patch", "mortar-p1 + nitsche", ""),
        ("patch", HALVES, ""),
        ("two-bars", "mortar-p1 + nitsche", "follows the stress"),
        ("pulled-block", HALVES, "two sides that deform"),
        ("two-bars", HALVES, "fixed step is longer"),
    ],
)
def test_an_enforcement_of_a_setup_is_that_of_all_contacts_or_declined(case: str, name: str, why: str) -> None:
    registry = default_registry()
    question = registry.make("case", case)
    algorithm, law = method_of(name, registry, "here")
    setup = Setup(algorithm, False, question.elements[0], question.integrators[0], enforcement=law)
    jobs, done = run_case(question, setup, registry)
    assert why in (said := declined(setup, done))
    assert bool(said) == bool(why)
    scene = scene_of(next(iter(jobs.values())), registry, law)
    assert {contact.enforcement["use"] for contact in scene.contacts} == {law}
