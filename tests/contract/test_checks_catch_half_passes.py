"""Two half passes are the core's own: the check of an algorithm that asks for them finds defects planted there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.contact import half_passes
from contactlab.contact.half_passes import HalfPassContactSystem, HalfPassLinearisation, HalfPassResponse
from contactlab.contact.linearisation import PairLinearisation
from contactlab.contact.points_pair import PointsPair
from contactlab.model.contact import cells_behind
from contactlab.parts.registry import default_registry
from contactlab.testing.run import run_check
from contactlab.testing.scenarios import Scenario, contact
from contactlab.testing.subject import Subject

Plant = Callable[[pytest.MonkeyPatch], None]
SLAVE, MOTION = contact.neither_side_is_the_slave, contact.explicit_and_implicit_steps_agree
PATCH, MATRICES = contact.patch_test_in_statics, contact.matrices_are_derivatives


def around(cls: type[Any], name: str, wrong: Callable[..., Any]) -> Plant:
    """A method that is called by `wrong(right, self, *given)`."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        right = getattr(cls, name)
        patch.setattr(cls, name, lambda self, *given: wrong(right, self, *given))

    return plant


def instead(place: Any, name: str, wrong: Callable[[Any], Any]) -> Plant:
    """Something that `wrong` makes of what is there."""
    return lambda patch: patch.setattr(place, name, wrong(getattr(place, name)))


# --- steps that iterate ---------------------------------------------------------------------------------


def forces(factor: float) -> Plant:
    """Nodal forces of the second pass times a factor."""

    def wrong(right: Any, self: Any, multipliers: Any, normal: Any, tangential: Any) -> None:
        found = np.zeros_like(normal), np.zeros_like(tangential)
        right(self, multipliers, *found)
        for out, force in zip((normal, tangential), found, strict=True):
            out += (factor if self.pair.second else 1.0) * force

    return around(HalfPassLinearisation, "add_forces", wrong)


def lengths_of_the_other_side(right: Any, self: Any, multipliers: Any, *out: Any) -> None:
    right(self, multipliers * len(self.pair.master.segments) / len(self.pair.slave.segments), *out)


def uneven(nodes: Any) -> Any:
    return np.linspace(0.9, 1.1, len(nodes))


def no_directions_of_the_second_pass(right: Any, self: Any, *given: Any) -> Any:
    found = right(self, *given)
    return found._replace(normal=0.0 * found.normal) if self.pair.second else found


def no_turns(right: Any, self: Any, *given: Any) -> Any:
    found = right(self, *given)
    return found._replace(force=0.0 * found.force)


def friction_of_the_first_pass(right: Any, self: Any, c: Any, out: Any) -> None:
    first = np.arange(len(c.gap)) < len(c.gap) // 2
    right(self, replace(c, bound=c.bound * first), out)


def no_history(right: Any, self: Any, c: Any, out: Any) -> None:
    right(self, replace(c, anchor=0.0 * c.anchor), out)


def history_of_the_first_pass(right: Any, self: Any, c: Any, out: Any) -> None:
    anchor, half = c.anchor.copy(), len(c.gap) // 2
    both = min(half, len(c.gap) - half)
    anchor[1, half : half + both] = anchor[1, :both]
    right(self, replace(c, anchor=anchor), out)


# --- explicit steps -------------------------------------------------------------------------------------


def made(change: Callable[[Any], Any]) -> Plant:
    """The system, changed when it has been made."""

    def wrong(right: Any, self: Any, *given: Any) -> None:
        right(self, *given)
        change(self)

    return around(HalfPassContactSystem, "__init__", wrong)


def whole_passes(system: Any) -> None:
    system.acts[:] = True


def passes_of_the_other_side(system: Any) -> None:
    system.acts[:] = system.acts[::-1].copy()


def one_side_without_forces(system: Any) -> None:
    system.acts[1] = False


def springs_in_one_pass(system: Any) -> None:
    system.half = system.half & (system.of_pass == 0)


def springs_forget(right: Any, self: Any, *given: Any) -> Any:
    self.rubbed[:] = 0.0
    return right(self, *given)


