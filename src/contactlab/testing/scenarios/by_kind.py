"""Which scenarios a kind of part is put to."""

from __future__ import annotations

from contactlab.testing.scenarios import Scenario, case, contact, element, integrator
from contactlab.testing.scenarios.invariance import INVARIANCE, comes_to_its_end

SMALL = (comes_to_its_end, *INVARIANCE)

SCENARIOS: dict[str, tuple[Scenario, ...]] = {
    "contact": (*SMALL, *contact.SCENARIOS),
    "material": SMALL,
    "element": (*SMALL, *element.SCENARIOS),
    "friction": SMALL,
    "enforcement": SMALL,
    "integrator": (*SMALL, *integrator.SCENARIOS),
    "effect": SMALL,
    "case": case.SCENARIOS,
}
