"""How long a run will be: steps and Newton iterations, expected and between two bounds, before the first step.

Steps of explicit runs with a fixed end are known. Those that end when they have settled need a period in which nothing
changes after one in which something did, or more; without damping they take all the time that they may. Newton's
iterations depend on how contact finds its edge, and are taken from what is usual; there are none where nothing moves.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from contactlab.model.model import Model
    from contactlab.run.schedule import Schedule
    from contactlab.scene.scene import Scene

PERIODS = (1.0, 2.0, 6.0)  # that an explicit run takes to settle after its ramp
ALONE = (2.0, 5.0, 8.0)  # where no contact presses them: kinetic energy has to fall below a thousandth of little
ITERATIONS = (1.0 / 3.0, 1.0, 3.0)  # times the usual number
LINEAR, NONLINEAR = 1.0, 3.0  # usual iterations of a load step without contact
CONTACT, FRICTION = 3.0, 3.0  # and further ones where a step goes to the end at once
FOLLOWED = 1.0 / 3.0  # of those, where the way is followed in many steps


class Length(NamedTuple):
    """How long a run is: steps, and Newton iterations of all of them (0 in explicit runs)."""

    steps: float
    iterations: float


class Expected(NamedTuple):
    """Something at least, as expected, and at most."""

    least: Length
    usual: Length
    most: Length


def expected_length(scene: Scene, model: Model, schedule: Schedule) -> Expected:
    """Lengths of a run of a scene."""
    if not model.explicit:
        return _implicit(scene, model, schedule)
    timing = model.timing
    if not timing.until_settled:
        steps = schedule.estimated_steps()
        return Expected(*(Length(steps, 0.0) for _ in PERIODS))
    lengths = []
    usual = PERIODS if model.contact is not None else ALONE
    for periods in usual if timing.damping else (math.inf,) * len(usual):
        time = timing.last + min(periods * timing.period, timing.hold)
        lengths.append(Length(time / schedule.first, 0.0))
    return Expected(*lengths)


def _implicit(scene: Scene, model: Model, schedule: Schedule) -> Expected:
    steps = schedule.estimated_steps()
    linear = all(body.material.kinematics == "small" for body in model.bodies)
    more = (CONTACT if model.contact is not None else 0.0) + (FRICTION if _rubs(scene) else 0.0)
    usual = (LINEAR if linear else NONLINEAR) + more * (1.0 if schedule.skips else FOLLOWED)
    least, expected, most = (max(1.0, usual * factor) * steps for factor in ITERATIONS)
    if not _driven(scene, model):
        least = expected = 0.0
    return Expected(*(Length(steps, iterations) for iterations in (least, expected, most)))


def _rubs(scene: Scene) -> bool:
    return any(contact.friction for contact in scene.contacts)


def _driven(scene: Scene, model: Model) -> bool:
    """Whether anything takes the bodies out of their balance."""
    return bool(scene.loads or scene.effects) or _moved(model)


def _moved(model: Model) -> bool:
    """Whether supports are."""
    prescribed = model.prescribed
    return bool(np.any(prescribed.values(0.0).copy() != prescribed.values(model.timing.last)))
