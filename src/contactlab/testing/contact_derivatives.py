"""Derivatives of gaps, slips and forces for Newton's method, compared with differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contactlab.api import ContactMethod, Floats, ImplicitContact, Ints
from contactlab.contact.linearisation import linearised
from contactlab.model.contact.systems import contact_pair
from contactlab.testing.assertions import Check, NotApplicable, agree, require
from contactlab.testing.surfaces import Chains, Rough, curved, flat

STEP = 1e-6  # mm; differences of gaps then err by 1e-9, of forces of some hundred newtons per mm by 1e-7
GAPS, FORCES = 1e-6, 1e-5
SLIPS = {"quadratic edges": 1e-3}
"""Tolerances of slips if start normals turn as projection points move on a parabola: derivatives omit that."""


Answers = tuple[Floats, Floats, Floats]
"""Gaps (c,) and slips (c,) of chosen conditions, slips empty without friction; nodal forces (2N,) of all."""

Bounds = tuple[float, float, float]
"""Tolerances of gaps, slips and nodal forces."""


def answers_of(contact: ImplicitContact, position: Floats, forces: Floats, chosen: Ints) -> Answers:
    """Gaps, slips and forces of all contact pairs at a position (N, 2), with multipliers held at `forces` (r, k)."""
    c = contact.conditions
    contact.evaluate(position)
    c.force[:] = forces
    normal, tangential = np.zeros_like(position), np.zeros((len(position) if len(c.slip) else 0, 2))
    contact.forces(normal, tangential)
    total = normal + tangential if len(tangential) else normal
    return c.gap[chosen].copy(), c.slip[chosen].copy() if len(c.slip) else np.zeros(0), total.ravel()


def against_differences(
    given: Any, answers: Callable[[Floats], Answers], position: Floats, move: Floats, within: Bounds, where: str
) -> None:
    """Raise AssertionError unless `gap`, `slip` and `force` of `given` are derivatives of the answers at a position.

    They are compared along a `move` (N, 2) of all nodes. Differences are of fourth order: normals at vertices turn by
    200 rad/mm, which second-order differences follow to 1e-3.
    """
    ahead, further = ([answers(position + k * s * STEP * move) for s in (1.0, -1.0)] for k in (1.0, 2.0))
    derivatives = given.gap, given.slip, given.force
    of = "derivatives of gaps", "derivatives of slips", "derivatives of nodal forces"
    for derivative, what, near, far, allowed in zip(
        derivatives, of, zip(*ahead, strict=True), zip(*further, strict=True), within, strict=True
    ):
        if len(near[0]):
            told = f"{what} against differences ({where}, along a random move)"
            difference = (8.0 * (near[0] - near[1]) - (far[0] - far[1])) / (12.0 * STEP)
            agree(derivative @ move.ravel(), difference, allowed, told)


class _Trial:
    """A pair of the algorithm, with conditions and forces at positions (N, 2) after a step from others."""

    def __init__(self, algorithm: ContactMethod, at: Chains, friction: bool) -> None:
        self.friction, self.start, nodes = friction, at.nodes, len(at.nodes)
        law, free = Rough() if friction else None, np.zeros(len(at.slave.nodes), np.bool_)
        self.pair = contact_pair("contact", algorithm, (at.slave, at.master), at.nodes, 0, law, free)
        self.linear = linearised(self.pair, nodes)

    def gaps(self, position: Floats) -> Floats:
        """Gaps (k,) of all multipliers; what it remembers is left as it was."""
        self.linear.memory[:] = 0.0
        self.linear.evaluate(position, self.start)
        return np.array(self.pair.gaps[:, 0])

    def answers(self, position: Floats, chosen: Ints, y: Floats) -> Answers:
        """Gaps and slips of the chosen multipliers, and the nodal forces of all for forces y (r, k)."""
        gap = self.gaps(position)[chosen]
        slip = np.array(self.linear.slip[chosen]) if self.friction else np.zeros(0)
        normal, tangential = np.zeros_like(position), np.zeros((len(position) if self.friction else 0, 2))
        self.linear.add_forces(y, normal, tangential)
        return gap, slip, (normal + tangential if self.friction else normal).ravel()


def derivatives_are_right(algorithm: ContactMethod) -> None:
    """Derivatives of gaps, slips and nodal forces match the conditions, with friction and without.

    For an algorithm without derivatives the core's differences are judged instead: they are right if
    tangent weights are normal weights turned by -90 degrees.
    """
    if algorithm.explicit_only:
        raise NotApplicable("the algorithm is for explicit runs alone")
    # surfaces that have moved since the last step, so that nothing is flush or symmetric
    found = {"curved": curved(), "quadratic edges": flat(order=2).turned(0.3), "flat": flat().turned(2.0)}
    draw = np.random.default_rng(4)
    for name, before in found.items():
        at = before.moved(before.nodes + draw.uniform(-0.004, 0.004, before.nodes.shape))
        for friction in (False, True):
            _against_differences(algorithm, at, friction, f"{name}, {'with' if friction else 'without'} friction")


def _against_differences(algorithm: ContactMethod, at: Chains, friction: bool, where: str) -> None:
    trial, draw = _Trial(algorithm, at, friction), np.random.default_rng(2)
    position = at.nodes + draw.uniform(-0.003, 0.003, at.nodes.shape)
    chosen: Ints = np.flatnonzero(np.abs(trial.gaps(position)) < 0.3 * at.spacing).astype(np.int32)
    require(len(chosen) > 2, f"{where}: only {len(chosen)} conditions between surfaces that touch")
    y = np.zeros((2 if friction else 1, trial.pair.slots))
    y[0, chosen] = draw.uniform(1.0, 3.0, len(chosen))
    if friction:
        y[1, chosen] = draw.uniform(-1.0, 1.0, len(chosen))
    move = draw.uniform(-1.0, 1.0, position.shape)
    trial.gaps(position)
    given = trial.linear.linearise(chosen, y)
    within = GAPS, SLIPS.get(where.partition(",")[0], GAPS), FORCES
    against_differences(given, lambda at: trial.answers(at, chosen, y), position, move, within, where)


CHECKS: tuple[Check, ...] = (derivatives_are_right,)
