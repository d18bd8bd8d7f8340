"""Whether prescribed motion leaves any room for what lies between: an indentation deeper than the bodies is refused."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.errors import SceneError
from contactlab.model.bodies.body import Body
from contactlab.model.loading.supports import Prescribed

if TYPE_CHECKING:
    from contactlab.model.loading.rigid import RigidSurface
    from contactlab.scene.scene import Scene

SAMPLES = 33  # times at which motion is looked at: ramps have one way to go, tables a few corners


class _Held(NamedTuple):
    """The nodes of a body or rigid surface that are moved along an axis.

    low, high  (times, 2) [mm] bounds of where they are
    """

    name: str
    nodes: Ints
    low: Floats
    high: Floats


def check_approach(
    scene: Scene,
    bodies: tuple[Body, ...],
    rigid: tuple[RigidSurface, ...],
    reference: Floats,
    prescribed: Prescribed,
    end: float,
) -> None:
    """Raise SceneError where what holds one body is to pass through what holds another that contact joins to it.

    Of each two only what is sure counts: along an axis all held nodes of one lie on one side of those of the other,
    and later all on the other side, while their places across overlap all the time.
    """
    every: list[Any] = [*bodies, *rigid]
    by_axis = [[_held(part, prescribed, axis) for part in every] for axis in range(2)]
    _follow([one for held in by_axis for one in held], reference, prescribed, end)
    for group in _joined(scene, [part.name for part in every]):
        for axis, held in enumerate(by_axis):
            for a, b in combinations([one for one in held if one.name in group], 2):
                _refuse_passing(scene, a, b, axis)


def _held(part: Any, prescribed: Prescribed, axis: int) -> _Held:
    own = prescribed.dof[(prescribed.dof >= 2 * part.first) & (prescribed.dof < 2 * (part.first + part.count))]
    return _Held(part.name, own[own % 2 == axis] // 2, np.zeros((SAMPLES, 2)), np.zeros((SAMPLES, 2)))


def _follow(held: list[_Held], reference: Floats, prescribed: Prescribed, end: float) -> None:
    """Fill the bounds: where the rest of a body is, nobody knows yet. One time after the other, for the memory."""
    for number, time in enumerate(np.linspace(0.0, end, SAMPLES)):
        place = reference.copy()
        place.ravel()[prescribed.dof] += prescribed.scale * prescribed.values(float(time))[prescribed.ramp]
        for one in held:
            one.low[number] = place[one.nodes].min(axis=0, initial=np.inf)
            one.high[number] = place[one.nodes].max(axis=0, initial=-np.inf)


def _joined(scene: Scene, names: list[str]) -> list[set[str]]:
    """Names of bodies and rigid surfaces in groups that contacts join, directly or one through another."""
    groups = [{name} for name in names]
    for contact in scene.contacts:
        touched = {target.partition(".")[0] for side in contact.targets for target in side}
        both = set().union(*(group for group in groups if group & touched))
        groups = [group for group in groups if not group & touched] + [both]
    return [group for group in groups if len(group) > 1]


def _refuse_passing(scene: Scene, a: _Held, b: _Held, axis: int) -> None:
    if not len(a.nodes) or not len(b.nodes):
        return
    (below, above), across = ((a, b) if a.low[0, axis] < b.low[0, axis] else (b, a)), 1 - axis
    room = above.low[:, axis] - below.high[:, axis]
    width = np.minimum(a.high[:, across], b.high[:, across]) - np.maximum(a.low[:, across], b.low[:, across])
    left = above.high[:, axis] - below.low[:, axis]
    if room[0] <= 0.0 or not left.min() <= 0.0 or not width[: int(np.argmax(left <= 0.0)) + 1].min() > 0.0:
        return
    raise SceneError(
        f"what holds {a.name} and what holds {b.name} would pass through each other along {'xy'[axis]}",
        where=scene.where("supports"),
        got=f"they come {room[0] - room.min():.4g} mm closer",
        allowed=f"less than the {room[0]:.4g} mm between them, which the bodies fill",
        hint="press less deep, or hold less of the bodies",
    )
