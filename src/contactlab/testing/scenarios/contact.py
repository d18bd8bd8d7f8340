"""Scenarios of contact algorithms: cases with known answers, either slave, sizes from one element on."""

from __future__ import annotations

from contactlab.api import Potential
from contactlab.testing.assertions import NotApplicable, tell
from contactlab.testing.scenarios.cases import Question, answer, answer_evenly
from contactlab.testing.scenarios.runs import modes_of
from contactlab.testing.subject import Subject

LADDER = ((1, 1), (1, 2), (2, 1), (2, 3), (3, 2), (8, 13))
"""Segments of the upper and of the lower side."""
INCLINE = {"span": 0.02, "cells": 2}
"""A short watch over a coarse block, whose steps are long: an algorithm in plain NumPy takes a millisecond a step."""
QUADRATIC = {"segments": 6.0}
"""Segments of a half-width that have a node in the middle each: fewer than straight ones."""


def _implicit(subject: Subject) -> None:
    if "statics" not in modes_of(subject):
        raise NotApplicable("the algorithm is for explicit runs alone")


def _patch(subject: Subject, question: Question) -> None:
    """Uniform stress; exact, too, unless sides have to overlap to press."""
    cls = subject.part_class
    overlaps = issubclass(cls, Potential) and cls.passes_patch_test
    (answer_evenly if overlaps else answer)(subject, question)


def patch_test_in_statics(subject: Subject) -> None:
    """Two blocks under uniform pressure, meshes that do not match: round-off, with either slave and turned."""
    _implicit(subject)
    for swap, turn in ((False, 0.0), (True, 30.0)):
        _patch(subject, Question("patch", {"turn": turn}, swap))


def patch_test_on_quadratic_elements(subject: Subject) -> None:
    """The same with three nodes to a side."""
    _implicit(subject)
    for swap in (False, True):
        _patch(subject, Question("patch", {"upper": 3, "lower": 5}, swap, element=1))


def ladder_of_sizes(subject: Subject) -> None:
    """The patch test with 1, 2, 3 and more elements a side, on either."""
    _implicit(subject)
    for upper, lower in LADDER:
        _patch(subject, Question("patch", {"upper": upper, "lower": lower}))


def hertz(subject: Subject) -> None:
    """A cylinder on a block has Hertz's force, width and pressure."""
    _implicit(subject)
    answer(subject, Question("hertz"))


def hertz_with_the_other_slave(subject: Subject) -> None:
    """The same with the block as slave."""
    _implicit(subject)
    answer(subject, Question("hertz", swap=True))


def hertz_on_quadratic_elements(subject: Subject) -> None:
    """The same with three nodes to a side."""
    _implicit(subject)
    answer(subject, Question("hertz", QUADRATIC, element=1))


def incline_with_its_threshold(subject: Subject) -> None:
    """A block on an incline slides with Coulomb's acceleration, and stays where mu is above tan of the angle."""
    answer(subject, Question("block-on-incline", INCLINE))


def rest_after_a_fall(subject: Subject) -> None:
    """A dropped block comes to rest under its weight; no step of contact makes energy, if the part declares so."""
    question = Question("dropped-block")
    answer(subject, question)
    if not subject.part_class.keeps_energy:
        tell("no step of contact made energy; declare keeps_energy = True")


def bars_exchange_their_momentum(subject: Subject) -> None:
    """A bar that hits one at rest stops, and leaves it its speed; momentum is kept to round-off."""
    answer(subject, Question("two-bars"))


def friction_alone_holds(subject: Subject) -> None:
    """A block that only friction holds keeps its place under Newton."""
    _implicit(subject)
    if issubclass(subject.part_class, Potential):
        raise NotApplicable("friction of potentials is lagged: nothing holds a body before surfaces press")
    answer(subject, Question("pulled-block"))


SCENARIOS = (
    patch_test_in_statics,
    patch_test_on_quadratic_elements,
    ladder_of_sizes,
    hertz,
    hertz_with_the_other_slave,
    hertz_on_quadratic_elements,
    incline_with_its_threshold,
    rest_after_a_fall,
    bars_exchange_their_momentum,
    friction_alone_holds,
)
