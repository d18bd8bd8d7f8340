"""Scenarios of integrators: two free bodies in contact."""

from __future__ import annotations

from contactlab.api import ExplicitIntegrator
from contactlab.cases.verdict import allowed
from contactlab.testing.assertions import NotApplicable, require
from contactlab.testing.scenarios.cases import Question, answer, found_of
from contactlab.testing.subject import Subject

BARS = Question("two-bars")


def bars_exchange_their_momentum(subject: Subject) -> None:
    """A bar that hits one at rest stops, and leaves it its speed; momentum is kept to round-off."""
    cls = subject.part_class
    if not cls.inertia:
        raise NotApplicable("the integrator has no inertia: free bodies have no equilibrium")
    if issubclass(cls, ExplicitIntegrator) and cls.velocity_lag == 0.5:
        answer(subject, BARS)
        return
    # waves of one cell in a step are exact in a leapfrog alone, and so is the energy that the case looks at
    found = found_of(subject, BARS)
    require(found.status == "finished", f"two-bars: the run ended as {found.status}: {found.reason}")
    for judged in found.judged:
        if "momentum" in judged.measure.name:
            said = f"two-bars: {judged.measure.name} is {judged.value:.3g}, allowed {allowed(judged.measure)}"
            require(judged.verdict == "met", said)


SCENARIOS = (bars_exchange_their_momentum,)
