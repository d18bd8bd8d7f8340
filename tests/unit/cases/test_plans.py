"""What cases plan, and with which fields they make no sense."""

from __future__ import annotations

from typing import Any

import pytest

from contactlab.api import Case, Record, Setup
from contactlab.parts.registry import default_registry


def case(name: str, **fields: Any) -> Case:
    found: Case = default_registry().make("case", {"use": name, **fields})
    return found


def setup(of: Case) -> Setup:
    return Setup("mortar-p1", element=of.elements[0], integrator=of.integrators[0])


def test_both_orders_of_a_stack_take_the_same_steps() -> None:
    """Forces are compared step by step: with unlike ends the steps have unlike lengths, and times drift apart."""
    stack = case("stack")
    jobs = stack.plan(setup(stack), {})
    ends = {job.scene["time"]["end"] for job in jobs if not isinstance(job.scene, str)}
    assert len(jobs) == 2
    assert len(ends) == 1


@pytest.mark.parametrize(("speed", "spin"), [(0.0, 0.0), (100.0, -10.0)])
def test_a_disc_that_rolls_from_the_start_is_left_out(speed: float, spin: float) -> None:
    disc = case("rolling-disc", speed=speed, spin=spin)
    assert "rolls" in disc.applies(setup(disc))
    thrown = case("rolling-disc", speed=speed + 1.0, spin=spin)
    assert not thrown.applies(setup(thrown))


def test_a_lifted_beam_may_miss_its_length_by_a_cell() -> None:
    """The bound is over the length that is lifted, which is shorter where the end is lifted less."""
    bounds = []
    for lift in (0.2, 1.0):
        beam = case("lifted-beam", lift=lift)
        (length,) = (m for m in beam.measures(setup(beam)) if m.name == "length that is lifted")
        bounds.append(length.most - 0.01)
    assert bounds[0] / bounds[1] == pytest.approx(0.2**-0.25)


def test_a_rung_is_compared_with_statics_only_where_it_came_to_rest() -> None:
    """Statics of a run that chatters for ever would cost more than the run, and be compared with nothing."""
    ladder = case("mesh-ladder")
    first = ladder.plan(setup(ladder), {})
    assert [job.name for job in first] == ["explicit"]
    for status, following in (("finished", ["static"]), ("not-converged", [])):
        done = {"explicit": Record(status, "", {})}
        assert [job.name for job in ladder.plan(setup(ladder), done)] == following
