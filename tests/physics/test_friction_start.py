"""Where friction alone holds a body, load steps begin with nodes that stick, before anything is pressed."""

from __future__ import annotations

import pytest

from contactlab.api import Record, Setup
from contactlab.cases.run_case import evaluated, run_case
from contactlab.cases.verdict import judge
from contactlab.parts.registry import default_registry


def run(name: str, algorithm: str, swap: bool = False, **fields: float) -> tuple[str, Record]:
    """The verdict of a case and the record of its last run."""
    case = default_registry().make("case", {"use": name, **fields})
    setup = Setup(algorithm, swap=swap, element=case.elements[0], integrator="newton")
    _, done = run_case(case, setup)
    return judge(case, setup, done, evaluated(case, setup, done)).verdict, list(done.values())[-1]


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
@pytest.mark.parametrize("angle", [20.0, 30.0])
def test_a_layer_on_a_slope_is_held_from_the_first_iteration(algorithm: str, angle: float) -> None:
    """mu = 0.8 holds on both slopes; without friction at the start it slides by 0.2 % of its stress, or for good."""
    verdict, record = run("inclined-layers", algorithm, angle=angle, mu=0.8)
    assert verdict == "met"
    assert set(record.curve().state) == {1}  # every node sticks
    assert float(abs(record.reaction("upper.top")[1])) == pytest.approx(1e-2, rel=1e-9)
    assert record.summary["iterations"] <= 2 * record.summary["steps"]


def test_rings_that_stick_need_no_search_for_what_sticks() -> None:
    """All nodes stick under an even load; a start from slip found them one by one, in 80 iterations and more."""
    verdict, record = run("stuck-rings", "mortar-p1", swap=True)
    assert verdict == "met"
    assert record.summary["iterations"] <= 3


def test_what_friction_cannot_hold_slips() -> None:
    """mu = 0.2 on a slope of 30 degrees: nodes that stick at first let go."""
    verdict, record = run("inclined-layers", "mortar-p1", mu=0.2)
    assert verdict == "met"
    assert set(record.curve().state) == {2}
