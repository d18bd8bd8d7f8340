"""Scenarios by kind of part; scenarios of elements and of integrators."""

from __future__ import annotations

from contactlab.api import ExplicitIntegrator, Integrator
from contactlab.cases.verdict import allowed
from contactlab.testing.assertions import NotApplicable, require
from contactlab.testing.scenarios import Scenario, case, contact
from contactlab.testing.scenarios.cases import Question, answer, found_of
from contactlab.testing.scenarios.contact import LADDER
from contactlab.testing.scenarios.invariance import INVARIANCE, comes_to_its_end, slip_and_strain_turn_back
from contactlab.testing.subject import Subject

BARS = Question("two-bars")


def bars_exchange_their_momentum(subject: Subject) -> None:
    """A bar that hits one at rest stops, and leaves it its speed; momentum is kept to round-off."""
    cls = subject.part_class
    if not cls.inertia:
        raise NotApplicable("the integrator has no inertia: free bodies have no equilibrium")
    if issubclass(cls, ExplicitIntegrator) and cls.velocity_lag == 0.5 and cls.control is Integrator.control:
        answer(subject, BARS)
        return
    # waves of one cell in a step are exact in a leapfrog of equal steps alone, and so is the energy of the case
    found = found_of(subject, BARS)
    require(found.status == "finished", f"two-bars: the run ended as {found.status}: {found.reason}")
    for judged in found.judged:
        if "momentum" in judged.measure.name:
            said = f"two-bars: {judged.measure.name} is {judged.value:.3g}, allowed {allowed(judged.measure)}"
            require(judged.verdict == "met", said)


INTEGRATOR = (bars_exchange_their_momentum, slip_and_strain_turn_back)


def patch_test_in_statics(subject: Subject) -> None:
    """Two blocks under uniform pressure, meshes that do not match: round-off, with either slave and turned."""
    for swap, turn in ((False, 0.0), (True, 30.0)):
        answer(subject, Question("patch", {"turn": turn}, swap))


def ladder_of_sizes(subject: Subject) -> None:
    """The patch test with 1, 2, 3 and more elements a side, on either."""
    for upper, lower in LADDER:
        answer(subject, Question("patch", {"upper": upper, "lower": lower}))


def hertz(subject: Subject) -> None:
    """A cylinder on a block has Hertz's force, width and pressure."""
    answer(subject, Question("hertz"))


ELEMENT = (patch_test_in_statics, ladder_of_sizes, hertz)


SMALL = (comes_to_its_end, *INVARIANCE)

SCENARIOS: dict[str, tuple[Scenario, ...]] = {
    "contact": (*SMALL, *contact.SCENARIOS),
    "material": SMALL,
    "element": (*SMALL, *ELEMENT),
    "friction": SMALL,
    "enforcement": SMALL,
    "integrator": (*SMALL, *INTEGRATOR),
    "effect": SMALL,
    "case": case.SCENARIOS,
}