# --- what reports show ----------------------------------------------------------------------------------


def halves(right: Any, self: Any) -> Any:
    slave, multiplier, hats = right(self)
    return slave, multiplier, 0.5 + 0.0 * hats


DEFECTS: dict[str, tuple[Plant, Scenario]] = {
    "one side has no forces": (forces(0.0), SLAVE),
    "one side is pulled by a tenth": (forces(-0.1), SLAVE),
    "one side counts a tenth too much": (forces(1.1), SLAVE),
    "both sides take the forces of a pass": (
        instead(HalfPassLinearisation, "add_forces", lambda right: PairLinearisation.add_forces), PATCH,
    ),
    "lengths of the other side": (around(HalfPassLinearisation, "add_forces", lengths_of_the_other_side), PATCH),
    "directions of one pass alone": (
        around(HalfPassLinearisation, "linearise", no_directions_of_the_second_pass), MATRICES,
    ),
    "turns of normals are lost": (around(HalfPassLinearisation, "linearise", no_turns), MATRICES),
    "nodes as stiff as their own cells": (
        instead(cells_behind, "in_series", lambda right: lambda *sides: right(*sides) * uneven(sides[0])), PATCH,
    ),
    "friction in one pass alone": (around(HalfPassResponse, "rub", friction_of_the_first_pass), SLAVE),
    "slips of one pass are those of both": (around(HalfPassResponse, "rub", history_of_the_first_pass), SLAVE),
    "friction forgets where it was": (
        around(HalfPassResponse, "rub", no_history), MOTION,
    ),
    "friction that gives way": (
        instead(half_passes, "shear_stiffness", lambda right: lambda *given: 0.01 * right(*given)), MOTION,
    ),
    "explicit: both sides take the forces of a pass": (made(whole_passes), MOTION),
    "explicit: each side takes those of the other": (made(passes_of_the_other_side), MOTION),
    "explicit: one side has no forces": (made(one_side_without_forces), MOTION),
    "explicit: what sticks in one pass sticks exactly": (made(springs_in_one_pass), MOTION),
    "explicit: friction forgets where it was": (
        around(HalfPassContactSystem, "_springs", springs_forget), MOTION,
    ),
    "explicit: friction that drives": (
        around(HalfPassContactSystem, "_springs", lambda right, self, *given: -right(self, *given)), MOTION,
    ),
    "explicit: friction that gives way": (
        instead(half_passes, "shear_stiffness", lambda right: lambda *given: 0.01 * right(*given)), MOTION,
    ),
    "nodes have the half of each point": (around(PointsPair, "_shares", halves), contact.hertz),
}  # fmt: skip
QUICK = {"lengths of the other side", "directions of one pass alone"}
"""Those that every tier plants, one for each check that is quick; all others only the full one."""


@pytest.fixture(scope="module")
def subject() -> Subject:
    """The algorithm as it is, with the runs that checks have made of it."""
    return Subject(default_registry(), "contact", "gauss-point", {"passes": 2})


@pytest.fixture(scope="module")
def right(subject: Subject) -> Callable[[Scenario], Subject]:
    """right(check): the algorithm, which this check and those before have passed."""

    @cache
    def passed(check: Scenario) -> Subject:
        assert check in (PATCH, contact.hertz) or run_check(check, subject).status == "passed"
        return subject

    return passed


@pytest.mark.parametrize("name", some(DEFECTS, QUICK))
def test_a_defect_of_half_passes_is_found(
    name: str, right: Callable[[Scenario], Subject], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs that a defect does not touch are those of the right one."""
    plant, check = DEFECTS[name]
    touched = ("explicit",) if name.startswith("explicit") else ("statics", "implicit")
    made = right(check)
    kept = {what: results for what, results in made.results.items() if not what.startswith(touched)}
    plant(monkeypatch)
    outcome = run_check(check, replace(made, results=kept))
    assert outcome.status == "failed"
    assert len(outcome.reason) > 20, "a failure must say what is wrong"
