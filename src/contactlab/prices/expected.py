"""How long a run will be: steps, Newton iterations and frames, expected and between two bounds, before the first step.

Steps of explicit runs with a fixed end are known. Those that end when they have settled need a period in which nothing
changes after one in which something did, or more; without damping they take all the time that they may. Newton's
iterations depend on how contact finds its edge, and are taken from what is usual; there are none where nothing moves.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contactlab.meshing.inside import distances_to_edges
from contactlab.prices.counts import Length

if TYPE_CHECKING:
    from contactlab.model.contact.pair import ContactPair
    from contactlab.model.model import Model
    from contactlab.run.schedule import Schedule
    from contactlab.scene.scene import Scene

PERIODS = (1.0, 2.0, 6.0)  # that an explicit run takes to settle after its ramp
ALONE = (2.0, 5.0, 8.0)  # where no contact presses them: kinetic energy has to fall below a thousandth of little
ITERATIONS = (1.0 / 3.0, 1.0, 3.0)  # times the usual number
LINEAR, NONLINEAR = 1.0, 3.0  # usual iterations of a load step without contact
CONTACT, FRICTION = 3.0, 3.0  # and further ones where a step goes to the end at once
FOLLOWED = 1.0 / 3.0  # of those, where the way is followed in many steps
DRIVEN, FLYING = 0.5, 0.1  # shares of the slave nodes that touch later
REACH = 1.0  # lengths of a slave's segment: nodes that lie nearer to their master touch it at once


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
        return Expected(*(Length(steps, 0, min(scene.record.frames, steps) + 1) for _ in PERIODS))
    lengths = []
    usual = PERIODS if model.contact is not None else ALONE
    for periods in usual if timing.damping else (math.inf,) * len(usual):
        time = timing.last + min(periods * timing.period, timing.hold)
        lengths.append(Length(time / schedule.first, 0, scene.record.frames * time / timing.last + 1))
    return Expected(*lengths)


def _implicit(scene: Scene, model: Model, schedule: Schedule) -> Expected:
    steps = schedule.estimated_steps()
    linear = all(body.material.kinematics == "small" for body in model.bodies)
    more = (CONTACT if model.contact is not None else 0.0) + (FRICTION if _rubs(scene) else 0.0)
    usual = (LINEAR if linear else NONLINEAR) + more * (1.0 if schedule.skips else FOLLOWED)
    frames = min(scene.record.frames, steps) + 1
    least, expected, most = (max(1.0, usual * factor) * steps for factor in ITERATIONS)
    if not _driven(scene, model):
        least = expected = 0.0
    return Expected(*(Length(steps, iterations, frames) for iterations in (least, expected, most)))


def _rubs(scene: Scene) -> bool:
    return any(contact.friction for contact in scene.contacts)


def touching(scene: Scene, model: Model) -> tuple[float, float, float]:
    """Mean share of slave nodes that touch during the run: at least, as expected, at most.

    Those that touch from the start go on. Of the others half come in touch where something is driven, and few where
    bodies fly: nobody knows before.
    """
    if model.contact is None:
        return 1.0, 1.0, 1.0
    near = np.concatenate([_near(pair, model) for pair in model.contact.pairs])
    share = float(near.mean()) if len(near) else 1.0
    later = DRIVEN if scene.loads or _moved(model) else FLYING
    return share, share + later * (1.0 - share), 1.0


def _driven(scene: Scene, model: Model) -> bool:
    """Whether anything takes the bodies out of their balance."""
    return bool(scene.loads or scene.effects) or _moved(model)


def _moved(model: Model) -> bool:
    """Whether supports are."""
    prescribed = model.prescribed
    return bool(np.any(prescribed.values(0.0).copy() != prescribed.values(model.timing.last)))


def _near(pair: ContactPair, model: Model) -> np.ndarray:
    """Whether each slave node lies within reach of its master before the run (m,)."""
    reference = model.reference
    slave, master = reference[pair.slave.nodes], pair.master
    ends = reference[pair.slave.nodes[pair.slave.segments]]
    reach = REACH * float(np.median(np.hypot(*(ends[:, 1] - ends[:, 0]).T)))
    begin, end = (reference[master.nodes[master.segments[:, k]]] for k in range(2))
    return distances_to_edges(slave, begin, end) <= reach
