"""Scenarios of elements: the patch test with contact, sizes from one element on, Hertz."""

from __future__ import annotations

from contactlab.testing.scenarios.cases import Question, answer
from contactlab.testing.scenarios.contact import LADDER
from contactlab.testing.subject import Subject


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


SCENARIOS = (patch_test_in_statics, ladder_of_sizes, hertz)
