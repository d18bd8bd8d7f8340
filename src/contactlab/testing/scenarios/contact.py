"""Scenarios of contact algorithms: cases with known answers, either slave, sizes from one element on."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Potential, StepStatus
from contactlab.model.build import build
from contactlab.testing.assertions import NotApplicable, require, tell
from contactlab.testing.partners import usual_motion
from contactlab.testing.scenarios.cases import Question, answer, answer_evenly
from contactlab.testing.scenarios.invariance import SAME
from contactlab.testing.scenarios.runs import half_passes, modes_of, plain, pressed, run
from contactlab.testing.subject import Subject

LADDER = ((1, 1), (1, 2), (2, 1), (2, 3), (3, 2), (8, 13))
"""Segments of the upper and of the lower side."""
INCLINE = {"span": 0.02, "cells": 2}
"""A short watch over a coarse block, whose steps are long: an algorithm in plain NumPy takes a millisecond a step."""
IMPLICIT_STEP, ONE_MOTION = 8e-8, 0.07
"""s, 50 steps for a push; of the displacement: what such steps err by is 4.6 % along x, 2.3 % with half of them."""
NUDGE, DERIVATIVE = 1e-6, 1e-6
"""mm, of differences; relative to the largest: round-off of gaps over the nudge."""
QUADRATIC = {"segments": 6.0}
"""Segments of a half-width that have a node in the middle each: fewer than straight ones."""


def _implicit(subject: Subject) -> None:
    if "statics" not in modes_of(subject):
        raise NotApplicable("the algorithm is for explicit runs alone")


def _patch(subject: Subject, question: Question) -> None:
    """Uniform stress; exact, too, unless sides have to overlap to press."""
    cls = subject.part_class
    overlaps = half_passes(subject) or (issubclass(cls, Potential) and cls.passes_patch_test)
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
    """A block on an incline slides with Coulomb's acceleration, and stays if mu is above tan of the angle."""
    answer(subject, Question("block-on-incline", INCLINE))


def rest_after_a_fall(subject: Subject) -> None:
    """A dropped block comes to rest under its weight; no step of contact makes energy, if the part declares so."""
    question = Question("dropped-block")
    answer(subject, question)
    if not subject.part_class.keeps_energy:
        tell("no contact step made energy here; with keeps_energy = True every check requires that")


def bars_exchange_their_momentum(subject: Subject) -> None:
    """A bar that hits one at rest stops, and leaves it its speed; momentum is kept to round-off."""
    answer(subject, Question("two-bars"))


def friction_alone_holds(subject: Subject) -> None:
    """A block that only friction holds keeps its place under Newton."""
    _implicit(subject)
    if issubclass(subject.part_class, Potential):
        raise NotApplicable("friction of potentials is lagged: it holds no body before surfaces press")
    answer(subject, Question("pulled-block"))


def neither_side_is_the_slave(subject: Subject) -> None:
    """Half passes give the same forces if slave and master are exchanged, with friction, whatever the meshes."""
    _of_half_passes(subject)
    for mode in modes_of(subject):
        other = run(subject, pressed(subject, mode, {"contacts.0.swap": True}), f"{mode}, exchanged")
        found, wanted = (results.summary["reactions"] for results in (other, plain(subject, mode)))
        largest = max(abs(value) for force in wanted.values() for value in force)
        off = max(abs(a - b) for side in wanted for a, b in zip(found[side], wanted[side], strict=True))
        require(
            off <= SAME[mode] * largest,
            f"{mode}: with slave and master exchanged a reaction differs by {off:.2e} N/mm, allowed {SAME[mode]:.0e} "
            f"of {largest:.4g} N/mm",
        )


def explicit_and_implicit_steps_agree(subject: Subject) -> None:
    """Half passes give one motion in explicit and in implicit steps, which share no code of theirs."""
    _of_half_passes(subject)
    explicit = plain(subject, "explicit").displacement
    given = {"integrator": usual_motion(subject.registry), "time.step": IMPLICIT_STEP}
    implicit = run(subject, pressed(subject, "explicit", given), "implicit dynamics").displacement
    off = np.abs(explicit - implicit).max(axis=0) / np.abs(explicit).max(axis=0)
    require(
        float(off.max()) <= ONE_MOTION,
        f"displacements of explicit and implicit steps differ by {off[0]:.3g} of the largest along x, {off[1]:.3g} "
        f"along y, allowed {ONE_MOTION}",
    )


def matrices_are_derivatives(subject: Subject) -> None:
    """Derivatives of gaps, slips and forces of half passes that press and slide agree with differences."""
    _of_half_passes(subject)
    scene = pressed(subject, "statics")
    model: Any = build(scene, subject.registry)
    require(model.bound_integrator().step(1.0 / 3.0).status is StepStatus.accepted, "the first load step failed")
    contact, x = model.contact, model.position.copy()
    contact.begin_step(x, 2.0 / 3.0)
    y = contact.conditions.force.copy()
    chosen = np.flatnonzero(y[0] > 0.0).astype(np.int32)
    here, found = _seen(contact, x, y, chosen), contact.linearise(chosen)
    along = np.random.default_rng(0).normal(size=x.shape)
    pushed = found.normal.T @ y[0, chosen] + found.tangent.T @ y[1, chosen]
    high, low = (_seen(contact, x + shift * along, y, chosen) for shift in (NUDGE, -NUDGE))
    rates = [(a - b) / (2.0 * NUDGE) for a, b in zip(high, low, strict=True)]
    said = [pushed, *(m @ along.ravel() for m in (found.force, found.gap, found.slip))]
    for name, one, other in zip(("directions", "force", "gap", "slip"), said, (here[0], *rates), strict=True):
        off = float(np.abs(one - other).max() / np.abs(other).max())
        require(off <= DERIVATIVE, f"{name}: off by {off:.2g} of the largest, allowed {DERIVATIVE:.0e}")


def _seen(contact: Any, position: Any, y: Any, chosen: Any) -> list[Any]:
    """Forces (2N,) of fixed multipliers, gaps and slips of the chosen multipliers, and node positions."""
    contact.evaluate(position)
    contact.conditions.force[:] = y
    forces = np.zeros((2, *position.shape))
    contact.forces(*forces)
    return [forces.sum(axis=0).ravel(), *(v[chosen].copy() for v in (contact.conditions.gap, contact.conditions.slip))]


def _of_half_passes(subject: Subject) -> None:
    if not half_passes(subject):
        raise NotApplicable("one side is the slave")


SCENARIOS = (
    matrices_are_derivatives,
    neither_side_is_the_slave,
    explicit_and_implicit_steps_agree,
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
